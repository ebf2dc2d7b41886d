#include "tools/sim/rsi_flow.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "core/math/angles.hpp"

namespace truepose::sim {
namespace {

/// What counts something; far from what any controller takes it is as far as int reaches.
int whole(double number) {
  constexpr double kMost = 1e9;
  return std::isnan(number) ? 0 : static_cast<int>(std::clamp(number, -kMost, kMost));
}

/// Of a flow whose parameters are all set.
double number(const rsi::ContextObject& object, std::string_view parameter) {
  return object.number(parameter).value_or(0);
}

int whole(const rsi::ContextObject& object, std::string_view parameter) {
  return whole(number(object, parameter));
}

/// What holds in a controller: parameters that are not given, and the monitors where there are none.
rsi::Context with_what_holds(rsi::Context context) {
  for (const char* monitor : {"AXISCORRMON", "POSCORRMON"}) {
    if (context.of_type(monitor) == nullptr) context.objects.push_back({.type = monitor, .id = monitor});
  }
  for (rsi::ContextObject& object : context.objects) {
    const rsi::CatalogueObject* const kind = rsi::catalogued(object.type);
    if (kind == nullptr) continue;
    for (const rsi::CatalogueParameter& parameter : kind->parameters) {
      const std::string value =
          parameter.values.empty()
              ? parameter.otherwise
              : std::to_string(rsi::number_of(object.type, parameter.name, parameter.otherwise));
      object.values.emplace(parameter.name, value);
    }
  }
  return context;
}

double value_at(const ChannelValues& values, const rsi::ContextObject& object, int input) {
  const auto wire = object.inputs.find(input);
  if (wire == object.inputs.end()) return 0;
  const auto value = values.find(wire->second.number);
  return value == values.end() ? 0 : value->second;
}

std::optional<PoseCorrection::System> correction_system(const rsi::ContextObject& object) {
  constexpr int kSystems = 4;
  const int number = whole(object, "RefCorrSys");
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
  if (object.type == "SEN_PINT") return sources.sen_pint(whole(object, "Index"));
  if (object.type == "OV_PRO") return sources.override_percent;
  if (object.type != "STATUS") return std::nullopt;
  static const int of_mode = rsi::number_of("STATUS", "Type", rsi::kOperatingMode);
  static const int of_program = rsi::number_of("STATUS", "Type", rsi::kProgramState);
  const int type = whole(object, "Type");
  if (type == of_mode) return sources.mode;
  if (type == of_program) return sources.program_state;
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
      return object.id + ": only Type 2 (state of the robot program) and 5 (operating mode) are simulated";
    if (object.type == "STOP" && whole(object, "Mode") != rsi::number_of("STOP", "Mode", rsi::kExitMoveCorr))
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
  context = with_what_holds(std::move(context));
  if (auto what = not_simulated(context)) return std::unexpected(*std::move(what));
  return RsiFlow{std::move(context)};
}

int RsiFlow::timeout_cycles() const { return whole(ethernet(), "Timeout"); }
int RsiFlow::decimals() const { return whole(ethernet(), "Precision"); }

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
      effects.sen_pint[whole(object, "Index")] = whole(value_at(received, object, 1));
  }
  monitor(effects);
  return effects;
}

void RsiFlow::correct(const rsi::ContextObject& object, const ChannelValues& received,
                      FlowEffects& effects) const {
  for (std::size_t i = 0; i < effects.correction_deg.size(); ++i) {
    const std::string axis = "A" + std::to_string(i + 1);
    const double wanted_deg = value_at(received, object, static_cast<int>(i) + 1);
    const double lower_deg = number(object, "LowerLim" + axis);
    const double upper_deg = number(object, "UpperLim" + axis);
    effects.correction_deg[i] = clamped_to(wanted_deg, lower_deg, upper_deg, effects.clamped);
  }
}

PoseCorrection RsiFlow::pose_correction(const rsi::ContextObject& object, const ChannelValues& received,
                                        bool& clamped) const {
  PoseCorrection correction{.system = *correction_system(object)};
  Eigen::Vector3d abc_deg;
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, "XYZ"[i]);
    correction.mm[i] = clamped_to(value_at(received, object, i + 1), number(object, "LowerLim" + axis),
                                  number(object, "UpperLim" + axis), clamped);
    abc_deg[i] = value_at(received, object, i + 4);
  }
  const Eigen::Matrix3d wanted = pose_from_kuka({0, 0, 0}, abc_deg).linear();
  const Eigen::Vector3d turn = turn_between(Eigen::Matrix3d::Identity(), wanted);
  const double most_rad = number(object, "MaxRotAngle") * kRadPerDeg;
  const double angle_rad = clamped_to(turn.norm(), 0, most_rad, clamped);
  correction.turn = turn.norm() > 0 ? rotation_by(angle_rad / turn.norm() * turn) : wanted;
  return correction;
}

void RsiFlow::monitor(FlowEffects& effects) const {
  const rsi::ContextObject& ceiling = *context_.of_type("AXISCORRMON");
  for (std::size_t i = effects.correction_deg.size(); i-- > 0;) {
    if (std::abs(effects.correction_deg[i]) > number(ceiling, "MaxA" + std::to_string(i + 1)))
      effects.monitor_axis = static_cast<int>(i) + 1;
  }
  effects.monitor_pose = effects.pose_correction && stops_at(*effects.pose_correction);
}

bool RsiFlow::stops_at(const PoseCorrection& correction) const {
  const rsi::ContextObject& ceiling = *context_.of_type("POSCORRMON");
  const double turned_rad = angle_between(Eigen::Matrix3d::Identity(), correction.turn);
  return correction.mm.norm() > number(ceiling, "MaxTrans") ||
         turned_rad > number(ceiling, "MaxRotAngle") * kRadPerDeg;
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
