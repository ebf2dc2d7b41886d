#pragma once

#include <array>
#include <expected>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/rsi/context.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::sim {

/// What leads from the controller into the signal flow.
struct FlowSources {
  std::function<int(int index)> sen_pint;  ///< $SEN_PINT
  int program_state = rsi::kProgramActive;
};

/// What the signal flow does to the controller in one cycle.
struct FlowEffects {
  rsi::Axes correction_deg{};       ///< of AXISCORR, within its limits
  bool clamped = false;             ///< one of them was larger
  std::optional<int> monitor_axis;  ///< the axis whose correction AXISCORRMON does not allow, from 1
  bool leaves_movecorr = false;     ///< STOP of mode 4
  std::map<int, int> sen_pint;      ///< values for $SEN_PINT, by index
};

/// Values of the ETHERNET object, by the numbers of its inputs or outputs.
using ChannelValues = std::map<int, double>;

/// The signal flow of a context, executed once in each cycle of RSI. Objects: ETHERNET, AXISCORR,
/// AXISCORRMON, STOP, STATUS (program state), SEN_PINT, MAP2SEN_PINT.
class RsiFlow {
 public:
  /// Errors: the object, or its setting, that is not simulated.
  static std::expected<RsiFlow, std::string> of(rsi::Context context);

  int timeout_cycles() const;  ///< of the ETHERNET object
  int decimals() const;        ///< its Precision
  std::string ethernet_file() const;

  /// What ETHERNET sends, by its inputs.
  ChannelValues sent(const FlowSources& sources) const;
  /// @param received  by the outputs of ETHERNET; what is not there is 0
  FlowEffects effects(const ChannelValues& received) const;

 private:
  explicit RsiFlow(rsi::Context context) : context_{std::move(context)} {}
  const rsi::ContextObject& ethernet() const { return *context_.of_type("ETHERNET"); }
  void correct(const rsi::ContextObject& object, const ChannelValues& received, FlowEffects& effects) const;
  void monitor(FlowEffects& effects) const;

  rsi::Context context_;
};

}  // namespace truepose::sim
