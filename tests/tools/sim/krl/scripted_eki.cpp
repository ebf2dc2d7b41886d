#include "tests/tools/sim/krl/scripted_eki.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <utility>

namespace truepose::sim::krl {
namespace {

std::string contents(const std::string& file) {
  std::ifstream stream(std::string(TRUEPOSE_SOURCE_DIR) + "/config/kuka/krl/" + file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

Value axes(double a1) {
  Parts parts(12, Value{0.0});
  parts[0] = a1;
  return parts;
}

std::string flag_of(const std::string& channel) {
  return channel == "CellLink" ? "$FLAG[101]" : "$FLAG[111]";
}

std::string number_text(const Value& value) {
  const auto* number = std::get_if<std::int32_t>(&value);
  return number ? std::to_string(*number) : "?";
}

}  // namespace

std::vector<Source> shipped_sources(const std::vector<Source>& more) {
  std::vector<Source> sources;
  for (const char* file : {"truepose_motion.src", "truepose_motion.dat", "truepose_stream.src",
                           "truepose_stream.dat", "truepose_state.src", "truepose_state.dat", "sps.sub"})
    if (std::ranges::find(more, file, &Source::file) == more.end()) sources.push_back({file, contents(file)});
  sources.insert(sources.end(), more.begin(), more.end());
  return sources;
}

ScriptedCell::ScriptedCell(std::vector<Source> sources, std::vector<std::string> pass_advance_run)
    : bench{std::move(sources), "", std::move(pass_advance_run)} {
  FakeHost& host = bench.host;
  host.on_call = [this](ExternalCall& call) { return answer(call); };
  host.set("$AXIS_ACT_MEAS", axes(0));
  host.set("$POS_ACT_MES", Parts{1765.0, 0.0, 1910.0, 0.0, 90.0, 0.0, 2, 35, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0});
  for (const char* name : {"$ROB_STOPPED", "$PERI_RDY", "$ALARM_STOP", "$USER_SAF"}) host.set(name, true);
  for (const char* name : {"$STOPMESS", "$PRO_MOVE"}) host.set(name, false);
  for (const char* name : {"$ACT_TOOL", "$ACT_BASE"}) host.set(name, 0);
  host.set("$NULLFRAME", Parts(6, Value{0.0}));
  host.set("$OV_PRO", 100);
  host.set("$KR_SERIALNO", 4711);
  host.set("$ROBTRAFO", std::string("#KR210R2700"));
  host.set("$V_R1MADA", std::string("KSS 8.6"));
  host.set("$MODE_OP", Literal{"EX"});
  host.set("$PRO_STATE1", Literal{"P_ACTIVE"});
  for (int i = 1; i <= 12; ++i) {
    host.set("$SOFTN_END[" + std::to_string(i) + "]", -185.0);
    host.set("$SOFTP_END[" + std::to_string(i) + "]", 185.0);
  }
  host.on_arrival = [&host](const Motion& motion) {
    Parts at(12, Value{0.0});
    for (std::size_t i = 0; i < at.size(); ++i)
      at[i] = std::get<AxisTarget>(motion.target).axes[i].value_or(0);
    host.set("$AXIS_ACT_MEAS", at);
  };
}

void ScriptedCell::connect() {
  for (auto& [name, channel] : channels_) {
    if (std::exchange(channel.listens, false)) bench.host.set(flag_of(name), true);
  }
  bench.run_for(0s);
}

void ScriptedCell::disconnect() {
  for (const auto& [name, channel] : channels_) bench.host.set(flag_of(name), false);
  bench.run_for(0s);
}

void ScriptedCell::connect_and_disconnect_unseen() {
  for (auto& [name, channel] : channels_) channel.listens = false;
}

void ScriptedCell::command(int id, int type, double a1) {
  const auto receive = [&](const std::string& element, Value value) {
    received_["CellLink/Cmd/" + element].push_back(std::move(value));
  };
  receive("@Id", id);
  receive("@Type", type);
  receive("@Vel", 50);
  receive("@Acc", 200);
  receive("@Settle", 500);
  receive("Ax/@A1", a1);
  for (int axis = 2; axis <= 6; ++axis) receive("Ax/@A" + std::to_string(axis), 0.0);
  bench.host.set("$FLAG[102]", true);
  bench.run_for(0s);
}

void ScriptedCell::control(int id, int op, int value) {
  received_["CellState/Ctl/@Id"].push_back(id);
  received_["CellState/Ctl/@Op"].push_back(op);
  received_["CellState/Ctl/@Val"].push_back(value);
  bench.host.set("$FLAG[112]", true);
}

std::expected<CallResult, std::string> ScriptedCell::answer(ExternalCall& call) {
  if (call.name.starts_with("EKI_")) return eki(call);
  if (call.name == "RSI_MOVECORR") {
    if (call.is_first) said.push_back("RSI_MOVECORR");
    return CallResult{.is_finished = rsi_leaves};
  }
  if (call.name == "BAS") return CallResult{};
  if (call.name == "MSGNOTIFY") {
    bench.host.messages.push_back(text_of(call.arguments[0]));
    return CallResult{};
  }
  said.emplace_back(call.name);
  on_send(said.back());
  if (call.name == "RSI_OFF") return CallResult{.value = std::exchange(rsi_on, false) ? 0 : 1};
  if (call.name == "RSI_ON") rsi_on = true;
  if (call.name != "RSI_CREATE") return CallResult{.value = 0};
  call.arguments[1] = 3;
  return CallResult{.value = rsi_create_result};
}

CallResult ScriptedCell::eki(ExternalCall& call) {
  const std::string channel = text_of(call.arguments[0]);
  const std::string element = channel + "/" + (call.arguments.size() > 1 ? text_of(call.arguments[1]) : "");
  auto& queue = received_[element];
  bool fails = false;
  if (call.name == "EKI_INIT") {
    fails = std::exchange(init_fails, false) || !channels_.try_emplace(channel).second;
  } else if (call.name == "EKI_OPEN") {
    fails = !channels_.contains(channel);
    if (!fails) channels_[channel].listens = true;
  } else if (call.name == "EKI_CLEAR") {
    channels_.erase(channel);
    std::erase_if(received_, [&](const auto& entry) { return entry.first.starts_with(channel); });
  } else if (call.name.starts_with("EKI_GET") && !queue.empty()) {
    call.arguments[2] = queue.front();
    queue.pop_front();
  } else if (call.name.starts_with("EKI_SET")) {
    staged_[element] = call.arguments[2];
  } else if (call.name == "EKI_SEND") {
    send(channel, text_of(call.arguments[1]));
  }
  const auto waiting = received_.find(element);
  const int count = waiting == received_.end() ? 0 : static_cast<int>(waiting->second.size());
  return {.value = Parts{count, 0, fails ? 3 : 0, true, 0}};
}

void ScriptedCell::send(const std::string& channel, const std::string& document) {
  if (channel == "CellState") {
    ++states;
    state = staged_;
  } else if (document == "Robot/Ack") {
    said.push_back("Ack " + number_text(staged_["CellLink/Robot/Ack/@Id"]) + " " +
                   number_text(staged_["CellLink/Robot/Ack/@State"]) + " " +
                   number_text(staged_["CellLink/Robot/Ack/@Err"]));
    on_send(said.back());
  } else {
    ++greetings;
    said.push_back("Hello " + text_of(staged_["CellLink/Robot/Hello/@Model"]) + " " +
                   number_text(staged_["CellLink/Robot/Hello/@Serial"]));
  }
}

}  // namespace truepose::sim::krl
