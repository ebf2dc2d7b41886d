#include "tests/world/soak.hpp"

#include <boost/json/serialize.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string_view>
#include <utility>
#include <vector>

#include "core/kernels/dispatch.hpp"
#include "daemon/daemon.hpp"
#include "drivers/net/spawn.hpp"
#include "tests/world/answers.hpp"
#include "tests/world/cell.hpp"
#include "tests/world/faults.hpp"
#include "tests/world/judge/agreement_judge.hpp"
#include "tests/world/judge/audit_judge.hpp"
#include "tests/world/judge/axis_judge.hpp"
#include "tests/world/judge/clearance_judge.hpp"
#include "tests/world/judge/control_judge.hpp"
#include "tests/world/judge/correction_judge.hpp"
#include "tests/world/judge/event_judge.hpp"
#include "tests/world/judge/files_judge.hpp"
#include "tests/world/judge/model_judge.hpp"
#include "tests/world/judge/point_judge.hpp"
#include "tests/world/judge/resource_judge.hpp"
#include "tests/world/judge/sender_judge.hpp"
#include "tests/world/judge/station_judge.hpp"
#include "tests/world/judge/status_judge.hpp"
#include "tests/world/judge/stream_judge.hpp"
#include "tests/world/judge/tool_judge.hpp"
#include "tests/world/methods.hpp"
#include "tests/world/mirror.hpp"
#include "tests/world/people_at_work.hpp"
#include "tests/world/supervisor.hpp"
#include "tests/world/viewers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;
using Wait = asio::awaitable<void>;

namespace {

using Days = std::chrono::duration<double, std::ratio<86400>>;

std::uint64_t seed_of(std::uint64_t seed, std::string_view name) {
  EventHash hash;
  hash.add(std::to_string(seed));
  hash.add(name);
  return hash.value();
}

/// Of every third seed the flange has two reflectors; of every fourth the tracker stands behind a bridge; of
/// the fourths before those RSI goes on over a restart of the daemon.
Cell::Change cell_of(std::uint64_t seed) {
  return [seed](config::CellConfig& cell, config::Scenario& scenario) {
    constexpr std::uint64_t kWithTwo = 3, kWithBridge = 4;
    if (seed % kWithBridge == 2) cell.tracker.protocol = config::TrackerProtocol::Bridge;
    if (seed % kWithBridge == 1) scenario.rsi_timeout_cycles = cell.stream.timeout_cycles = 6250;  // 25 s
    if (seed % kWithTwo != 0) return;
    cell.further_reflectors = {{.name = "2", .p_FS_mm = {-70, 40, 180}, .facing_F = {-0.6, 0.4, 0.7}}};
    scenario.further_reflectors = {{.p_FS_mm = {-68, 41, 183}, .facing_F = {-0.6, 0.4, 0.7}}};
  };
}

std::vector<std::string> names_of(const std::vector<Client*>& clients) {
  std::vector<std::string> names;
  for (const Client* const client : clients) names.push_back(client->name());
  return names;
}

class Soak {
 public:
  explicit Soak(const SoakOptions& options)
      : options_{options},
        cell_{options.seed, cell_of(options.seed)},
        log_{cell_.world.clock, options.trace},
        stream_{cell_.max_step_deg},
        models_{cell_, log_},
        people_{cell_,
                log_,
                {states_, agreement_, events_, models_, tools_, stations_, corrections_, points_, files_},
                seed_of(options.seed, "people")},
        supervisor_{cell_, log_, agreement_, seed_of(options.seed, "supervisor")} {
    cell_.world.rsi.on_cycle = [this](const RsiCycle& cycle) {
      stream_.see(cycle);
      log_.take_broken(stream_.broken);
      if (cycle.end == sim::RsiEnd::Off && stream_.left_deg > kZero_deg)
        log_.broken("a program ends with a correction of " + std::to_string(stream_.left_deg) + " deg");
      axes_.see(cycle);
      senders_.see(cycle);
      corrections_.see(cycle);
    };
    const auto clients = cell_.clients();
    for (std::size_t i = 0; i < clients.size(); ++i) follow(*clients[i], i);
    watch(cell_.panel);
    watch(cell_.supervisor);
  }

