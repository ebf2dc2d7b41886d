#include "tools/sim/controller/rsi_runner.hpp"

#include <poll.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "tools/sim/controller/rsi_exchange.hpp"

namespace truepose::sim {
namespace {

using boost::asio::ip::udp;
using config::ScenarioFault;
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

class RsiRunner final : public RsiSession, RsiWire {
 public:
  /// @param from  numeric address that it sends from; empty: any
  RsiRunner(const RsiSessionOptions& options, RsiClient client, RsiListener listener, std::string from = {})
      : options_{options},
        from_{std::move(from)},
        target_{boost::asio::ip::make_address(options.host), options.port},
        socket_{open_socket()},
        exchange_{*this, std::move(client), options.cycle, options.faults, options.cycles_before},
        listener_{std::move(listener)},
        axes_{exchange_.client().axes()} {
    statistics_.sessions = 1;
    thread_ = std::thread{[this] { run(); }};
    const sched_param fifo{.sched_priority = kPriority};
    pthread_setschedparam(thread_.native_handle(), SCHED_FIFO,
                          &fifo);  // refused without the right: then as it is
  }

  ~RsiRunner() override { stop(); }

  void stop() override {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

  JointVector axes() const override {
    const std::lock_guard lock{mutex_};
    return axes_;
  }

  RsiStatistics statistics() const override {
    const std::lock_guard lock{mutex_};
    return statistics_;
  }

  void disturb(ScenarioFault fault) override {
    const std::lock_guard lock{mutex_};
    disturbances_.push_back(std::move(fault));
  }

 private:
  udp::socket open_socket() {
    const auto address = from_.empty() ? boost::asio::ip::address{boost::asio::ip::address_v4::any()}
                                       : boost::asio::ip::make_address(from_);
    udp::socket socket{context_, udp::endpoint{address, options_.source_port}};
    socket.non_blocking(true);
    return socket;
  }

  void run() {
    exchange_.begin_at(steady_clock::now());
    while (!exchange_.end() && !stopping_) {
      begin_faults();
      if (!exchange_.begin_cycle()) break;
      // A controller that is stopped while it is silent stays so.
      if (!stopping_) exchange_.send(steady_clock::now());
      receive_until(exchange_.tick());
      sleep_until(exchange_.tick());
      receive_pending();  // what came before this thread was woken is in time: its delay is not the PC's
      exchange_.end_cycle();

      const steady_clock::time_point now = steady_clock::now();
      // A controller's clock never stands still. Where ours did, the next cycle still gets its whole length.
      const nanoseconds behind = now - exchange_.tick();
      const bool overrun = behind > nanoseconds{options_.cycle} / 2;
      if (overrun) exchange_.begin_at(now);
      publish(overrun ? behind : nanoseconds{0});
      for (const std::string& name : exchange_.take_unknown_names()) listener_.unknown_name(name);
    }
    if (second_) end_second_sender();
    if (exchange_.end()) listener_.ended(*exchange_.end());
  }

  void begin_faults() {
    {
      const std::lock_guard lock{mutex_};
      statistics_.last_cycle = exchange_.coming_cycle();
      for (ScenarioFault& fault : disturbances_) exchange_.disturb(std::move(fault));
      disturbances_.clear();
    }
    while (exchange_.begin_faults()) {
      while (!stopping_ && exchange_.begin_silent_cycle()) {
        sleep_until(exchange_.tick());
        exchange_.end_silent_cycle();
      }
      receive_pending();  // to no cycle that still waits
    }
    if (second_ && !exchange_.covers(ScenarioFault::Kind::RsiSecondSender)) end_second_sender();
  }

  // ---- The wire ----

  void send(std::string_view datagram) override {
    boost::system::error_code lost;  // lost as on a wire, without an error
    socket_.send_to(boost::asio::buffer(datagram), target_, 0, lost);
  }

  void restarted() override {
    if (options_.source_port == 0) socket_ = open_socket();
    const std::lock_guard lock{mutex_};
    ++statistics_.sessions;
  }

  void begin_second_sender(RsiClient twin, const std::string& from) override {
    RsiSessionOptions options = options_;
    options.source_port = 0;
    options.faults.clear();
    try {
      second_ = std::make_unique<RsiRunner>(options, std::move(twin), RsiListener{[](RsiEnd) {}}, from);
    } catch (const boost::system::system_error& e) {
      std::fprintf(stderr, "rsi-second-sender: cannot send from '%s': %s\n", from.c_str(), e.what());
    }
  }

  void end_second_sender() {
    second_->stop();
    second_senders_ended_.add(second_->statistics().counters);
    second_.reset();
  }

  SecondSenders second_senders() const {
    SecondSenders all = second_senders_ended_;
    if (second_) all.add(second_->statistics().counters);
    return all;
  }

  /// Returns early once the cycle has its answer: nothing else can come that would matter.
  void receive_until(steady_clock::time_point deadline) {
    for (;;) {
      receive_pending();
      const nanoseconds left = deadline - steady_clock::now();
      if (exchange_.client().answered() || left <= nanoseconds{0}) return;
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
      const std::optional<nanoseconds> turnaround = exchange_.receive({buffer_.data(), size}, received);
      for (const std::string& why : exchange_.take_rejections())
        listener_.rejected("RSI reply of " + from.address().to_string() + ":" + std::to_string(from.port()) +
                           ": " + why);
      if (!turnaround) continue;
      const std::lock_guard lock{mutex_};
      statistics_.turnaround.record(*turnaround);
    }
  }

  void publish(nanoseconds overrun) {
    const RsiClient& client = exchange_.client();
    const std::lock_guard lock{mutex_};
    axes_ = client.axes();
    statistics_.counters = client.counters();
    statistics_.second_senders = second_senders();
    statistics_.timeouts += exchange_.end() == RsiEnd::Timeout;
    statistics_.overruns += overrun > nanoseconds{0};
    statistics_.longest_overrun = std::max(statistics_.longest_overrun, overrun);
  }

  const RsiSessionOptions options_;
  const std::string from_;
  boost::asio::io_context context_{1};
  udp::endpoint target_;
  udp::socket socket_;
  RsiExchange exchange_;  // the thread's alone
  RsiListener listener_;
  std::array<char, 65536> buffer_{};
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;
  JointVector axes_;                         // guarded by mutex_
  RsiStatistics statistics_;                 // guarded by mutex_
  std::vector<ScenarioFault> disturbances_;  // guarded by mutex_; not yet begun
  // The thread's alone:
  std::unique_ptr<RsiRunner> second_;
  SecondSenders second_senders_ended_;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<RsiSession> start_rsi_runner(const RsiSessionOptions& options, RsiClient client,
                                             RsiListener listener) {
  return std::make_unique<RsiRunner>(options, std::move(client), std::move(listener));
}

}  // namespace truepose::sim
