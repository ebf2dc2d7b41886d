#include "tools/sim/controller/rsi_signals.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <string_view>

namespace truepose::sim {
namespace {

using rsi::Context;
using rsi::ContextObject;

/// How many inputs or outputs of the controller a DataType covers (RSI 3: DataSize).
int width(const ContextObject& object) {
  constexpr std::array kRead{1, 8, 8, 16, 16, 32, 32}, kWritten{1, 8, 16, 16, 16, 16, 16};
  const auto type = object.number("DataType") ? whole(object, "DataType") : whole(object, "DataSize");
  const auto& bits = object.type == "MAP2DIGOUT" ? kWritten : kRead;
  return bits[static_cast<std::size_t>(std::clamp(type, 0, static_cast<int>(bits.size()) - 1))];
}

double wave(const ContextObject& object, double time_s) {
  const double periods = time_s / std::max(parameter_of(object, "Period"), 1e-3);
  const double phase = periods - std::floor(periods);
  static const std::map<int, std::function<double(double)>> kWaves{
      {rsi::number_of("SOURCE", "Type", "Const"), [](double) { return 0.0; }},
      {rsi::number_of("SOURCE", "Type", "Sin"),
       [](double at) { return std::sin(2 * std::numbers::pi * at); }},
      {rsi::number_of("SOURCE", "Type", "Cos"),
       [](double at) { return std::cos(2 * std::numbers::pi * at); }},
      {rsi::number_of("SOURCE", "Type", "Square"), [](double at) { return at < 0.5 ? 1.0 : -1.0; }},
      {rsi::number_of("SOURCE", "Type", "Sawtooth"), [](double at) { return 2 * at - 1; }}};
  const auto known = kWaves.find(whole(object, "Type"));
  const double swing = known == kWaves.end() ? 0 : known->second(phase);
  return parameter_of(object, "Offset") + parameter_of(object, "Amplitude") * swing;
}

std::optional<int> status(const ContextObject& object, const FlowSources& sources) {
  static const int of_mode = rsi::number_of("STATUS", "Type", rsi::kOperatingMode);
  static const int of_program = rsi::number_of("STATUS", "Type", rsi::kProgramState);
  const int type = whole(object, "Type");
  if (type == of_mode) return sources.mode;
  if (type == of_program) return sources.program_state;
  return std::nullopt;
}

bool can_be_asked(std::string_view type) {
  static const std::set<std::string_view> kSources{"ETHERNET", "SEN_PINT", "SEN_PREA", "STATUS",
                                                   "OV_PRO",   "DIGIN",    "DIGOUT",   "AXISACT",
                                                   "SOURCE",   "CONSTANT", "LIMIT",    "GEARTORQUE"};
  return kSources.contains(type);
}

/// Whether a signal leads from an object back to it.
bool depends_on(const Context& context, const ContextObject& object, const ContextObject& on,
                std::set<std::string>& seen) {
  return std::ranges::any_of(object.inputs, [&](const auto& wire) {
    const ContextObject& from = *context.with_id(wire.second.object);
    return &from == &on || (seen.insert(from.id).second && depends_on(context, from, on, seen));
  });
}

}  // namespace

int whole(double number) {
  constexpr double kMost = 1e9;
  return std::isnan(number) ? 0 : static_cast<int>(std::clamp(number, -kMost, kMost));
}

double parameter_of(const rsi::ContextObject& object, std::string_view parameter) {
  return object.number(parameter).value_or(0);
}

int whole(const rsi::ContextObject& object, std::string_view parameter) {
  return whole(parameter_of(object, parameter));
}

double RsiSignals::input(const ContextObject& object, int number) const {
  const auto wire = object.inputs.find(number);
  return wire == object.inputs.end() ? 0 : output(wire->second);
}

ControllerBits bits_of(const ContextObject& object) {
  constexpr int kMostIndex = 8192;
  const int count = width(object), index = std::clamp(whole(object, "Index"), 0, kMostIndex);
  return {.first = count == 1 ? index : 8 * index + 1, .count = count};  // a wider type counts bytes
}

double RsiSignals::of_controller_bits(const ContextObject& object) const {
  const auto& bit = object.type == "DIGIN" ? sources_.in : sources_.out;
  const ControllerBits bits = bits_of(object);
  double value = 0;
  for (int i = 0; i < bits.count; ++i) value += bit(bits.first + i) ? std::ldexp(1, i) : 0;
  return value;
}

double RsiSignals::output(const rsi::ContextOutput& from) const {
  const ContextObject& object = *context_.with_id(from.object);
  if (object.type == "ETHERNET") {
    const auto value = received_.find(from.number);
    return value == received_.end() ? 0 : value->second;
  }
  if (object.type == "SEN_PINT") return sources_.sen_pint(whole(object, "Index"));
  if (object.type == "SEN_PREA") return sources_.sen_prea(whole(object, "Index"));
  if (object.type == "OV_PRO") return sources_.override_percent;
  if (object.type == "STATUS") return status(object, sources_).value_or(0);
  if (object.type == "DIGIN" || object.type == "DIGOUT") return of_controller_bits(object);
  if (object.type == "AXISACT") return sources_.axes_deg[static_cast<std::size_t>(from.number) - 1];
  if (object.type == "SOURCE") return wave(object, sources_.time_s);
  if (object.type == "CONSTANT") return parameter_of(object, "Value");
  if (object.type == "LIMIT") {
    const double lower = parameter_of(object, "LowerLimit"), upper = parameter_of(object, "UpperLimit");
    return std::min(std::max(input(object, 1), lower), upper);
  }
  return 0;
}

std::optional<std::string> RsiSignals::not_simulated(const Context& context) {
  for (const ContextObject& object : context.objects) {
    if (object.type == "STATUS" && !status(object, {}))
      return object.id + ": only Type 2 (state of the robot program) and 5 (operating mode) are simulated";
    std::set<std::string> seen;
    if (depends_on(context, object, object, seen))
      return object.id + ": a signal leads from it back to it (\"Circular linking\")";
    if (object.type == "MONITOR") continue;  // shows its inputs, and changes nothing
    for (const auto& [number, from] : object.inputs) {
      if (!can_be_asked(context.with_id(from.object)->type))
        return object.id + ": a wire from " + from.object + " to here is not simulated";
    }
  }
  return std::nullopt;
}

}  // namespace truepose::sim
