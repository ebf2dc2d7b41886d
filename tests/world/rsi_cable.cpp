#include "tests/world/rsi_cable.hpp"

#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/this_coro.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "drivers/net/spawn.hpp"
#include "tests/daemon_heap.hpp"
#include "tools/sim/controller/rsi_exchange.hpp"

namespace truepose::world {

namespace asio = boost::asio;

namespace {

constexpr std::uint32_t kController = 0x7f000001;  // 127.0.0.1
constexpr std::chrono::milliseconds kLook{30};     // as RsiResponder says
// A controller that was silent for longer than any limit of the stream is looked for less often.
constexpr std::chrono::seconds kSilence{5}, kRareLook{1};

}  // namespace

/// The RSI port of a daemon.
class RsiCable::Link final : public drivers::RsiLink {
 public:
  Link(RsiCable& cable, const asio::any_io_executor& executor, std::uint16_t port,
       drivers::RsiResponder& responder)
      : cable_{cable}, port_{port}, responder_{responder} {
    cable_.link_ = this;
    // The coroutine's end comes after this object's.
    const auto ended = [end = end_](const std::exception_ptr&) {};
    net::spawn(executor, look(), ended, end_->slot());
  }
  ~Link() override {
    cable_.link_ = nullptr;
    end_->emit(asio::cancellation_type::terminal);
  }

  std::uint16_t port() const override { return port_; }
  Counters counters() const override { return counters_; }
  std::uint64_t heartbeats() const override { return counters_.received + looks_; }
  drivers::Scheduling scheduling() const override { return {.policy = "SCHED_FIFO", .priority = 80}; }
  std::string refused() const override { return {}; }

  std::string_view answer(std::string_view datagram, std::uint16_t from) {
    const AllocatesFor daemon{AllocatesFor::Daemon};
    const drivers::TimePoint now = cable_.clock_.now();
    const std::string_view reply = responder_.answer({datagram, {kController, from}, now});
    ++counters_.received;
    ++(reply.empty() ? counters_.unanswered : counters_.answered);
    reply_ = reply;
    constexpr std::chrono::microseconds kTaken{20}, kReady{60}, kSent{80};
    responder_.finish({now, now + kTaken, now + kReady, now + kSent, kReady - kTaken, !reply.empty()});
    heard_ = now;
    return reply_;
  }

 private:
  asio::awaitable<void> look() {
    for (;;) {
      const bool long_silent = cable_.clock_.now() - heard_ > kSilence;
      const drivers::TimePoint next = cable_.clock_.now() + (long_silent ? kRareLook : kLook);
      co_await cable_.clock_.sleep_until(next);
      // The link may be gone at the very moment at which the sleep ends.
      const auto state = co_await asio::this_coro::cancellation_state;
      if (state.cancelled() != asio::cancellation_type::none) co_return;
      ++looks_;
      if (cable_.clock_.now() - heard_ >= kLook) responder_.on_no_datagram(cable_.clock_.now());
    }
  }

  RsiCable& cable_;
  std::uint16_t port_;
  drivers::RsiResponder& responder_;
  std::shared_ptr<asio::cancellation_signal> end_ = std::make_shared<asio::cancellation_signal>();
  Counters counters_;
  std::uint64_t looks_ = 0;
  drivers::TimePoint heard_{};
  std::string reply_;
};

namespace {

/// An RSI session of the simulated controller. Its coroutine ends with the session.
class Session final : public sim::RsiSession {
 public:
  Session(RsiCable& cable, const asio::any_io_executor& executor, const sim::RsiSessionOptions& options,
          sim::RsiClient client, sim::RsiListener listener)
      : cycles_{std::make_shared<Cycles>(cable, executor, options, std::move(client), std::move(listener))} {
    net::spawn(executor, run(cycles_), net::rethrow);
  }
  ~Session() override { stop(); }

  JointVector axes() const override { return cycles_->exchange.client().axes(); }
  sim::RsiStatistics statistics() const override { return cycles_->statistics(); }
  void stop() override { cycles_->stopped = true; }
  void disturb(config::ScenarioFault fault) override { cycles_->exchange.disturb(std::move(fault)); }

 private:
  struct Cycles final : sim::RsiWire {
    Cycles(RsiCable& of, const asio::any_io_executor& runs_on, const sim::RsiSessionOptions& how,
           sim::RsiClient client, sim::RsiListener hears)
        : cable{of},
          executor{runs_on},
          options{how},
          listener{std::move(hears)},
          exchange{*this, std::move(client), how.cycle, how.faults, how.cycles_before} {
      restarted();
    }

