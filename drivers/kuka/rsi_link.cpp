#include "drivers/kuka/rsi_link.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <thread>
#include <utility>

#include "drivers/kuka/rsi_port.hpp"

namespace truepose::drivers {
namespace {

constexpr std::size_t kStackBytes = 256 * 1024;  // touched before the first datagram
// What others send is read at this pace: the longest take a twentieth of a cycle, and what comes faster is
// the kernel's to drop.
constexpr int kMaxForeignPerCycle = 16;

std::string error_text() { return std::strerror(errno); }

/// Asks for what the calling thread needs to meet the cycle. @return what was refused, empty = nothing
std::string enter_realtime(int priority) {
  if (priority <= 0) return {};
  std::string refused;
  const sched_param parameters{.sched_priority = priority};
  if (::sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) {
    refused = "SCHED_FIFO " + std::to_string(priority) + " refused (" + error_text() +
              "; raise the limit rtprio, LimitRTPRIO= in the unit)";
  }
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    refused += (refused.empty() ? "" : ", ") + std::string{"memory not locked ("} + error_text() +
               "; raise the limit memlock, LimitMEMLOCK= in the unit)";
  }
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  return refused;
}

/// CPU time of the calling thread.
Duration cpu_time() noexcept {
  timespec time;
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec};
}

[[gnu::noinline]] void touch_stack() {
  std::array<volatile char, kStackBytes> pages;
  for (std::size_t i = 0; i < pages.size(); i += 4096) pages[i] = 0;
}

class UdpRsiLink final : public RsiLink {
 public:
  UdpRsiLink(RsiPort port, const RsiLinkOptions& options, RsiResponder& responder)
      : port_{std::move(port)}, responder_{responder} {
    thread_ = std::jthread{[this, options](const std::stop_token& stop) { run(stop, options); }};
    started_.wait(false);
  }

  std::uint16_t port() const override { return port_.number(); }
  Scheduling scheduling() const override { return scheduling_of(thread_id_); }
  std::string refused() const override { return refused_; }
  const std::optional<std::string>& not_pinned() const { return not_pinned_; }

  std::uint64_t heartbeats() const override { return heartbeats_.load(); }

  Counters counters() const override {
    return {received_.load(), answered_.load(), unanswered_.load(), truncated_.load(), send_failed_.load()};
  }

 private:
  void run(const std::stop_token& stop, const RsiLinkOptions& options) {
    thread_id_ = ::gettid();
    if (options.cpu >= 0) not_pinned_ = pin_to(options.cpu);
    refused_ = enter_realtime(options.priority);
    touch_stack();
    started_ = true;
    started_.notify_one();
    for (; !stop.stop_requested(); ++heartbeats_) serve();
  }

  void serve() noexcept {
    auto datagram = port_.receive();
    const TimePoint looked = std::chrono::steady_clock::now();
    if (!datagram) datagram = port_.receive_pending();  // a thread that was kept from running is woken late
    if (datagram) {
      answer(*datagram);
    } else {
      responder_.on_no_datagram(looked);
      port_.expect_any_port();  // silent for so long, the controller may come back with another one
    }
    for (int i = 0; i < kMaxForeignPerCycle; ++i) {
      const auto other = port_.receive_foreign();
      if (!other) return;
      answer(*other);
    }
  }

  void answer(const RsiPort::Received& datagram) noexcept {
    ++received_;
    if (datagram.cut) {
      ++truncated_;
      return;
    }
    const std::string_view reply = responder_.answer(datagram.datagram);
    const TimePoint ready = std::chrono::steady_clock::now();
    // The controller's source port is not the configured one, and only this one listens.
    const bool sent = !reply.empty() && port_.send(reply, datagram.datagram.source);
    finish(datagram, ready, sent);
    ++(sent ? answered_ : reply.empty() ? unanswered_ : send_failed_);
    if (!reply.empty()) port_.expect(datagram.datagram.source);
  }

  void finish(const RsiPort::Received& datagram, TimePoint ready, bool sent) noexcept {
    const TimePoint now = std::chrono::steady_clock::now();
    const Duration ran_before = std::exchange(ran_, cpu_time());
    responder_.finish({.received = datagram.datagram.received,
                       .taken = datagram.taken,
                       .ready = ready,
                       .sent = now,
                       .ran = ran_ - ran_before,
                       .replied = sent});
  }

  RsiPort port_;
  RsiResponder& responder_;
  pid_t thread_id_ = 0;                    // until `started_` written by the thread,
  std::optional<std::string> not_pinned_;  // then constant
  std::string refused_;
  Duration ran_{0};  // the thread's own
  std::atomic<bool> started_{false};
  std::atomic<std::uint64_t> heartbeats_{0};
  std::atomic<std::uint64_t> received_{0}, answered_{0}, unanswered_{0}, truncated_{0}, send_failed_{0};
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace

std::expected<std::unique_ptr<RsiLink>, StartFailure> RsiLink::start(const RsiLinkOptions& options,
                                                                     RsiResponder& responder) {
  auto port = RsiPort::bind(options.address, options.port, options.controller);
  if (!port) return std::unexpected(port.error());
  auto link = std::make_unique<UdpRsiLink>(std::move(*port), options, responder);
  if (link->not_pinned()) return std::unexpected(*link->not_pinned());
  if (options.require_realtime && !link->refused().empty())
    return std::unexpected("RSI needs real-time scheduling and does not get it: " + link->refused());
  return link;
}

}  // namespace truepose::drivers
