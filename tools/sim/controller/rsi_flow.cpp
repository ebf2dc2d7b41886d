#include "tools/sim/controller/rsi_flow.hpp"

#include <algorithm>
#include <boost/algorithm/string/predicate.hpp>
#include <cmath>
#include <set>
#include <string_view>

#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "tools/sim/controller/rsi_signals.hpp"

namespace truepose::sim {
namespace {

/// What holds in a controller: parameters that are not given, and the monitors where there are none.
rsi::Context with_defaults(rsi::Context context) {
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

/// The object, and the parameter's name in the catalogue.
std::optional<std::pair<const rsi::ContextObject*, std::string>> find(const rsi::Context& context,
                                                                      const RsiParameter& parameter) {
  using boost::algorithm::iequals;
  for (const rsi::ContextObject& object : context.objects) {
    const rsi::CatalogueObject* const kind = rsi::catalogued(object.type);
    if (kind == nullptr || !iequals(object.id, parameter.object)) continue;
    for (const rsi::CatalogueParameter& one : kind->parameters)
      if (one.values.empty() && iequals(one.name, parameter.parameter)) return std::pair{&object, one.name};
  }
  return std::nullopt;
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

std::optional<std::string> not_simulated(const rsi::Context& context) {
  static const std::set<std::string_view> kKnown{
      "ETHERNET",     "AXISCORR",     "AXISCORRMON", "POSCORR",    "POSCORRMON", "STOP",
      "STATUS",       "OV_PRO",       "SEN_PINT",    "SEN_PREA",   "DIGIN",      "DIGOUT",
      "AXISACT",      "GEARTORQUE",   "SOURCE",      "MAP2DIGOUT", "LIMIT",      "MONITOR",
      "MAP2SEN_PINT", "MAP2SEN_PREA", "CONSTANT",    "MAP2ANOUT"};
  for (const rsi::ContextObject& object : context.objects) {
    if (object.type == "AXISCORREXT") return object.id + ": the simulated arm has no external axes";
    if (!kKnown.contains(object.type)) return object.id + ": " + object.type + " is not simulated";
    if (object.type == "POSCORR" && !correction_system(object))
      return object.id + ": only RefCorrSys 0 to 3 (world, base, robot root, tool) are simulated";
    if (object.type == "STOP" && whole(object, "Mode") != rsi::number_of("STOP", "Mode", rsi::kExitMoveCorr))
      return object.id + ": only Mode 4 (leaves RSI_MOVECORR) is simulated";
  }
  return RsiSignals::not_simulated(context);
}

void write_outputs(const rsi::ContextObject& object, double value, FlowEffects& effects) {
  const ControllerBits bits = bits_of(object);
  const auto number = static_cast<unsigned>(whole(value));
  for (int i = 0; i < bits.count; ++i)
    effects.outputs[bits.first + i] = bits.count == 1 ? value != 0 : (number >> i & 1u) != 0;
}

}  // namespace

std::optional<double> value_of(const rsi::Context& context, const RsiParameter& parameter) {
  const rsi::Context holds = with_defaults(context);
  const auto found = find(holds, parameter);
  return found ? found->first->number(found->second) : std::nullopt;
}

void set_parameter(rsi::Context& context, const RsiParameter& parameter) {
  context = with_defaults(std::move(context));
  const auto found = find(context, parameter);
  if (!found) return;
  auto& object = context.objects[static_cast<std::size_t>(found->first - context.objects.data())];
  object.values[found->second] = formatted("%.9g", parameter.value);
}

std::expected<RsiFlow, std::string> RsiFlow::of(rsi::Context context) {
  if (context.of_type("ETHERNET") == nullptr) return std::unexpected("there is no ETHERNET object");
  context = with_defaults(std::move(context));
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
  const ChannelValues nothing;  // of what comes from the PC nothing goes back
  const RsiSignals signals{context_, sources, nothing};
  ChannelValues values;
  for (const auto& [input, from] : ethernet().inputs) values[input] = signals.output(from);
  return values;
}

FlowEffects RsiFlow::effects(const FlowSources& sources, const ChannelValues& received,
                             const FlowEffects& total) const {
  const RsiSignals signals{context_, sources, received};
  FlowEffects effects{.correction_deg = total.correction_deg};
  for (const rsi::ContextObject& object : context_.objects) {
    if (object.type == "AXISCORR") correct(object, signals, effects);
    if (object.type == "POSCORR")
      effects.pose_correction = pose_correction(object, signals, total.pose_correction, effects.clamped);
    if (object.type == "STOP") effects.leaves_movecorr |= signals.input(object, 1) != 0;
    if (object.type == "MAP2SEN_PINT")
      effects.sen_pint[whole(object, "Index")] = whole(signals.input(object, 1));
    if (object.type == "MAP2SEN_PREA") effects.sen_prea[whole(object, "Index")] = signals.input(object, 1);
    if (object.type == "MAP2ANOUT") effects.analog[whole(object, "Index")] = signals.input(object, 1);
    if (object.type == "MAP2DIGOUT") write_outputs(object, signals.input(object, 1), effects);
  }
  monitor(effects);
  return effects;
}

void RsiFlow::correct(const rsi::ContextObject& object, const RsiSignals& signals,
                      FlowEffects& effects) const {
  for (std::size_t i = 0; i < effects.correction_deg.size(); ++i) {
    const std::string axis = "A" + std::to_string(i + 1);
    const double wanted_deg = effects.correction_deg[i] + signals.input(object, static_cast<int>(i) + 1);
    const double lower_deg = parameter_of(object, "LowerLim" + axis);
    const double upper_deg = parameter_of(object, "UpperLim" + axis);
    effects.correction_deg[i] = clamped_to(wanted_deg, lower_deg, upper_deg, effects.clamped);
  }
}

PoseCorrection RsiFlow::pose_correction(const rsi::ContextObject& object, const RsiSignals& signals,
                                        const std::optional<PoseCorrection>& total, bool& clamped) const {
  PoseCorrection correction = total.value_or(PoseCorrection{});
  correction.system = *correction_system(object);
  Eigen::Vector3d abc_deg;
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, "XYZ"[i]);
    correction.mm[i] =
        clamped_to(correction.mm[i] + signals.input(object, i + 1), parameter_of(object, "LowerLim" + axis),
                   parameter_of(object, "UpperLim" + axis), clamped);
    abc_deg[i] = signals.input(object, i + 4);
  }
  const Eigen::Matrix3d wanted = pose_from_kuka({0, 0, 0}, abc_deg).linear() * correction.turn;
  const Eigen::Vector3d turn = turn_between(Eigen::Matrix3d::Identity(), wanted);
  const double most_rad = parameter_of(object, "MaxRotAngle") * kRadPerDeg;
  const double angle_rad = clamped_to(turn.norm(), 0, most_rad, clamped);
  correction.turn = turn.norm() > 0 ? rotation_by(angle_rad / turn.norm() * turn) : wanted;
  return correction;
}

void RsiFlow::monitor(FlowEffects& effects) const {
  const rsi::ContextObject& ceiling = *context_.of_type("AXISCORRMON");
  for (std::size_t i = effects.correction_deg.size(); i-- > 0;) {
    if (std::abs(effects.correction_deg[i]) > parameter_of(ceiling, "MaxA" + std::to_string(i + 1)))
      effects.monitor_axis = static_cast<int>(i) + 1;
  }
  effects.monitor_pose = effects.pose_correction && stops_at(*effects.pose_correction);
}

bool RsiFlow::stops_at(const PoseCorrection& correction) const {
  const rsi::ContextObject& ceiling = *context_.of_type("POSCORRMON");
  const double turned_rad = angle_between(Eigen::Matrix3d::Identity(), correction.turn);
  return correction.mm.norm() > parameter_of(ceiling, "MaxTrans") ||
         turned_rad > parameter_of(ceiling, "MaxRotAngle") * kRadPerDeg;
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