    void send(std::string_view bytes) override {
      datagram = bytes;
      std::string answer = cable.carry(bytes, port);
      if (!answer.empty()) come.emplace_back(cable.clock().now() + cable.way, std::move(answer));
    }
    void restarted() override {
      port = options.source_port != 0 ? options.source_port : cable.next_port();
      ++sessions;
      session = cable.next_session();
    }
    void begin_second_sender(sim::RsiClient twin, const std::string&) override {
      sim::RsiSessionOptions its = options;
      its.source_port = 0;
      its.faults.clear();
      second = std::make_unique<Session>(cable, executor, its, std::move(twin),
                                         sim::RsiListener{.ended = [](sim::RsiEnd) {}});
      second->cycles_->is_second = true;
    }

    sim::RsiStatistics statistics() const {
      sim::RsiStatistics all;
      all.counters = exchange.client().counters();
      all.sessions = sessions;
      all.timeouts = exchange.end() == sim::RsiEnd::Timeout;
      all.last_cycle = exchange.coming_cycle();
      return all;
    }

    /// What has come until the end of the cycle.
    void receive() {
      while (!come.empty() && come.front().first <= exchange.tick()) {
        const auto [at, text] = std::move(come.front());
        come.erase(come.begin());
        const bool answered = exchange.client().answered();
        exchange.receive(text, at);
        if (!answered && exchange.client().answered()) reply = text;
      }
      for (const std::string& line : exchange.take_rejections()) listener.rejected(line);
    }

    RsiCable& cable;
    asio::any_io_executor executor;
    sim::RsiSessionOptions options;
    sim::RsiListener listener;
    sim::RsiExchange exchange;
    std::vector<std::pair<drivers::TimePoint, std::string>> come;
    std::string datagram, reply;
    std::unique_ptr<Session> second;
    std::uint16_t port = 0;
    std::uint64_t session = 0, sessions = 0;
    bool stopped = false, is_second = false;
  };

  static asio::awaitable<void> run(std::shared_ptr<Cycles> its) {
    drivers::Clock& clock = its->cable.clock();
    its->cable.session_begins();
    its->exchange.begin_at(clock.now());
    while (!its->exchange.end() && !its->stopped) {
      while (its->exchange.begin_faults()) {
        while (!its->stopped && its->exchange.begin_silent_cycle()) {
          co_await clock.sleep_until(its->exchange.tick());
          its->exchange.end_silent_cycle();
        }
        its->receive();
      }
      if (!its->exchange.covers(config::ScenarioFault::Kind::RsiSecondSender)) its->second.reset();
      its->datagram.clear();
      its->reply.clear();
      if (its->stopped || !its->exchange.begin_cycle()) break;
      its->exchange.send(clock.now());
      co_await clock.sleep_until(its->exchange.tick());
      if (its->stopped) break;  // its controller may be gone
      its->receive();
      its->exchange.end_cycle();
      its->cable.on_cycle({its->session, its->datagram, its->reply, its->exchange.end(),
                           its->exchange.covers(config::ScenarioFault::Kind::RsiIgnore), its->is_second});
      for (const std::string& name : its->exchange.take_unknown_names()) its->listener.unknown_name(name);
    }
    its->cable.session_ends();
    if (its->exchange.end() && !its->stopped) its->listener.ended(*its->exchange.end());
  }

  std::shared_ptr<Cycles> cycles_;
};

}  // namespace

daemon::StartRsiLink RsiCable::pc(asio::any_io_executor executor) {
  return [this, executor](const drivers::RsiLinkOptions& options, drivers::RsiResponder& responder) {
    return std::make_unique<Link>(*this, executor, options.port, responder);
  };
}

sim::StartRsi RsiCable::controller(asio::any_io_executor executor) {
  return [this, executor](const sim::RsiSessionOptions& options, sim::RsiClient client,
                          sim::RsiListener listener) {
    return std::make_unique<Session>(*this, executor, options, std::move(client), std::move(listener));
  };
}

boost::asio::awaitable<void> RsiCable::session() {
  if (under_way_ == 0) co_await begun_.wait();
}

std::string RsiCable::carry(std::string_view datagram, std::uint16_t from) {
  history_.add("RSI in", datagram);
  if (cut || link_ == nullptr) return {};
  std::string reply{link_->answer(datagram, from)};
  history_.add("RSI out", reply);
  return reply;
}

}  // namespace truepose::world
