#include "daemon/cell/cell_runner.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "daemon/cell/service.hpp"
#include "daemon/log/log.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "proto/rpc/events.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;

namespace {

constexpr const char* kAcknowledge = "cell.acknowledge";

/// What is not possible while a fault stands, whatever the state is, until that is acknowledged: without the
/// store what is new.
struct RuledOut {
  FaultCode fault;
  std::vector<std::string_view> methods;
};
const std::array<RuledOut, 2> kRuledOut{
    {{FaultCode::StreamFrozen, {"stream.stop", "stream.disarm"}},
     {FaultCode::Store,
      {"cell.connect", "campaign.start", "campaign.resume", "campaign.identify", "drift.check",
       "stream.start", "stream.arm"}}}};

/// The name on the wire.
std::string device_name(CellDevice device) {
  return device == CellDevice::Controller ? "controller" : "tracker";
}

std::string answers(CellDevice device) { return "the " + device_name(device) + " answers"; }

/// The device that a campaign waits for, and why. While a connection is being made, the connection is
/// reported.
std::optional<Waiting> loss(const CellState& state) {
  if (std::holds_alternative<Running>(state) || std::holds_alternative<Paused>(state)) return waiting(state);
  return std::nullopt;
}

/// The event that the cell comes from one state to another.
rpc::StateChanged state_changed(std::string_view from, std::string_view state, const std::string& reason,
                                const std::string& by = {}) {
  return {.state = std::string{state}, .from = std::string{from}, .reason = reason, .by = text_or_none(by)};
}

/// What a state is a fault by; empty where it is none.
std::string fault_text(const CellState& state) {
  const auto* faulted = std::get_if<Faulted>(&state);
  return faulted != nullptr ? faulted->reason : "";
}

}  // namespace

void ActiveFaults::begin(Fault fault) {
  end(fault.code);
  const FaultCode code = fault.code;
  faults_[code] = {std::move(fault), control::rfc3339(wall_clock_())};
  publish(faults_[code], true);
  begun_(faults_[code].fault);
}

void ActiveFaults::end(FaultCode code) {
  if (const auto ended = faults_.extract(code)) publish(ended.mapped(), false);
}

void ActiveFaults::stand(bool stands, Fault fault) {
  if (stands == this->stands(fault.code)) return;
  if (!stands) return end(fault.code);
  log_warning(fault.text);
  begin(std::move(fault));
}

std::string ActiveFaults::text(FaultCode code) const {
  const auto found = faults_.find(code);
  return found != faults_.end() ? found->second.fault.text : "";
}

std::vector<rpc::Fault> ActiveFaults::list() const {
  std::vector<rpc::Fault> all;
  for (const auto& [code, standing] : faults_) all.push_back(standing.described());
  return all;
}

std::size_t ActiveFaults::count(std::string_view severity) const {
  const auto is = [&](const auto& standing) { return kind_of(standing.first).severity == severity; };
  return static_cast<std::size_t>(std::ranges::count_if(faults_, is));
}

rpc::Fault ActiveFaults::Standing::described() const {
  const FaultKind& kind = kind_of(fault.code);
  return {.code = std::string{kind.code},
          .severity = std::string{kind.severity},
          .text = fault.text,
          .since = since};
}

void ActiveFaults::publish(const Standing& fault, bool standing) {
  events_.publish(rpc::FaultChanged{.fault = fault.described(), .active = standing});
}

CellRunner::CellRunner(drivers::Clock& clock, EventBus& events, drivers::WallClock wall_clock,
                       CellLimits limits)
    : clock_{clock},
      events_{events},
      wall_clock_{wall_clock},
      faults_{events, std::move(wall_clock)},
      limits_{limits} {}

std::optional<RpcError> CellRunner::apply(const CellEvent& event, const std::string& reason,
                                          const std::string& by) {
  CellStep step = advance(state_, event, clock_.now(), limits_);
  if (step.refused) {
    return RpcError{
        ErrorCode::WrongState, step.refused->sentence(), {}, step.refused->state, step.refused->allowed};
  }
  if (std::holds_alternative<Faulted>(step.next) && !in<Faulted>()) faulted_in_stream_ = corrects();
  const CellState before = std::exchange(state_, std::move(step.next));
  for (const CellCommand command : step.commands) carry_out(command, reason);
  if (state_ == before) return std::nullopt;
  report_waiting(before);
  if (state_name(before) != name() || fault_text(before) != fault_text(state_)) tell(before, reason, by);
  changed_.notify();
  return std::nullopt;
}

void CellRunner::carry_out(CellCommand command, const std::string& reason) const {
  if (const CarryOut& carry_out = carry_out_[index(command)]) carry_out(reason);
}

