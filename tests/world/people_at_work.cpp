#include "tests/world/people_at_work.hpp"

#include <algorithm>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <utility>

#include "daemon/store/restore.hpp"
#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;
using Wait = asio::awaitable<void>;

namespace {

constexpr const char* kMotionProgram = "TRUEPOSE_MOTION";
constexpr const char* kProductionProgram = "GLUING";
constexpr std::chrono::minutes kStuck{60};

bool is_in_order(const json::object& seen) {
  const std::string state = text_at(seen, "state");
  const bool rests = state == "ready" || state == "disconnected" || state == "armed";
  return rests && seen.at("faults").as_array().empty() && seen.at("interrupted").as_array().empty();
}

bool has_fault(const json::object& seen, const char* code) {
  return std::ranges::any_of(seen.at("faults").as_array(), [code](const json::value& fault) {
    return text_at(fault.as_object(), "code") == code;
  });
}

std::string stuck_text(const json::object& seen) {
  if (seen.empty()) return "stuck: no answer";
  return "stuck: " + json::serialize(json::object{{"state", text_at(seen, "state")},
                                                  {"text", text_at(seen, "state_text")},
                                                  {"next", text_at(seen, "next")},
                                                  {"faults", seen.at("faults")},
                                                  {"interrupted", seen.at("interrupted")}});
}

}  // namespace

Wait PeopleAtWork::work(drivers::TimePoint end, double production_h_per_day) {
  co_await bring_to_order();
  co_await calibrate();
  while (log_.now() < end) {
    co_await pause(5min, 40min);
    co_await bring_to_order();
    co_await next_task(production_h_per_day);
    const json::object seen = co_await status();
    if (seen.empty()) continue;
    co_await judges_.models.look(cell_.panel);
    co_await judges_.tools.look(cell_.panel);
  }
  co_await bring_to_order();
}

Wait PeopleAtWork::next_task(double production_h_per_day) {
  const double which = random_.uniform();
  if (which < 0.20) {
    co_await calibrate();
  } else if (which < 0.30) {
    co_await check_drift();
  } else if (which < 0.45) {
    co_await measure();
  } else if (which < 0.50) {
    co_await measuring_.use_result();
  } else if (which < 0.65) {
    co_await produce(production_h_per_day);
  } else if (which < 0.72) {
    co_await orders_.give("model.rollback");
  } else if (which < 0.76) {
    co_await orders_.give("model.deactivate");
  } else if (which < 0.82) {
    co_await activate_a_model();
  } else if (which < 0.88) {
    co_await orders_.give("cell.disconnect");
  } else if (which < 0.91) {
    co_await save_recording();
  } else if (which < 0.92) {
    judges_.files.change_access();
  } else if (which < 0.94) {
    co_await back_up();
  } else if (which < 0.95) {
    co_await restore();
  } else if (which < 0.97) {
    co_await stream_once();
  } else {
    co_await reading_.read_all();
    json::object by{{"name", "panel"}};
    co_await orders_.give("audit.acknowledge", std::move(by));
  }
}

Wait PeopleAtWork::pause(drivers::Duration shortest, drivers::Duration longest) {
  const auto more = std::chrono::duration_cast<drivers::Duration>((longest - shortest) * random_.uniform());
  co_await cell_.world.pass(shortest + more);
}

/// Half of them are checked at once.
Wait PeopleAtWork::calibrate() {
  json::object poses{{"identify_poses", 12}, {"validate_poses", 6}};
  co_await campaign("campaign.start", std::move(poses));
  if (random_.uniform() < 0.5) co_await check_drift();
}

Wait PeopleAtWork::check_drift() {
  json::object params;
  if (random_.uniform() < 0.5) params = {{"update", true}, {"activate", true}};
  co_await judges_.stations.before_check(cell_.panel);
  std::string id = co_await campaign("drift.check", std::move(params));
  if (!id.empty()) co_await judges_.stations.after_check(cell_.panel, std::move(id));
}

asio::awaitable<std::string> PeopleAtWork::campaign(std::string method, json::object params) {
  if (random_.uniform() < 0.3) co_await orders_.give("control.acquire");
  json::value begun = co_await orders_.give(method, params);
  if (outcome_of(begun) == "E_CONTROL" && random_.uniform() < 0.7) {
    co_await orders_.give("control.takeover");
    begun = co_await orders_.give(method, std::move(params));
  }
  if (!is_result(begun)) co_return std::string{};
  ++campaigns;
  if (random_.uniform() < 0.2) {
    co_await pause(10s, 3min);
    co_await orders_.give(random_.uniform() < 0.5 ? "campaign.pause" : "campaign.abort");
  }
  co_await bring_to_order();
  co_return text_at(result_of(begun), "id");
}

Wait PeopleAtWork::measure() {
  const bool runs = co_await measuring_.start_one();
  if (!runs) co_return;
  ++campaigns;
  co_await bring_to_order();
  co_await measuring_.use_result();
}

Wait PeopleAtWork::stream_once() {
  const json::value started = co_await orders_.give("stream.start");
  if (!is_result(started)) co_return;
  co_await pause(10s, 2min);
  co_await orders_.give("stream.stop");
}

