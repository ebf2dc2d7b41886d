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
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace truepose::sim {

void TurnaroundHistogram::record(std::chrono::nanoseconds turnaround) {
  const std::int64_t us =
      std::max<std::int64_t>(0, std::chrono::ceil<std::chrono::microseconds>(turnaround).count());
  ++bins_[std::min(static_cast<std::size_t>(us), kBins - 1)];
  ++count_;
  max_us_ = std::max(max_us_, us);
}

void TurnaroundHistogram::add(const TurnaroundHistogram& other) {
  std::ranges::transform(bins_, other.bins_, bins_.begin(), std::plus{});
  count_ += other.count_;
  max_us_ = std::max(max_us_, other.max_us_);
}

std::int64_t TurnaroundHistogram::percentile_us(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t us = 0; us + 1 < kBins; ++us) {
    seen += bins_[us];
    if (seen >= wanted) return static_cast<std::int64_t>(us);
  }
  return max_us_;
}

std::vector<std::pair<std::int64_t, std::uint32_t>> TurnaroundHistogram::counts() const {
  std::vector<std::pair<std::int64_t, std::uint32_t>> counts;
  for (std::size_t us = 0; us < kBins; ++us) {
    if (bins_[us] > 0) counts.emplace_back(us, bins_[us]);
  }
  return counts;
}

void SecondSenders::add(const RsiCounters& counters) {
  add(SecondSenders{counters.cycles, counters.answered, counters.max_step_rad});
}

void SecondSenders::add(const SecondSenders& other) {
  cycles += other.cycles;
  answered += other.answered;
  max_step_rad = std::max(max_step_rad, other.max_step_rad);
}

void RsiStatistics::add(const RsiStatistics& other) {
  counters.cycles += other.counters.cycles;
  counters.answered += other.counters.answered;
  counters.late += other.counters.late;
  counters.lost += other.counters.lost;
  counters.wrong_ipoc += other.counters.wrong_ipoc;
  counters.rejected += other.counters.rejected;
  counters.clamped += other.counters.clamped;
  counters.max_step_rad = std::max(counters.max_step_rad, other.counters.max_step_rad);
  counters.correction_rad = other.counters.correction_rad;  // of the session that came last
  second_senders.add(other.second_senders);
  turnaround.add(other.turnaround);
  sessions += other.sessions;
  timeouts += other.timeouts;
  overruns += other.overruns;
  longest_overrun = std::max(longest_overrun, other.longest_overrun);
  last_cycle = std::max(last_cycle, other.last_cycle);
}