  SoakReport run() {
    end_ = log_.now() + std::chrono::duration_cast<drivers::Duration>(Days{options_.days});
    const auto executor = cell_.world.outside.get_executor();
    cell_.pc.start();
    resources_.begun();
    net::spawn(executor, supervise(), net::rethrow);
    for (const FaultKind& kind : fault_kinds()) {
      if (!options_.faults || options_.faults->contains(std::string{kind.name}))
        net::spawn(executor, go_wrong(kind), net::rethrow);
    }
    net::spawn(executor, look_at_arm(), net::rethrow);
    net::spawn(executor, look_at_clearance(), net::rethrow);
    net::spawn(executor, supervisor_.work(end_), net::rethrow);
    net::spawn(executor, mirror_.work(), net::rethrow);
    for (Client& viewer : cell_.viewers) {
      Random random{seed_of(options_.seed, viewer.name())};
      net::spawn(executor, show(cell_, viewer, random, end_ - kCalmEnd), net::rethrow);
    }
    net::spawn(executor, live(), [this](std::exception_ptr failed) {
      net::rethrow(std::move(failed));
      over_ = true;
    });
    cell_.world.run([this] { return over_ || (options_.until && log_.since_begin() >= *options_.until); });
    if (!over_) return finish();
    cell_.pc.stop();
    cell_.world.run([&] { return !cell_.pc.runs() || !ends_in_time(); });
    judge_end();
    look_at_files();
    return finish();
  }

 private:
  /// @param number  its place among the clients
  void follow(Client& client, std::size_t number) {
    client.on_subscribed = [this, number](const json::object& answer) { events_.subscribed(number, answer); };
    client.on_event = [this, &client, number](const json::object& event) {
      log_.take_broken(client.complaints);
      events_.take(number, event);
      if (&client == &cell_.panel) take(event);
      if (&client == &cell_.mirror) mirror_.take(event);
      if (&client != &cell_.supervisor) return;
      agreement_.take(event);
      supervisor_.take(event);
    };
    client.on_session = [this](bool) { agreement_.sessions_change(); };
  }

  void watch(Client& client) {
    client.on_request = [&](const Request& request) {
      report_.methods.insert(request.method);
      controls_.asks(client, request);
      if (request.method == "stream.disarm") corrections_.forget();  // it is ramped out
      if (!methods_.commands(request.method)) return;
      states_.ordered();
      agreement_.asks();
    };
    client.on_answer = [&](const Request& request) {
      controls_.answered(client, request);
      tools_.answered(request);
      audit_.answered(client, request, log_.is_disturbed());
      if (methods_.commands(request.method)) agreement_.answered();
    };
    client.on_session = [&](bool is_open) {
      controls_.sees(client, is_open);
      agreement_.sessions_change();
    };
  }

  /// As the service manager: a daemon that ended is started again after 2 s.
  Wait supervise() {
    while (!over_) {
      co_await cell_.world.pass(2s);
      judge_end();
      if (over_ || cell_.pc.runs()) continue;
      resources_.ended();
      if (!cell_.pc.has_power) continue;
      states_.restarted(people_.orders().is_last_lost() || supervisor_.orders().is_last_lost());
      controls_.restarted();
      agreement_.restarted();
      stations_.look();  // while none measures
      try {
        cell_.pc.start();
        resources_.begun();
        ++report_.restarts;
        look_at_files();
      } catch (const daemon::StartError& e) {
        if (log_.is_disturbed()) continue;
        log_.broken(std::string{"the daemon does not start: "} + e.what());
      }
    }
  }

  /// By TimeoutStopSec of the unit, behind which it is killed; a slow PC takes longer.
  bool ends_in_time() const {
    constexpr std::chrono::seconds kLongest{15};
    return !cell_.pc.stopped() || log_.now() - *cell_.pc.stopped() < kLongest ||
           log_.had_fault({"disk-slow", "pc-stalled", "pc-stalled-in-a-program"}, kLongest);
  }

  void judge_end() {
    if (ends_in_time()) return;
    log_.broken("a daemon that was stopped does not end");
    cell_.pc.kill();
  }

  void look_at_files() {
    files_.look();
    audit_.judge("cell.sqlite");
  }

  Wait look_at_arm() {
    while (!over_) {
      co_await cell_.world.pass(1s);
      axes_.look(cell_.panel.is_connected() ? states_.state() : "");
      stations_.look();
      if (!stations_.is_measuring()) resources_.look();
    }
  }

  Wait look_at_clearance() {
    ClearanceJudge clearance{cell_, log_};
    while (!over_) {
      // An arm at rest is looked at once a second.
      co_await cell_.world.pass(stations_.is_measuring() ? 200ms : 1000ms);
      clearance.look(stations_.is_measuring());
    }
  }