Wait PeopleAtWork::produce(double production_h_per_day) {
  const auto hours = std::chrono::duration<double, std::ratio<3600>>{production_h_per_day / 6};
  const drivers::TimePoint until = log_.now() + std::chrono::duration_cast<drivers::Duration>(hours);
  const json::value armed = co_await orders_.give("stream.arm");
  if (!is_result(armed)) co_return;
  co_await judges_.corrections.armed(cell_.panel);
  while (log_.now() < until) {
    co_await run_program();
    const json::object seen = co_await status();
    if (text_at(seen, "state") != "armed") break;
  }
  co_await orders_.give("stream.disarm");
  select(kMotionProgram);
}

Wait PeopleAtWork::run_program() {
  select(kProductionProgram);
  const drivers::TimePoint latest = log_.now() + 5min;
  while (log_.now() < latest) {
    co_await cell_.world.pass(1s);
    const auto program = cell_.devices.program();
    if (program.name != kProductionProgram) co_return;
    if (program.state == eki::ProgramState::Ended) {
      ++programs;
      co_return;
    }
  }
}

Wait PeopleAtWork::activate_a_model() {
  const json::value answer = co_await cell_.panel.ask("model.list");
  if (!is_result(answer)) co_return;
  const json::array& models = result_of(answer).at("models").as_array();
  if (models.empty()) co_return;
  const auto which = static_cast<std::size_t>(random_.uniform() * static_cast<double>(models.size()));
  json::object params{{"id", models.at(which).as_object().at("id")}};
  co_await orders_.give("model.activate", std::move(params));
}

/// Of a model that was altered: as its sentence says, another one, or none.
Wait PeopleAtWork::replace_model() {
  if (random_.uniform() < 0.8) {
    co_await activate_a_model();
  } else {
    co_await orders_.give("model.deactivate");
  }
}

Wait PeopleAtWork::save_recording() {
  const json::value answer = co_await orders_.give("recording.save");
  if (is_result(answer)) judges_.files.saved(text_at(result_of(answer), "file"));
}

Wait PeopleAtWork::back_up() {
  const json::value answer = co_await orders_.give("store.backup");
  if (!is_result(answer)) co_return;
  backup_ = text_at(result_of(answer), "file");
  judges_.points.backed_up();
}

/// Puts the backup in the place of the store, while the daemon does not run.
Wait PeopleAtWork::restore() {
  if (backup_.empty()) co_return;
  co_await cell_.end_of_daemon();
  log_.trace("order", "restore " + backup_.string());
  const auto restored = daemon::restore_store(backup_, "cell.sqlite", std::to_string(++restores_));
  if (!restored && !log_.is_disturbed()) log_.broken("the backup is not restored: " + restored.error());
  if (!restored) co_return;
  orders_.forget_lost();
  cell_.edited_models.clear();  // they are as they were backed up
  judges_.points.restored();
  judges_.states.restored();
  judges_.agreement.restored();
  judges_.events.restored();
  judges_.tools.restored();
}

void PeopleAtWork::select(const char* program) {
  config::ScenarioFault act;
  act.kind = config::ScenarioFault::Kind::ProgramSelect;
  act.program = program;
  cell_.devices.begin(act);
}

void PeopleAtWork::keep_motion_program() {
  const auto program = cell_.devices.program();
  if (program.name != kMotionProgram || program.state == eki::ProgramState::Ended ||
      program.state == eki::ProgramState::Free)
    select(kMotionProgram);
}

/// Empty where the daemon does not answer.
asio::awaitable<json::object> PeopleAtWork::status() {
  if (!cell_.panel.is_connected()) {
    const bool open = co_await cell_.panel.connect();
    if (!open) co_return json::object{};
    if (random_.uniform() < 0.5) co_await orders_.repeat_lost();
  }
  const json::value answer = co_await cell_.panel.ask("cell.status");
  if (!is_result(answer)) co_return json::object{};
  json::object seen = result_of(answer);
  judges_.states.see(seen);
  co_return seen;
}

/// Does what the status asks for, until the cell is in order.
Wait PeopleAtWork::bring_to_order() {
  drivers::TimePoint stuck_since = log_.now();
  for (;;) {
    const json::object seen = co_await status();
    if (!seen.empty()) {
      const std::string state = text_at(seen, "state");
      if (state != "streaming" && state != "armed") keep_motion_program();
      if (is_in_order(seen)) co_return;
      co_await act_on(seen);
    }
    if (log_.is_disturbed()) stuck_since = log_.now();
    if (log_.now() - stuck_since > kStuck) {
      log_.broken(stuck_text(seen));
      co_return;
    }
    co_await cell_.world.pass(20s);
  }
}

Wait PeopleAtWork::act_on(const json::object& seen) {
  const std::string state = text_at(seen, "state");
  const json::array& interrupted = seen.at("interrupted").as_array();
  if (!seen.at("faults").as_array().empty()) co_await orders_.give("cell.acknowledge");
  if (has_fault(seen, "E_MODEL") && random_.uniform() < 0.5) co_await replace_model();
  if (state == "paused") {
    co_await orders_.give(random_.uniform() < 0.8 ? "campaign.resume" : "campaign.abort");
  } else if (state == "streaming") {
    co_await orders_.give("stream.stop");
  } else if (!interrupted.empty() && (state == "ready" || state == "disconnected")) {
    json::object which{{"id", interrupted.front().as_object().at("id")}};
    co_await orders_.give(random_.uniform() < 0.7 ? "campaign.resume" : "campaign.abort", std::move(which));
  }
}

}  // namespace truepose::world