namespace {

using boost::asio::ip::udp;
using config::ScenarioFault;
using std::chrono::nanoseconds;
using FaultKind = ScenarioFault::Kind;
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
  Session(const RsiRunnerOptions& options, RsiClient client, RsiListener listener, std::string from = {})
      : options_{options},
        from_{std::move(from)},
        target_{boost::asio::ip::make_address(options.host), options.port},
        socket_{open_socket()},
        cycle_{options.cycle},
        client_{std::move(client)},
        listener_{std::move(listener)},
        arm_{client_.axes(), client_.moving()},
        faults_{options.faults} {
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

  void disturb(ScenarioFault fault) {
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
    std::optional<RsiEnd> end;
    steady_clock::time_point tick = steady_clock::now();
    while (!end && !stopping_) {
      begin_faults(tick);
      const std::string_view datagram = client_.begin_cycle();
      if (datagram.empty()) {
        end = RsiEnd::Off;
        break;
      }
      if (!stopping_) send(datagram);  // a controller that is stopped while it is silent stays so
      tick += cycle_;
      receive_until(tick);
      sleep_until(tick);
      receive_pending();  // what came before this thread was woken is in time: its delay is not the PC's
      end = client_.end_cycle();

      const steady_clock::time_point now = steady_clock::now();
      // A controller's clock never stands still. Where ours did, the next cycle still gets its whole length.
      const nanoseconds behind = now - tick;
      const bool overrun = behind > cycle_ / 2;
      if (overrun) tick = now;
      publish(end, overrun ? behind : nanoseconds{0});
      for (const std::string& name : client_.take_unknown_names()) listener_.unknown_name(name);
    }
    if (second_) end_second_sender();
    if (end) listener_.ended(*end);
  }

  // ---- What goes wrong in the cycle that comes ----

  std::int64_t coming_cycle() const {
    return static_cast<std::int64_t>(options_.cycles_before + client_.counters().cycles) + 1;
  }

  /// @param tick  when the cycle begins; later than it was, where the controller pauses before it
  void begin_faults(steady_clock::time_point& tick) {
    cycle_number_ = coming_cycle();
    {
      const std::lock_guard lock{mutex_};
      statistics_.last_cycle = static_cast<std::uint64_t>(cycle_number_);
      for (ScenarioFault& fault : disturbances_) {
        fault.at = cycle_number_;
        faults_.push_back(std::move(fault));
      }
      disturbances_.clear();
    }
    for (const ScenarioFault& fault : faults_) {
      if (fault.begins_with(cycle_number_)) begin(fault, tick);
    }
    client_.ignore_corrections(now(FaultKind::RsiIgnore));
    if (second_ && !now(FaultKind::RsiSecondSender)) end_second_sender();
  }

  void begin(const ScenarioFault& fault, steady_clock::time_point& tick) {
    switch (fault.kind) {
      case FaultKind::RsiSilence:
        return pause(fault.lasts, tick, [this] { client_.pass(); });
      case FaultKind::RsiRestart:
        return restart(fault, tick);
      case FaultKind::RsiIpoc:
        return client_.jump_ipoc(fault.ipoc_by);
      case FaultKind::RsiSecondSender:
        return begin_second_sender(fault);
      default:
        return;
    }
  }

  void pause(std::int64_t cycles, steady_clock::time_point& tick, const std::function<void()>& each) {
    for (; cycles > 0 && !stopping_ && client_.is_on(); --cycles) {
      tick += cycle_;
      sleep_until(tick);
      each();
    }
    receive_pending();  // to no cycle that still waits
  }

  void restart(const ScenarioFault& fault, steady_clock::time_point& tick) {
    client_.restart(static_cast<std::uint64_t>(fault.lasts), fault.ipoc);
    pause(fault.lasts, tick, [] {});
    held_back_.clear();
    late_.clear();
    if (options_.source_port == 0) socket_ = open_socket();
    const std::lock_guard lock{mutex_};
    ++statistics_.sessions;
  }

  void begin_second_sender(const ScenarioFault& fault) {
    RsiRunnerOptions options = options_;
    options.source_port = 0;
    options.faults.clear();
    try {
      second_ = std::make_unique<Session>(options, client_.twin(), RsiListener{[](RsiEnd) {}}, fault.from);
    } catch (const boost::system::system_error& e) {
      std::fprintf(stderr, "rsi-second-sender: cannot send from '%s': %s\n", fault.from.c_str(), e.what());
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

  /// Whether a fault of this kind covers the cycle under way.
  bool now(FaultKind kind) const {
    return std::ranges::any_of(faults_, [&](const ScenarioFault& fault) {
      return fault.kind == kind && fault.covers(cycle_number_);
    });
  }

  // ---- The wire ----

  void send(std::string_view datagram) {
    sent_[sent_count_++ % sent_.size()] = steady_clock::now();
    if (now(FaultKind::RsiDrop) || now(FaultKind::RsiLoseDatagrams)) return;
    if (!late_.empty()) put_on_the_wire(std::exchange(late_, {}));
    if (now(FaultKind::RsiLate)) {
      late_ = datagram;
      return;
    }
    if (now(FaultKind::RsiReorder) && held_back_.empty()) {
      held_back_ = datagram;
      return;
    }
    put_on_the_wire(now(FaultKind::RsiCorrupt) ? garbled(datagram) : std::string{datagram});
    if (now(FaultKind::RsiDuplicate)) put_on_the_wire(datagram);
    if (!held_back_.empty()) put_on_the_wire(std::exchange(held_back_, {}));
  }

  /// A place that changes from cycle to cycle, and a byte that no number and no name has.
  std::string garbled(std::string_view datagram) const {
    constexpr std::size_t kFar = 31;
    std::string bytes{datagram};
    bytes[static_cast<std::size_t>(cycle_number_) * kFar % bytes.size()] = '<';
    return bytes;
  }

  void put_on_the_wire(std::string_view datagram) {
    boost::system::error_code lost;  // lost as on a wire, without an error
    socket_.send_to(boost::asio::buffer(datagram), target_, 0, lost);
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
      if (now(FaultKind::RsiDrop) || now(FaultKind::RsiLoseReplies)) continue;
      const RsiClient::Verdict verdict = client_.receive({buffer_.data(), size});
      for (const std::string& why : client_.take_rejections())
        listener_.rejected("RSI reply of " + from.address().to_string() + ":" + std::to_string(from.port()) +
                           ": " + why);
      const bool timed = verdict.reply == RsiClient::Reply::Valid || verdict.reply == RsiClient::Reply::Late;
      if (timed && verdict.cycles_ago < sent_.size()) {
        const nanoseconds turnaround =
            received - sent_[(sent_count_ - 1 - verdict.cycles_ago) % sent_.size()];
        const std::lock_guard lock{mutex_};
        statistics_.turnaround.record(turnaround);
      }
    }
  }

  void publish(std::optional<RsiEnd> end, nanoseconds overrun) {
    const std::lock_guard lock{mutex_};
    arm_ = {client_.axes(), client_.moving() && !end};
    statistics_.counters = client_.counters();
    statistics_.second_senders = second_senders();
    statistics_.timeouts += end == RsiEnd::Timeout;
    statistics_.overruns += overrun > nanoseconds{0};
    statistics_.longest_overrun = std::max(statistics_.longest_overrun, overrun);
  }

  const RsiRunnerOptions options_;
  const std::string from_;  // own address; empty = any
  boost::asio::io_context context_{1};
  udp::endpoint target_;
  udp::socket socket_;
  nanoseconds cycle_;
  RsiClient client_;  // the thread's alone
  RsiListener listener_;
  std::array<char, 65536> buffer_{};
  std::array<steady_clock::time_point, 1024> sent_{};
  std::uint64_t sent_count_ = 0;
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;
  Arm arm_;                                  // guarded by mutex_
  RsiStatistics statistics_;                 // guarded by mutex_
  std::vector<ScenarioFault> disturbances_;  // guarded by mutex_; not yet begun
  // The thread's alone:
  std::vector<ScenarioFault> faults_;
  std::int64_t cycle_number_ = 0;
  std::string held_back_, late_;
  std::unique_ptr<Session> second_;
  SecondSenders second_senders_ended_;
  std::thread thread_;
};

RsiRunner::RsiRunner(const RsiRunnerOptions& options, RsiClient client, RsiListener listener)
    : session_{std::make_unique<Session>(options, std::move(client), std::move(listener))} {}

RsiRunner::~RsiRunner() = default;
RsiRunner::Arm RsiRunner::arm() const { return session_->arm(); }
RsiStatistics RsiRunner::statistics() const { return session_->statistics(); }
void RsiRunner::stop() { session_->stop(); }
void RsiRunner::disturb(config::ScenarioFault fault) { session_->disturb(std::move(fault)); }

}  // namespace truepose::sim
