#include "tests/world/soak.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <exception>
#include <string_view>
#include <utility>

#include "daemon/daemon.hpp"
#include "drivers/net/spawn.hpp"
#include "tests/world/cell.hpp"
#include "tests/world/faults.hpp"
#include "tests/world/stream_judge.hpp"
#include "tests/world/truth_judge.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;
using Wait = asio::awaitable<void>;

namespace {

using Days = std::chrono::duration<double, std::ratio<86400>>;

constexpr const char* kMotionProgram = "TRUEPOSE_MOTION";
constexpr const char* kProductionProgram = "GLUING";

std::uint64_t seed_of(std::uint64_t seed, std::string_view name) {
  soak::EventHash hash;
  hash.add(std::to_string(seed));
  hash.add(name);
  return hash.value();
}

bool is_result(const json::value& answer) {
  return answer.is_object() && answer.as_object().contains("result");
}

std::string text_at(const json::object& object, std::string_view member) {
  const json::value* const value = object.if_contains(member);
  return value != nullptr && value->is_string() ? std::string{value->as_string()} : std::string{};
}

class Soak {
 public:
  explicit Soak(const SoakOptions& options)
      : options_{options},
        cell_{options.seed},
        random_{seed_of(options.seed, "people")},
        stream_{cell_.max_step_deg} {
    cell_.world.rsi.on_cycle = [this](const RsiCycle& cycle) {
      stream_.see(cycle);
      take_broken(stream_.broken);
    };
    cell_.panel.on_event = [this](const json::object& event) { take(event); };
  }

  SoakReport run() {
    end_ = begin_ + std::chrono::duration_cast<drivers::Duration>(Days{options_.days});
    const auto executor = cell_.world.outside.get_executor();
    cell_.pc.start();
    net::spawn(executor, supervise(), net::rethrow);
    for (const FaultKind& kind : fault_kinds()) {
      if (!options_.faults || options_.faults->contains(std::string{kind.name}))
        net::spawn(executor, go_wrong(kind), net::rethrow);
    }
    net::spawn(executor, live(), [this](std::exception_ptr failed) {
      net::rethrow(std::move(failed));
      over_ = true;
    });
    cell_.world.run([this] { return over_ || (options_.until && since_begin() >= *options_.until); });
    if (!over_) return finish();
    cell_.pc.stop();
    cell_.world.run([&] { return !cell_.pc.runs(); });
    return finish();
  }

 private:
  drivers::TimePoint now() const { return cell_.world.clock.now(); }

  std::chrono::milliseconds since_begin() const {
    return std::chrono::floor<std::chrono::milliseconds>(now() - begin_);
  }

  void trace(const std::string& topic, const std::string& text) {
    const std::string time = time_text(since_begin());
    options_.trace(time, topic, text);
    events_.push_back(fmt::format("{} {}: {:.300}", time, topic, text));
    if (events_.size() > kEvents) events_.pop_front();
  }

  void broken(const std::string& promise) {
    report_.broken.push_back({since_begin(), promise, {events_.begin(), events_.end()}});
    trace("broken", promise);
  }

  // ---- What goes on by itself ----

  /// As the service manager: a daemon that ended is started again after 2 s.
  Wait supervise() {
    while (!over_) {
      co_await cell_.world.pass(2s);
      if (over_ || cell_.pc.runs() || !cell_.pc.has_power) continue;
      armed_before_ = state_ == "armed" && !order_lost_;
      try {
        cell_.pc.start();
        ++report_.restarts;
      } catch (const daemon::StartError& e) {
        if (disturbed()) continue;
        broken(std::string{"the daemon does not start: "} + e.what());
      }
    }
  }

  Wait go_wrong(const FaultKind& kind) {
    Random random{seed_of(options_.seed, kind.name)};
    for (;;) {
      const Days days{-std::log(1 - random.uniform()) / kind.per_day};
      const auto wait = std::chrono::duration_cast<drivers::Duration>(days);
      if (now() + wait > end_ - kCalmEnd) co_return;
      co_await cell_.world.pass(wait);
      ++report_.faults[std::string{kind.name}];
      ++under_way_;
      trace("fault", std::string{kind.name} + " begins");
      co_await kind.happen(cell_, random);
      trace("fault", std::string{kind.name} + " is over");
      --under_way_;
      last_trouble_ = now();
    }
  }

