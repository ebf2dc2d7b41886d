#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "proto/rsi/context.hpp"
#include "tools/sim/controller/rsi_flow.hpp"

namespace truepose::sim {

/// What counts something; far from what any controller takes it is as far as int reaches.
int whole(double number);
/// A parameter of a flow in which all are set.
double parameter_of(const rsi::ContextObject& object, std::string_view parameter);
int whole(const rsi::ContextObject& object, std::string_view parameter);

/// Inputs or outputs of the controller that DIGIN and DIGOUT read, or MAP2DIGOUT writes.
struct ControllerBits {
  int first = 0, count = 0;
};
ControllerBits bits_of(const rsi::ContextObject& object);

/// What the outputs of a signal flow's objects carry in one cycle. Objects that can be asked: ETHERNET,
/// SEN_PINT, SEN_PREA, STATUS, OV_PRO, DIGIN and DIGOUT (without sign), AXISACT, GEARTORQUE (0: the arm has
/// no weight), SOURCE, CONSTANT, LIMIT.
class RsiSignals {
 public:
  /// @param context   with all parameters, and no circle; kept by reference, as the others
  /// @param received  by the outputs of ETHERNET; what is not there is 0
  RsiSignals(const rsi::Context& context, const FlowSources& sources, const ChannelValues& received)
      : context_{context}, sources_{sources}, received_{received} {}

  /// What leads to an input; 0 where nothing does.
  double input(const rsi::ContextObject& object, int number) const;
  double output(const rsi::ContextOutput& from) const;

  /// The first object in a flow whose outputs cannot be had, and why; or that depends on itself.
  static std::optional<std::string> not_simulated(const rsi::Context& context);

 private:
  double of_controller_bits(const rsi::ContextObject& object) const;

  const rsi::Context& context_;
  const FlowSources& sources_;
  const ChannelValues& received_;
};

}  // namespace truepose::sim
