#include "drivers/kuka/rsi_link.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "drivers/kuka/rsi_port.hpp"

namespace truepose::drivers {
namespace {

constexpr std::size_t kStackBytes = 256 * 1024;  // touched before the first datagram
// What others send is read at this pace: the longest take a twentieth of a cycle, and what comes faster is
// the kernel's to drop.
constexpr int kOthersATurn = 16;

std::string error_text() { return std::strerror(errno); }

struct Scheduling {
  bool complete = true;
  std::string text;
};

/// Asks for what the calling thread needs to meet the cycle, and tells what was refused.
Scheduling enter_realtime(int priority) {
  if (priority <= 0) return {true, "ordinary scheduling"};
  Scheduling result;
  const sched_param parameters{.sched_priority = priority};
  if (::sched_setscheduler(0, SCHED_FIFO, &parameters) == 0) {
    result.text = "SCHED_FIFO " + std::to_string(priority);
  } else {
    result.complete = false;
    result.text = "ordinary scheduling (SCHED_FIFO " + std::to_string(priority) +
                  " refused: " + error_text() + "; raise the limit rtprio, LimitRTPRIO= in the unit)";
  }
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) == 0) {
    result.text += ", memory locked";
  } else {
    result.complete = false;
    result.text +=
        ", memory not locked (" + error_text() + "; raise the limit memlock, LimitMEMLOCK= in the unit)";
  }
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  return result;
}

[[gnu::noinline]] void touch_stack() {
  std::array<volatile char, kStackBytes> pages;
  for (std::size_t i = 0; i < pages.size(); i += 4096) pages[i] = 0;
}

class UdpRsiLink final : public RsiLink {
 public:
  UdpRsiLink(RsiPort port, const RsiLinkOptions& options, RsiResponder& responder)
      : port_{std::move(port)}, responder_{responder} {
    thread_ = std::jthread{
        [this, priority = options.priority](const std::stop_token& stop) { run(stop, priority); }};
    started_.wait(false);
  }

  std::uint16_t port() const override { return port_.number(); }
  std::string scheduling() const override { return scheduling_.text; }
  bool realtime() const { return scheduling_.complete; }

  std::uint64_t heartbeats() const override { return heartbeats_.load(); }

  Counters counters() const override {
    return {received_.load(), answered_.load(), unanswered_.load(), truncated_.load(), send_failed_.load()};
  }

 private:
  void run(const std::stop_token& stop, int priority) {
    scheduling_ = enter_realtime(priority);
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
      responder_.nothing_came(looked);
      port_.expect_any_port();  // silent for so long, the controller may come back with another one
    }
    for (int i = 0; i < kOthersATurn; ++i) {
      const auto other = port_.receive_from_others();
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
    if (reply.empty()) {
      ++unanswered_;
      return;
    }
    // The controller's source port is not the configured one, and only this one listens.
    const bool sent = port_.send(reply, datagram.datagram.source);
    ++(sent ? answered_ : send_failed_);
    port_.expect(datagram.datagram.source);
  }

  RsiPort port_;
  RsiResponder& responder_;
  Scheduling scheduling_;  // written before started_
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
  if (options.require_realtime && !link->realtime()) {
    return std::unexpected("RSI needs real-time scheduling and does not get it: " + link->scheduling());
  }
  return link;
}

}  // namespace truepose::drivers
