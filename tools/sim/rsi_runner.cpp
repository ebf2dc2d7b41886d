#include "tools/sim/rsi_runner.hpp"

#include <poll.h>
#include <pthread.h>
#include <sched.h>

#include <array>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cerrno>
#include <ctime>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace truepose::sim {
namespace {

using boost::asio::ip::udp;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

/// Below the daemon's, so that a simulator on the same machine cannot delay the answers that it waits for.
constexpr int kPriority = 60;

timespec to_timespec(nanoseconds t) {
  const auto s = std::chrono::floor<std::chrono::seconds>(t);
  return {.tv_sec = s.count(), .tv_nsec = (t - s).count()};
}

/// The steady clock is CLOCK_MONOTONIC here.
void sleep_until(steady_clock::time_point when) {
  const timespec until = to_timespec(when.time_since_epoch());
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace

class RsiRunner::Session {
 public:
  Session(const RsiRunnerOptions& options, RsiClient client, std::function<void(RsiEnd)> ended)
      : target_{boost::asio::ip::make_address(options.host), options.port},
        socket_{context_, udp::endpoint{target_.protocol(), 0}},
        cycle_{options.cycle},
        client_{std::move(client)},
        ended_{std::move(ended)},
        arm_{client_.axes(), client_.moving()} {
    socket_.non_blocking(true);
    statistics_.sessions = 1;
    thread_ = std::thread{[this] { run(); }};
    const sched_param fifo{.sched_priority = kPriority};
    pthread_setschedparam(thread_.native_handle(), SCHED_FIFO,
                          &fifo);  // refused without the right: then as it is
  }

  ~Session() { stop(); }

  void stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

  Arm arm() const {
    const std::lock_guard lock{mutex_};
    return arm_;
  }

  RsiStatistics statistics() const {
    const std::lock_guard lock{mutex_};
    return statistics_;
  }

  void drop(std::chrono::milliseconds duration) { dropping_until_ = steady_clock::now() + duration; }

 private:
  void run() {
    std::optional<RsiEnd> end;
    steady_clock::time_point tick = steady_clock::now();
    while (!end && !stopping_) {
      send(client_.begin_cycle());
      tick += cycle_;
      receive_until(tick);
      sleep_until(tick);
      receive_pending();  // what came before this thread was woken is in time: its delay is not the PC's
      end = client_.end_cycle();

      const steady_clock::time_point now = steady_clock::now();
      // A controller's clock never stands still. Where ours did, the next cycle still gets its whole length.
      const bool overrun = now - tick > cycle_ / 2;
      if (overrun) tick = now;
      publish(end, overrun);
    }
    if (end) ended_(*end);
  }

  void send(std::string_view datagram) {
    sent_[sent_count_++ % sent_.size()] = steady_clock::now();
    boost::system::error_code lost;  // as on a wire, nobody is told
    if (!dropping()) socket_.send_to(boost::asio::buffer(datagram), target_, 0, lost);
  }

  /// Returns early once the cycle has its answer: nothing else can come that would matter.
  void receive_until(steady_clock::time_point deadline) {
    for (;;) {
      receive_pending();
      const nanoseconds left = deadline - steady_clock::now();
      if (client_.answered() || left <= nanoseconds{0}) return;
      const timespec timeout = to_timespec(left);
      pollfd readable{.fd = socket_.native_handle(), .events = POLLIN, .revents = 0};
      ppoll(&readable, 1, &timeout, nullptr);
    }
  }

  void receive_pending() {
    for (;;) {
      boost::system::error_code none;
      udp::endpoint from;
      const std::size_t size = socket_.receive_from(boost::asio::buffer(buffer_), from, 0, none);
      if (none) return;
      const steady_clock::time_point received = steady_clock::now();
      if (dropping()) continue;
      const RsiClient::Verdict verdict = client_.receive({buffer_.data(), size});
      const bool timed = verdict.reply == RsiClient::Reply::Valid || verdict.reply == RsiClient::Reply::Late;
      if (timed && verdict.cycles_ago < sent_.size()) {
        const nanoseconds turnaround =
            received - sent_[(sent_count_ - 1 - verdict.cycles_ago) % sent_.size()];
        const std::lock_guard lock{mutex_};
        statistics_.turnaround.record(turnaround);
      }
    }
  }

  void publish(std::optional<RsiEnd> end, bool overrun) {
    const std::lock_guard lock{mutex_};
    arm_ = {client_.axes(), client_.moving() && !end};
    statistics_.counters = client_.counters();
    statistics_.timeouts += end == RsiEnd::Timeout;
    statistics_.overruns += overrun;
  }

  bool dropping() const { return steady_clock::now() < dropping_until_.load(); }

  boost::asio::io_context context_{1};
  udp::endpoint target_;
  udp::socket socket_;
  nanoseconds cycle_;
  RsiClient client_;  // the thread's alone
  std::function<void(RsiEnd)> ended_;
  std::array<char, 65536> buffer_{};
  std::array<steady_clock::time_point, 1024> sent_{};
  std::uint64_t sent_count_ = 0;
  std::atomic<steady_clock::time_point> dropping_until_{steady_clock::time_point::min()};
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;
  Arm arm_;                   // guarded by mutex_
  RsiStatistics statistics_;  // guarded by mutex_
  std::thread thread_;
};

RsiRunner::RsiRunner(const RsiRunnerOptions& options, RsiClient client, std::function<void(RsiEnd)> ended)
    : session_{std::make_unique<Session>(options, std::move(client), std::move(ended))} {}

RsiRunner::~RsiRunner() = default;
RsiRunner::Arm RsiRunner::arm() const { return session_->arm(); }
RsiStatistics RsiRunner::statistics() const { return session_->statistics(); }
void RsiRunner::stop() { session_->stop(); }
void RsiRunner::drop(std::chrono::milliseconds duration) { session_->drop(duration); }

}  // namespace truepose::sim