  Wait go_wrong(const FaultKind& kind) {
    Random random{seed_of(options_.seed, kind.name)};
    for (;;) {
      const Days days{-std::log(1 - random.uniform()) / kind.per_day};
      const auto wait = std::chrono::duration_cast<drivers::Duration>(days);
      if (log_.now() + wait > end_ - kCalmEnd) co_return;
      co_await cell_.world.pass(wait);
      if (kind.waits == Waits::ForCampaign) {
        while (!stations_.is_measuring()) co_await cell_.world.pass(5s);
        co_await cell_.world.pass(lasting(random, 20s, 5min));
      }
      if (kind.waits == Waits::ForRsi) {
        co_await cell_.world.rsi.session();
        // Most of them in the first seconds, while the correction ramps in.
        co_await cell_.world.pass(lasting(random, 1ms, 30s));
      }
      if (log_.now() > end_ - kCalmEnd) co_return;
      ++report_.faults[std::string{kind.name}];
      log_.begin_fault(kind.name);
      co_await kind.happen(cell_, random);
      log_.end_fault(kind.name);
    }
  }

  Wait live() {
    co_await people_.work(end_, options_.production_h_per_day);
    co_await points_.compare_with_store(cell_.panel);
  }

  void take(const json::object& event) {
    const std::string topic = text_at(event, "topic");
    const json::object& data = event.at("data").as_object();
    if (topic != "stream") log_.trace(topic, json::serialize(data));
    if (topic == "measurement") points_.take(data, cell_.panel.is_late(event));
    if (topic == "cell") states_.take(data);
    if (topic == "campaign") stations_.take_progress(data), points_.take_progress(data);
    if (topic == "model")
      states_.take_model(data), models_.take(data), stations_.take_change(data), corrections_.forget();
  }

  SoakReport finish() {
    for (Client* const client : cell_.clients()) log_.take_broken(client->complaints);
    events_.judge();
    report_.broken = log_.broken_promises();
    report_.hash = cell_.world.history.hash();
    report_.campaigns = people_.campaigns;
    report_.programs = people_.programs;
    report_.points = points_.points;
    report_.points_compared = points_.compared;
    report_.largest_point_error_mm = points_.largest_error_mm;
    report_.looks = agreement_.looks;
    report_.statuses_compared = mirror_.compared;
    report_.events_compared = events_.compared;
    report_.cycles = stream_.cycles;
    report_.sessions = stream_.sessions;
    report_.corrections_compared = corrections_.compared;
    report_.drift_checks = stations_.checks;
    report_.largest_correction_error_mm = corrections_.largest_error_mm;
    report_.largest_step_deg = stream_.largest_step_deg;
    report_.largest_model_error_mm = models_.largest_error_mm;
    report_.largest_model_ratio = models_.largest_ratio;
    report_.largest_daemon_bytes = resources_.largest_bytes;
    report_.largest_left_bytes = resources_.largest_left_bytes;
    return report_;
  }

  static constexpr double kZero_deg = 1e-4;
  static constexpr std::chrono::hours kCalmEnd{1};  // without new trouble

  const SoakOptions& options_;
  Cell cell_;
  SoakLog log_;
  const Methods methods_;
  StreamJudge stream_;
  ControlJudge controls_{log_, methods_};
  AuditJudge audit_{log_, methods_};
  AgreementJudge agreement_{cell_, cell_.supervisor, log_};
  StatusJudge states_{log_};
  AxisJudge axes_{cell_, log_};
  SenderJudge senders_{cell_, log_};
  PointJudge points_{cell_, log_};
  FilesJudge files_{"cell.sqlite", log_};
  ModelJudge models_;
  ToolJudge tools_{log_};
  EventJudge events_{names_of(cell_.clients()), log_};
  StationJudge stations_{cell_, log_};
  CorrectionJudge corrections_{cell_, log_};
  ResourceJudge resources_{cell_, log_};
  PeopleAtWork people_;
  Supervisor supervisor_;
  Mirror mirror_{cell_, log_};
  SoakReport report_;
  drivers::TimePoint end_{};
  bool over_ = false;
};

}  // namespace

std::optional<std::chrono::milliseconds> time_in(const std::string& text) {
  int days = 0, hours = 0, minutes = 0, read = 0;
  double seconds = 0;
  if (std::sscanf(text.c_str(), "%d %d:%d:%lf%n", &days, &hours, &minutes, &seconds, &read) != 4 ||
      static_cast<std::size_t>(read) != text.size())
    return std::nullopt;
  return std::chrono::days{days} + std::chrono::hours{hours} + std::chrono::minutes{minutes} +
         std::chrono::milliseconds{std::llround(seconds * 1000)};
}

SoakReport soak(const SoakOptions& options) {
  // Where those of other instruction sets fuse a multiplication with an addition is the optimiser's choice,
  // and not every processor has them: histories would differ in the last digits.
  if (!options.own_kernels) kernels::use(kernels::Isa::Baseline);
  return Soak{options}.run();
}

}  // namespace truepose::world