  bool disturbed() const { return under_way_ > 0 || now() - last_trouble_ < kAfterTrouble; }

  // ---- People ----

  asio::awaitable<json::value> order(std::string method, json::object params = {}) {
    trace("order", method + " " + json::serialize(params));
    const json::value answer = co_await cell_.panel.ask(method, std::move(params));
    order_lost_ = answer.is_null();
    if (answer.is_object() && answer.as_object().contains("error")) {
      const json::object& error = answer.as_object().at("error").as_object();
      trace("refused", text_at(error, "message"));
      if (text_at(error, "message").empty()) broken(method + " is refused without a reason");
    }
    co_return answer;
  }

  /// Empty where the daemon does not answer.
  asio::awaitable<json::object> status() {
    if (!cell_.panel.is_connected()) {
      const bool open = co_await cell_.panel.connect();
      if (!open) co_return json::object{};
    }
    const json::value answer = co_await cell_.panel.ask("cell.status");
    if (!is_result(answer)) co_return json::object{};
    json::object seen = answer.as_object().at("result").as_object();
    const std::string state = text_at(seen, "state");
    if (std::exchange(armed_before_, false) && state != "armed" && seen.at("faults").as_array().empty())
      broken("the stream was armed before the daemon ended, and is " + state);
    co_return seen;
  }

  Wait live() {
    co_await bring_to_order();
    co_await campaign("campaign.start");
    while (now() < end_) {
      co_await pause(5min, 40min);
      co_await bring_to_order();
      const double which = random_.uniform();
      if (which < 0.25) {
        co_await campaign("campaign.start");
      } else if (which < 0.40) {
        co_await campaign("drift.check");
      } else if (which < 0.65) {
        co_await produce();
      } else if (which < 0.72) {
        co_await order("model.rollback");
      } else if (which < 0.76) {
        co_await order("model.deactivate");
      } else if (which < 0.82) {
        co_await activate_a_model();
      } else if (which < 0.88) {
        co_await order("cell.disconnect");
      } else if (which < 0.94) {
        co_await order("recording.save");
      }
      co_await look_at_models();
    }
    co_await bring_to_order();
    co_await compare_points();
  }

  Wait pause(drivers::Duration shortest, drivers::Duration longest) {
    const auto more = std::chrono::duration_cast<drivers::Duration>((longest - shortest) * random_.uniform());
    co_await cell_.world.pass(shortest + more);
  }

  Wait campaign(std::string method) {
    json::object params;
    if (method == "campaign.start") params = {{"identify_poses", 12}, {"validate_poses", 6}};
    if (method == "drift.check" && random_.uniform() < 0.5) params = {{"update", true}, {"activate", true}};
    const json::value begun = co_await order(method, std::move(params));
    if (!is_result(begun)) co_return;
    ++report_.campaigns;
    if (random_.uniform() < 0.2) {
      co_await pause(10s, 3min);
      co_await order(random_.uniform() < 0.5 ? "campaign.pause" : "campaign.abort");
    }
    co_await bring_to_order();
  }

  Wait produce() {
    const auto hours = std::chrono::duration<double, std::ratio<3600>>{options_.production_h_per_day / 6};
    const drivers::TimePoint until = now() + std::chrono::duration_cast<drivers::Duration>(hours);
    const json::value armed = co_await order("stream.arm");
    if (!is_result(armed)) co_return;
    while (now() < until) {
      co_await run_program();
      const json::object seen = co_await status();
      if (text_at(seen, "state") != "armed") break;
    }
    co_await order("stream.disarm");
    select(kMotionProgram);
  }

  void select(const char* program) {
    config::ScenarioFault act;
    act.kind = config::ScenarioFault::Kind::ProgramSelect;
    act.program = program;
    cell_.devices.begin(act);
  }

