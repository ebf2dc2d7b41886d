#include "tools/sim/rsi_flow.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "core/math/angles.hpp"

namespace truepose::sim {
namespace {

constexpr int kStatusOfMode = 1, kStatusOfProgram = 2, kStopLeavesMovecorr = 4;
constexpr int kDefaultTimeout = 10, kDefaultPrecision = 1;  // cycles and digits, of an ETHERNET object

/// What counts something; far from what any controller takes it is as far as int reaches.
int whole(double number) {
  constexpr double kMost = 1e9;
  return std::isnan(number) ? 0 : static_cast<int>(std::clamp(number, -kMost, kMost));
}

int whole(const rsi::ContextObject& object, std::string_view parameter, int otherwise) {
  return whole(object.number(parameter).value_or(otherwise));
}

double value_at(const ChannelValues& values, const rsi::ContextObject& object, int input) {
  const auto wire = object.inputs.find(input);
  if (wire == object.inputs.end()) return 0;
  const auto value = values.find(wire->second.number);
  return value == values.end() ? 0 : value->second;
}

std::optional<PoseCorrection::System> correction_system(const rsi::ContextObject& object) {
  constexpr int kSystems = 4;
  const int number = whole(object, "RefCorrSys", 0);
  if (number < 0 || number >= kSystems) return std::nullopt;
  return static_cast<PoseCorrection::System>(number);
}

double clamped_to(double value, double lower, double upper, bool& clamped) {
  const double within = std::min(std::max(value, lower), upper);
  clamped |= within != value;
  return within;
}

/// What an object says that asks the controller; none where that is not simulated.
std::optional<int> told(const rsi::ContextObject& object, const FlowSources& sources) {
  if (object.type == "SEN_PINT") return sources.sen_pint(whole(object, "Index", 1));
  if (object.type == "OV_PRO") return sources.override_percent;
  if (object.type != "STATUS") return std::nullopt;
  const int type = whole(object, "Type", 0);
  if (type == kStatusOfMode) return sources.mode;
  if (type == kStatusOfProgram) return sources.program_state;
  return std::nullopt;
}

bool asks_the_controller(std::string_view type) {
  return type == "SEN_PINT" || type == "STATUS" || type == "OV_PRO";
}

std::optional<std::string> not_simulated(const rsi::Context& context) {
  static const std::set<std::string_view> kKnown{"ETHERNET",   "AXISCORR",    "AXISCORRMON", "POSCORR",
                                                 "POSCORRMON", "STOP",        "STATUS",      "OV_PRO",
                                                 "SEN_PINT",   "MAP2SEN_PINT"};
  for (const rsi::ContextObject& object : context.objects) {
    if (!kKnown.contains(object.type)) return object.id + ": " + object.type + " is not simulated";
    if (object.type == "POSCORR" && !correction_system(object))
      return object.id + ": only RefCorrSys 0 to 3 (world, base, robot root, tool) are simulated";
    if (object.type == "STATUS" && !told(object, {}))
      return object.id + ": only Type 1 (operating mode) and 2 (program state) are simulated";
    if (object.type == "STOP" && whole(object, "Mode", 0) != kStopLeavesMovecorr)
      return object.id + ": only Mode 4 (leaves RSI_MOVECORR) is simulated";
    for (const auto& [input, from] : object.inputs) {
      const std::string_view source = context.with_id(from.object)->type;
      const bool sends = object.type == "ETHERNET";
      if (sends ? !asks_the_controller(source) : source != "ETHERNET")
        return object.id + ": a wire from " + from.object + " to here is not simulated";
    }
  }
  return std::nullopt;
}

}  // namespace

std::expected<RsiFlow, std::string> RsiFlow::of(rsi::Context context) {
  if (context.of_type("ETHERNET") == nullptr) return std::unexpected("there is no ETHERNET object");
  if (auto what = not_simulated(context)) return std::unexpected(*std::move(what));
  return RsiFlow{std::move(context)};
}

int RsiFlow::timeout_cycles() const { return whole(ethernet(), "Timeout", kDefaultTimeout); }
int RsiFlow::decimals() const { return whole(ethernet(), "Precision", kDefaultPrecision); }

std::string RsiFlow::ethernet_file() const {
  const auto file = ethernet().values.find("ConfigFile");
  return file == ethernet().values.end() ? std::string{} : file->second;
}

ChannelValues RsiFlow::sent(const FlowSources& sources) const {
  ChannelValues values;
  for (const auto& [input, from] : ethernet().inputs) {
    const rsi::ContextObject& source = *context_.with_id(from.object);
    values[input] = *told(source, sources);
  }
  return values;
}

FlowEffects RsiFlow::effects(const ChannelValues& received) const {
  FlowEffects effects;
  for (const rsi::ContextObject& object : context_.objects) {
    if (object.type == "AXISCORR") correct(object, received, effects);
    if (object.type == "POSCORR")
      effects.pose_correction = pose_correction(object, received, effects.clamped);
    if (object.type == "STOP") effects.leaves_movecorr |= value_at(received, object, 1) != 0;
    if (object.type == "MAP2SEN_PINT")
      effects.sen_pint[whole(object, "Index", 1)] = whole(value_at(received, object, 1));
  }
  monitor(effects);
  return effects;
}

void RsiFlow::correct(const rsi::ContextObject& object, const ChannelValues& received,
                      FlowEffects& effects) const {
  constexpr double kDefaultLimit_deg = 5;
  for (std::size_t i = 0; i < effects.correction_deg.size(); ++i) {
    const std::string axis = "A" + std::to_string(i + 1);
    const double wanted_deg = value_at(received, object, static_cast<int>(i) + 1);
    const double lower_deg = object.number("LowerLim" + axis).value_or(-kDefaultLimit_deg);
    const double upper_deg = object.number("UpperLim" + axis).value_or(kDefaultLimit_deg);
    effects.correction_deg[i] = clamped_to(wanted_deg, lower_deg, upper_deg, effects.clamped);
  }
}

PoseCorrection RsiFlow::pose_correction(const rsi::ContextObject& object, const ChannelValues& received,
                                        bool& clamped) const {
  constexpr double kDefaultLimit_mm = 5, kDefaultTurn_deg = 5;
  PoseCorrection correction{.system = *correction_system(object)};
  Eigen::Vector3d abc_deg;
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, "XYZ"[i]);
    correction.mm[i] = clamped_to(value_at(received, object, i + 1),
                                  object.number("LowerLim" + axis).value_or(-kDefaultLimit_mm),
                                  object.number("UpperLim" + axis).value_or(kDefaultLimit_mm), clamped);
    abc_deg[i] = value_at(received, object, i + 4);
  }
  const Eigen::Matrix3d wanted = pose_from_kuka({0, 0, 0}, abc_deg).linear();
  const Eigen::Vector3d turn = turn_between(Eigen::Matrix3d::Identity(), wanted);
  const double most_rad = object.number("MaxRotAngle").value_or(kDefaultTurn_deg) * kRadPerDeg;
  const double angle_rad = clamped_to(turn.norm(), 0, most_rad, clamped);
  correction.turn = turn.norm() > 0 ? rotation_by(angle_rad / turn.norm() * turn) : wanted;
  return correction;
}

