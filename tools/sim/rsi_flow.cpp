#include "tools/sim/rsi_flow.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

namespace truepose::sim {
namespace {

constexpr int kStatusOfProgram = 2, kStopLeavesMovecorr = 4;
constexpr int kDefaultTimeout = 10, kDefaultPrecision = 1;  // cycles and digits, of an ETHERNET object

int whole(const rsi::ContextObject& object, std::string_view parameter, int otherwise) {
  return static_cast<int>(object.number(parameter).value_or(otherwise));
}

double value_at(const ChannelValues& values, const rsi::ContextObject& object, int input) {
  const auto wire = object.inputs.find(input);
  if (wire == object.inputs.end()) return 0;
  const auto value = values.find(wire->second.number);
  return value == values.end() ? 0 : value->second;
}

std::optional<std::string> not_simulated(const rsi::Context& context) {
  static const std::set<std::string_view> kKnown{"ETHERNET", "AXISCORR", "AXISCORRMON", "STOP",
                                                 "STATUS",   "SEN_PINT", "MAP2SEN_PINT"};
  for (const rsi::ContextObject& object : context.objects) {
    if (!kKnown.contains(object.type)) return object.id + ": " + object.type + " is not simulated";
    if (object.type == "STATUS" && whole(object, "Type", 0) != kStatusOfProgram)
      return object.id + ": only Type 2 (program state) is simulated";
    if (object.type == "STOP" && whole(object, "Mode", 0) != kStopLeavesMovecorr)
      return object.id + ": only Mode 4 (leaves RSI_MOVECORR) is simulated";
    for (const auto& [input, from] : object.inputs) {
      const std::string_view source = context.with_id(from.object)->type;
      const bool sends = object.type == "ETHERNET";
      if (sends ? source != "SEN_PINT" && source != "STATUS" : source != "ETHERNET")
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
    values[input] =
        source.type == "STATUS" ? sources.program_state : sources.sen_pint(whole(source, "Index", 1));
  }
  return values;
}

FlowEffects RsiFlow::effects(const ChannelValues& received) const {
  FlowEffects effects;
  for (const rsi::ContextObject& object : context_.objects) {
    if (object.type == "AXISCORR") correct(object, received, effects);
    if (object.type == "STOP") effects.leaves_movecorr |= value_at(received, object, 1) != 0;
    if (object.type == "MAP2SEN_PINT")
      effects.sen_pint[whole(object, "Index", 1)] = static_cast<int>(value_at(received, object, 1));
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
    effects.correction_deg[i] = std::clamp(wanted_deg, lower_deg, upper_deg);
    effects.clamped |= effects.correction_deg[i] != wanted_deg;
  }
}

void RsiFlow::monitor(FlowEffects& effects) const {
  const rsi::ContextObject* const monitor = context_.of_type("AXISCORRMON");
  if (monitor == nullptr) return;
  for (std::size_t i = effects.correction_deg.size(); i-- > 0;) {
    const auto most_deg = monitor->number("MaxA" + std::to_string(i + 1));
    if (most_deg && std::abs(effects.correction_deg[i]) > *most_deg)
      effects.monitor_axis = static_cast<int>(i) + 1;
  }
}

}  // namespace truepose::sim