/// Of a device that a campaign has lost, and of its return.
void CellRunner::report_waiting(const CellState& before) {
  const auto was = loss(before), is = loss(state_);
  const bool lost = is && (!was || was->device != is->device || was->reason != is->reason);
  const bool back = was && !is && in<Running>() && state_name(before) == name();
  if (!lost && !back) return;
  const std::string line = lost ? waiting_for(*is) : answers(was->device);
  log_info(line);
  events_.publish(state_changed(state_name(before), name(), line));
}

std::string CellRunner::waiting_for(const Waiting& wait) const {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(clock_.now() - wait.since);
  return "waiting for the " + device_name(wait.device) + ", " + std::to_string(seconds.count()) +
         " s: " + wait.reason;
}

std::string CellRunner::paused_because(const Waiting& wait) const {
  return "paused, " + waiting_for(wait) +
         "; the campaign resumes by itself once it answers and is ready, or resume or abort it";
}

std::string CellRunner::reason() const {
  const auto wait = loss(state_);
  return wait && !in<Paused>() ? waiting_for(*wait) : reason_;
}

std::string CellRunner::next() const {
  for (const RuledOut& by_fault : kRuledOut) {
    if (in<Faulted>() != nullptr || !faults_.stands(by_fault.fault)) continue;
    const std::string_view to_do = kind_of(by_fault.fault).what_to_do;
    return char(std::toupper(to_do.front())) + std::string{to_do.substr(1)} + '.';
  }
  return next_step(state_);
}

void CellRunner::tell(const CellState& before, const std::string& reason, const std::string& by) {
  const bool fault = in<Faulted>() != nullptr;
  reason_ = fault ? in<Faulted>()->reason : reason;
  const std::string line =
      "cell " + std::string{state_name(before)} + " -> " + std::string{name()} + ": " + reason_;
  fault ? log_error(line) : log_info(line);
  events_.publish(state_changed(state_name(before), name(), reason_, by));
  fault ? faults_.begin({FaultCode::Cell, reason_}) : faults_.end(FaultCode::Cell);
}

std::vector<std::string> CellRunner::allowed() const {
  std::vector<std::string> methods = allowed_methods(state_);
  std::erase_if(methods, [&](const std::string& method) { return !possible_(method); });
  for (const RuledOut& by_fault : kRuledOut) {
    if (!faults_.stands(by_fault.fault)) continue;
    std::erase_if(
        methods, [&](const std::string& method) { return std::ranges::count(by_fault.methods, method) > 0; });
    if (std::ranges::count(methods, kAcknowledge) == 0) methods.emplace_back(kAcknowledge);
  }
  return methods;
}

bool CellRunner::rules_out(FaultCode fault, std::string_view method) const {
  return faults_.stands(fault) && std::ranges::any_of(kRuledOut, [&](const RuledOut& out) {
           return out.fault == fault && std::ranges::count(out.methods, method) > 0;
         });
}

std::optional<RpcError> CellRunner::acknowledge(const std::string& by) {
  auto refused = apply(AcknowledgeRequested{}, "acknowledged by an operator", by);
  if (!refused || !faults_.stands(FaultCode::StreamFrozen)) return refused;
  carry_out(CellCommand::RearmStream, "");
  return std::nullopt;
}

void CellRunner::reword(std::string reason) {
  reason_ = std::move(reason);
  events_.publish(state_changed(name(), name(), reason_));
}

void CellRunner::await(CellDevice device, const std::string& reason) {
  apply(DeviceAwaited{device, reason}, reason.empty() ? answers(device) : reason);
}

RpcError CellRunner::wrong_state(std::string why, std::vector<std::string> allowed) const {
  return {ErrorCode::WrongState, std::move(why), {}, std::string{name()}, std::move(allowed)};
}

std::optional<rpc::AwaitedDevice> CellRunner::awaited_device() const {
  const auto wait = waiting(state_);
  if (!wait) return std::nullopt;
  const auto since = wall_clock_() - std::chrono::duration_cast<std::chrono::system_clock::duration>(
                                         clock_.now() - wait->since);
  return rpc::AwaitedDevice{
      .device = device_name(wait->device), .since = control::rfc3339(since), .reason = wait->reason};
}

asio::awaitable<void> CellRunner::watch() {
  for (;;) {
    const auto due = deadline(state_, limits_);
    if (due && clock_.now() >= *due) {
      const auto wait = loss(state_);
      apply(Tick{no_packet_answered_ ? no_packet_answered_() : ""}, wait ? paused_because(*wait) : "");
    } else if (due) {
      co_await changed_until(*due);
    } else {
      co_await changed();
    }
  }
}

}  // namespace truepose::daemon
