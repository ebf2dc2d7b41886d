#include "daemon/recorder/driver_call.hpp"

#include <array>
#include <boost/asio/error.hpp>
#include <boost/system/system_error.hpp>
#include <limits>
#include <type_traits>
#include <vector>

#include "core/named.hpp"
#include "daemon/recorder/record_forms.hpp"
#include "proto/record/forms.hpp"

namespace truepose {

// Where the layouts are looked for: beside what they describe.

namespace drivers {

void layout(auto& io, record::Is<MoveCommand> auto& x) {
  io("q_rad", x.q, record::Digits<JointVector>{});
  io("speed_percent", x.speed_percent, record::OneInDigits{});
  io("settle_ms", x.settle, record::kWhole64);
}

void layout(auto& io, record::Is<RobotIdentity> auto& x) {
  io("model", x.model);
  io("serial", x.serial);
  io("software", x.software);
}

void layout(auto& io, record::Is<RobotState> auto& x) {
  io("q_rad", x.q);
  io("X_BF_reported", x.X_BF_reported, record::Rows{});
  io("ready", x.ready);
  io("moving", x.moving);
  io("why_not_ready", x.why_not_ready);
  io("override_percent", x.override_percent);
  io("mode", x.mode);
  io("program", x.program);
  io("emergency_stop", x.emergency_stop);
  io("gate_open", x.gate_open);
  io.optional("tool", x.tool);
  io.optional("serial", x.serial);
}

void layout(auto& io, record::Is<TrackerIdentity> auto& x) {
  io("model", x.model);
  io("serial", x.serial);
  io("firmware", x.firmware);
}

}  // namespace drivers

void layout(auto& io, record::Is<MeasuredOrientation> auto& x) {
  io("R_WT", x.R_WT, record::KukaAngles{});
  io("sigma_rad", x.sigma_rad);
}

namespace drivers {

void layout(auto& io, record::Is<SmrPoint> auto& x) {
  io("p_WS_mm", x.p_WS_mm);
  io("std_mm", x.std_mm);
  io.optional("orientation", x.orientation);
  io("temperature_c", x.temperature_c);
  io("pressure_mbar", x.pressure_mbar);
  io("humidity_percent", x.humidity_percent);
}

}  // namespace drivers

namespace daemon {
namespace {

using drivers::RobotFault;
using drivers::TrackerFault;

constexpr std::array kAsked{Named{"connect", Asked::Connect},
                            Named{"state", Asked::State},
                            Named{"look", Asked::Look},
                            Named{"move", Asked::Move},
                            Named{"start-stream-program", Asked::StartStreamProgram},
                            Named{"stop", Asked::Stop},
                            Named{"aim", Asked::Aim},
                            Named{"measure", Asked::Measure},
                            Named{"turn-over", Asked::TurnOver},
                            Named{"check", Asked::Check},
                            Named{"disconnect", Asked::Disconnect},
                            Named{"average-over", Asked::AverageOver}};

constexpr std::array kRobotFaultNames{
    Named{"unreachable", RobotFault::Unreachable},   Named{"timeout", RobotFault::Timeout},
    Named{"disconnected", RobotFault::Disconnected}, Named{"protocol", RobotFault::Protocol},
    Named{"refused", RobotFault::Refused},           Named{"aborted", RobotFault::Aborted},
    Named{"not-ready", RobotFault::NotReady}};
constexpr std::array kTrackerFaultNames{Named{"unreachable", TrackerFault::Unreachable},
                                        Named{"timeout", TrackerFault::Timeout},
                                        Named{"disconnected", TrackerFault::Disconnected},
                                        Named{"protocol", TrackerFault::Protocol},
                                        Named{"not-ready", TrackerFault::NotReady},
                                        Named{"no-target", TrackerFault::NoTarget},
                                        Named{"beam-broken", TrackerFault::BeamBroken},
                                        Named{"busy", TrackerFault::Busy},
                                        Named{"refused", TrackerFault::Refused}};

static_assert(kRobotFaultNames.size() == drivers::kRobotFaults.size() &&
              kTrackerFaultNames.size() == drivers::kTrackerFaults.size());

std::string_view name_of_fault(RobotFault fault) { return name_of(kRobotFaultNames, fault); }
std::string_view name_of_fault(TrackerFault fault) { return name_of(kTrackerFaultNames, fault); }

/// A driver's error; fault "exception" is an error of ours.
struct Failure {
  std::string fault, detail;
};
void layout(auto& io, record::Is<Failure> auto& x) {
  io("fault", x.fault);
  io("detail", x.detail);
}

/// The answer of a call that answers nothing but that it is done.
struct Done {};
void layout(auto&, record::Is<Done> auto&) {}

template <class Answer>
struct DriverOutcome {
  OutcomeHead head;
  std::optional<Answer> answer;
  std::optional<Failure> failure;
};
template <class Answer>
void layout(auto& io, const DriverOutcome<Answer>& x) {
  layout(io, x.head);
  io.optional("answer", x.answer);
  io.optional("failure", x.failure);
}

template <class T, class Error>
std::string text_of(std::uint64_t call, const std::expected<T, Error>& outcome) {
  using Answer = std::conditional_t<std::is_void_v<T>, Done, T>;
  DriverOutcome<Answer> ended{.head = {.call = call}, .answer = {}, .failure = {}};
  if (!outcome) {
    ended.failure = {std::string{name_of_fault(outcome.error().fault)}, outcome.error().detail};
  } else if constexpr (std::is_void_v<T>) {
    ended.answer.emplace();
  } else {
    ended.answer = *outcome;
  }
  return record::text_of(ended);
}

struct AirRecord {
  Air air;
  std::string why_not;  // nothing is known of it; empty: it is
};
void layout(auto& io, record::Is<AirRecord> auto& x) {
  if (io.has("why_not", !x.why_not.empty())) return io("why_not", x.why_not);
  io("temperature_c", x.air.temperature_c, record::OneInDigits{});
  io("pressure_mbar", x.air.pressure_mbar, record::OneInDigits{});
  io("humidity_percent", x.air.humidity_percent, record::OneInDigits{});
}

}  // namespace

void layout(auto& io, record::Is<DriverCall::Aim> auto& x) {
  io("p_W_mm", x.p_W_mm, record::Digits<Eigen::Vector3d>{});
  io("search_radius_mm", x.search_radius_mm, record::OneInDigits{});
}

void layout(auto& io, record::Is<OutcomeHead> auto& x) {
  io("call", x.call);
  io.optional("cancelled", record::Unless{false, x.cancelled});
}

void layout(auto& io, record::Is<DriverCall> auto& x) {
  io("call", x.number);
  io("asked", x.asked, kAsked);
  if (io.has("until_ns", has_outcome(x.asked)))
    io("until_ns", x.deadline, record::Nanoseconds{}, record::kTime);
  if (io.has("move", x.asked == Asked::Move)) io("move", x.move);
  if (io.has("aim", x.asked == Asked::Aim)) io("aim", x.aim);
  if (io.has("average_ns", x.asked == Asked::AverageOver)) io("average_ns", x.average, record::kTime);
}

std::string_view name(Asked asked) { return name_of(kAsked, asked); }

std::string text(const DriverCall& call) { return record::text_of(call); }
std::expected<DriverCall, std::string> read_call(std::string_view text) {
  return record::read_text<DriverCall>(text, "call");
}
std::expected<OutcomeHead, std::string> read_outcome(std::string_view text) {
  return record::read_text<OutcomeHead>(text, "outcome");
}

std::string outcome_text(std::uint64_t call, const std::expected<void, drivers::RobotError>& outcome) {
  return text_of(call, outcome);
}
std::string outcome_text(std::uint64_t call,
                         const std::expected<drivers::RobotIdentity, drivers::RobotError>& outcome) {
  return text_of(call, outcome);
}
std::string outcome_text(std::uint64_t call,
                         const std::expected<drivers::RobotState, drivers::RobotError>& outcome) {
  return text_of(call, outcome);
}
std::string outcome_text(std::uint64_t call, const std::expected<JointVector, drivers::RobotError>& outcome) {
  return text_of(call, outcome);
}
std::string outcome_text(std::uint64_t call, const std::expected<void, drivers::TrackerError>& outcome) {
  return text_of(call, outcome);
}
std::string outcome_text(std::uint64_t call,
                         const std::expected<drivers::TrackerIdentity, drivers::TrackerError>& outcome) {
  return text_of(call, outcome);
}
std::string outcome_text(std::uint64_t call,
                         const std::expected<drivers::SmrPoint, drivers::TrackerError>& outcome) {
  return text_of(call, outcome);
}

std::string outcome_text(std::uint64_t call, std::exception_ptr thrown) {
  DriverOutcome<Done> ended{.head = {.call = call}, .answer = {}, .failure = {}};
  try {
    std::rethrow_exception(std::move(thrown));
  } catch (const boost::system::system_error& error) {
    ended.head.cancelled = error.code() == boost::asio::error::operation_aborted;
    if (!ended.head.cancelled) ended.failure = {"exception", error.what()};
  } catch (const std::exception& error) {
    ended.failure = {"exception", error.what()};
  }
  return record::text_of(ended);
}

std::string text(const ToldAir& air) {
  AirRecord told;
  if (air) told.air = *air;
  if (!air) told.why_not = air.error();
  return record::text_of(told);
}

std::expected<ToldAir, std::string> read_air(std::string_view text) {
  const auto told = record::read_text<AirRecord>(text, "air");
  if (!told) return std::unexpected(told.error());
  if (!told->why_not.empty()) return ToldAir{std::unexpected(told->why_not)};
  return ToldAir{told->air};
}

}  // namespace daemon
}  // namespace truepose