  Wait run_program() {
    select(kProductionProgram);
    const drivers::TimePoint latest = now() + 5min;
    while (now() < latest) {
      co_await cell_.world.pass(1s);
      const auto program = cell_.devices.program();
      if (program.name != kProductionProgram) co_return;
      if (program.state == eki::ProgramState::Ended) {
        ++report_.programs;
        co_return;
      }
    }
  }

  Wait activate_a_model() {
    const json::value answer = co_await cell_.panel.ask("model.list");
    if (!is_result(answer)) co_return;
    const json::array& models = answer.as_object().at("result").as_object().at("models").as_array();
    if (models.empty()) co_return;
    const auto which = static_cast<std::size_t>(random_.uniform() * static_cast<double>(models.size()));
    json::object params{{"id", models.at(which).as_object().at("id")}};
    co_await order("model.activate", std::move(params));
  }

  /// Does what the status asks for, until the cell is in order.
  Wait bring_to_order() {
    drivers::TimePoint stuck_since = now();
    for (;;) {
      const json::object seen = co_await status();
      const std::string state = text_at(seen, "state");
      if (!seen.empty()) {
        if (state != "streaming" && state != "armed") keep_motion_program();
        if (is_in_order(seen)) co_return;
        co_await act_on(seen);
      }
      if (disturbed()) stuck_since = now();
      if (now() - stuck_since > kStuck) {
        broken("stuck: " + (seen.empty()
                                ? "no answer"
                                : json::serialize(json::object{{"state", state},
                                                               {"text", text_at(seen, "state_text")},
                                                               {"next", text_at(seen, "next")},
                                                               {"faults", seen.at("faults")},
                                                               {"interrupted", seen.at("interrupted")}})));
        co_return;
      }
      co_await cell_.world.pass(20s);
    }
  }

  static bool is_in_order(const json::object& seen) {
    const std::string state = text_at(seen, "state");
    const bool rests = state == "ready" || state == "disconnected" || state == "armed";
    return rests && seen.at("faults").as_array().empty() && seen.at("interrupted").as_array().empty();
  }

  void keep_motion_program() {
    const auto program = cell_.devices.program();
    if (program.name != kMotionProgram || program.state == eki::ProgramState::Ended ||
        program.state == eki::ProgramState::Free)
      select(kMotionProgram);
  }

  Wait act_on(const json::object& seen) {
    const std::string state = text_at(seen, "state");
    const json::array& interrupted = seen.at("interrupted").as_array();
    if (!seen.at("faults").as_array().empty()) co_await order("cell.acknowledge");
    if (state == "paused") {
      co_await order(random_.uniform() < 0.8 ? "campaign.resume" : "campaign.abort");
    } else if (state == "streaming") {
      co_await order("stream.stop");
    } else if (!interrupted.empty() && (state == "ready" || state == "disconnected")) {
      json::object which{{"id", interrupted.front().as_object().at("id")}};
      co_await order(random_.uniform() < 0.7 ? "campaign.resume" : "campaign.abort", std::move(which));
    }
  }

  // ---- Promises ----

  void take_broken(std::vector<std::string>& promises) {
    for (const std::string& promise : std::exchange(promises, {})) broken(promise);
  }

  void take(const json::object& event) {
    take_broken(cell_.panel.complaints);
    const std::string topic = text_at(event, "topic");
    const json::object& data = event.at("data").as_object();
    if (topic != "stream") trace(topic, json::serialize(data));
    if (topic == "measurement" && !data.at("p_mm").is_null()) {
      reported_[text_at(data, "campaign_id")].insert(json::serialize(data.at("p_mm")));
      ++report_.points;
    }
    if (topic == "cell") state_ = text_at(data, "state");
    if (topic == "model" && text_at(data, "change") == "made") {
      const json::object& model = data.at("model").as_object();
      if (model.at("active").as_bool()) trusted_.insert(text_at(model, "id"));
    }
  }

  Wait look_at_models() {
    const json::object seen = co_await status();
    if (seen.empty()) co_return;
    const json::value answer = co_await cell_.panel.ask("model.list");
    if (!is_result(answer)) co_return;
    int active = 0;
    for (const json::value& model : answer.as_object().at("result").as_object().at("models").as_array())
      active += model.as_object().at("active").as_bool() ? 1 : 0;
    if (active > 1) broken(std::to_string(active) + " models are active");
    if (active == 1) co_await compare_with_truth();
  }

