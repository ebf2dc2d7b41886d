#pragma once

#include <expected>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/object_catalogue.hpp"

namespace truepose::rsi {

/// The output of an object, counted from 1 as it is drawn.
struct ContextOutput {
  std::string object;  ///< "ETHERNET1"
  int number = 1;

  bool operator==(const ContextOutput&) const = default;
};

/// One object of a signal flow.
struct ContextObject {
  std::string type;                                          ///< in capitals: "AXISCORR"
  std::string id;                                            ///< "AXISCORR1"
  std::map<int, ContextOutput> inputs{};                     ///< what leads to its inputs, counted from 1
  std::map<std::string, std::string, std::less<>> values{};  ///< of its parameters, by their names

  std::optional<double> number(std::string_view parameter) const;
  bool operator==(const ContextObject&) const = default;
};

/// The signal flow that a controller runs in every cycle while RSI is on.
struct Context {
  std::vector<ContextObject> objects;

  /// The first of a type; null where there is none.
  const ContextObject* of_type(std::string_view type) const;
  const ContextObject* with_id(std::string_view id) const;
  bool operator==(const Context&) const = default;
};

/// Reads the text of a .rsi.xml or any .rsix file. What an object is wired to and its parameters are
/// understood by their ordinals as the controller does, so that a file made for the other format is refused
/// and not misread. The letter case of a type's name is free. Objects of types that the catalogue does not
/// have keep their wires and lose their parameters.
/// Error: one sentence that names the object.
std::expected<Context, std::string> parse_context(std::string_view xml);

/// Values of enumerations by which program and PC understand each other.
inline constexpr std::string_view kProgramState = "ProState_R", kOperatingMode = "Mode_Op";  // of STATUS
inline constexpr std::string_view kExitMoveCorr = "ExitMoveCorr";                            // of STOP

/// The file's text. Every type must be one that the catalogue has for the format.
std::string context_xml(const Context& context, ContextFormat format);

/// What the context of truepose is to do.
struct ContextDemands {
  std::string ethernet_file = "truepose_rsi_ethernet.xml";  ///< where the controller looks for it
  int timeout_cycles = 100;
  double max_total_deg = 3;  ///< greatest correction of an axis that the daemon sends
  double cycle_ms = 4;
};

/// The signal flow for the shipped ethernet configuration: AK to AXISCORR, Stop to STOP (which leaves
/// RSI_MOVECORR), Tp.Ask from $SEN_PINT[1], Tp.Pro from $PRO_STATE, Tp.Mode from the operating mode, Tp.Ov
/// from $OV_PRO, Tp.Cell from $SEN_PINT[3], Tp.Gain to $SEN_PINT[2].
Context truepose_context(const ContextDemands& demands);

/// What in this context would keep that ethernet configuration's corrections from the axes, or handle them
/// otherwise than the daemon takes for granted: of lint_kinds.hpp.
std::vector<Message> lint(const Context& context, const EthernetConfig& ethernet,
                          const ContextDemands& demands);

}  // namespace truepose::rsi