void RsiFlow::monitor(FlowEffects& effects) const {
  constexpr double kDefaultMost_deg = 6;  // also where there is no such object
  const rsi::ContextObject* const monitor = context_.of_type("AXISCORRMON");
  for (std::size_t i = effects.correction_deg.size(); i-- > 0;) {
    const auto set_deg = monitor == nullptr ? std::nullopt : monitor->number("MaxA" + std::to_string(i + 1));
    if (std::abs(effects.correction_deg[i]) > set_deg.value_or(kDefaultMost_deg))
      effects.monitor_axis = static_cast<int>(i) + 1;
  }
  effects.monitor_pose = effects.pose_correction && stops_at(*effects.pose_correction);
}

bool RsiFlow::stops_at(const PoseCorrection& correction) const {
  constexpr double kDefaultMost = 6;  // mm and deg, also where there is no such object
  const rsi::ContextObject* const monitor = context_.of_type("POSCORRMON");
  const auto most = [&](std::string_view name) {
    return (monitor == nullptr ? std::nullopt : monitor->number(name)).value_or(kDefaultMost);
  };
  const double turned_rad = angle_between(Eigen::Matrix3d::Identity(), correction.turn);
  return correction.mm.norm() > most("MaxTrans") || turned_rad > most("MaxRotAngle") * kRadPerDeg;
}

Eigen::Isometry3d PoseCorrection::applied_to(const Eigen::Isometry3d& X,
                                             const Eigen::Isometry3d& base) const {
  const Eigen::Matrix3d along = system == System::Tool   ? Eigen::Matrix3d{X.linear()}
                                : system == System::Base ? Eigen::Matrix3d{base.linear()}
                                                         : Eigen::Matrix3d::Identity();
  Eigen::Isometry3d corrected = X;
  corrected.translation() += along * mm;
  corrected.linear() = along * turn * along.transpose() * X.linear();
  return corrected;
}

}  // namespace truepose::sim