  /// An active model that its campaign activated is about as good as it was found to be.
  Wait compare_with_truth() {
    const json::value answer = co_await cell_.panel.ask("model.get");
    if (!is_result(answer)) co_return;
    const json::object& found = answer.as_object().at("result").as_object();
    const json::object& model = found.at("model").as_object();
    const double error_mm = mean_error_mm(found.at("parameters").as_array(), cell_.scenario);
    if (trusted_.erase(text_at(model, "id")) == 0) co_return;
    trace("truth", text_at(model, "id") + ": " + std::to_string(error_mm) + " mm");
    report_.largest_model_error_mm = std::max(report_.largest_model_error_mm, error_mm);
    if (error_mm > kBadModel_mm)
      broken("an active model is wrong by " + std::to_string(error_mm) + " mm: " + json::serialize(model));
  }

  /// What was reported as measured is in the store.
  Wait compare_points() {
    for (const auto& [campaign, points] : reported_) {
      json::object which{{"id", campaign}, {"limit", 1000}};
      const json::value answer = co_await cell_.panel.ask("campaign.points", std::move(which));
      if (!is_result(answer)) {
        broken("the points of campaign " + campaign + " are lost: " + json::serialize(answer));
        continue;
      }
      std::set<std::string> stored;
      for (const json::value& point : answer.as_object().at("result").as_object().at("points").as_array())
        stored.insert(json::serialize(point.as_object().at("p_mm")));
      for (const std::string& point : points) {
        if (!stored.contains(point))
          broken("campaign " + campaign + ": the reported point " + point + " is lost");
      }
    }
  }

  SoakReport finish() {
    take_broken(cell_.panel.complaints);
    report_.hash = cell_.world.history.hash();
    report_.cycles = stream_.cycles;
    report_.sessions = stream_.sessions;
    report_.largest_step_deg = stream_.largest_step_deg;
    return report_;
  }

  static constexpr std::size_t kEvents = 30;
  static constexpr std::chrono::hours kCalmEnd{1};          // without new trouble
  static constexpr std::chrono::minutes kAfterTrouble{10};  // in which its effects may last
  static constexpr std::chrono::minutes kStuck{60};
  static constexpr double kBadModel_mm = 0.5;  // of 12 poses, over a wide range

  const SoakOptions& options_;
  Cell cell_;
  Random random_;
  StreamJudge stream_;
  SoakReport report_;
  drivers::TimePoint begin_ = now(), end_{}, last_trouble_{};
  std::deque<std::string> events_;  // the last
  int under_way_ = 0;               // faults
  bool over_ = false;
  std::string state_;                                      // of the cell, by its last event
  bool order_lost_ = false;                                // the last order has no answer
  bool armed_before_ = false;                              // as a restarted daemon has to be
  std::set<std::string> trusted_;                          // models that their campaigns activated
  std::map<std::string, std::set<std::string>> reported_;  // points, by their campaigns
};

}  // namespace

std::string time_text(std::chrono::milliseconds since_begin) {
  const auto ms = since_begin.count();
  return fmt::format("{} {:02}:{:02}:{:02}.{:03}", ms / 86'400'000, ms / 3'600'000 % 24, ms / 60'000 % 60,
                     ms / 1000 % 60, ms % 1000);
}

std::optional<std::chrono::milliseconds> time_in(const std::string& text) {
  int days = 0, hours = 0, minutes = 0, read = 0;
  double seconds = 0;
  if (std::sscanf(text.c_str(), "%d %d:%d:%lf%n", &days, &hours, &minutes, &seconds, &read) != 4 ||
      static_cast<std::size_t>(read) != text.size())
    return std::nullopt;
  return std::chrono::days{days} + std::chrono::hours{hours} + std::chrono::minutes{minutes} +
         std::chrono::milliseconds{std::llround(seconds * 1000)};
}

SoakReport soak(const SoakOptions& options) { return Soak{options}.run(); }

}  // namespace truepose::world
