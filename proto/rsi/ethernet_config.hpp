#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace truepose {
struct Message;
}

namespace truepose::rsi {

enum class ElementType { Bool, String, Long, Double };

/// Element by which a robot program and truepose understand each other, in both lists: <Tp Ask="1" Pro="3"/>
/// from the controller, <Tp Gain="100"/> to it.
inline constexpr std::string_view kProgramElement = "Tp";
inline constexpr std::string_view kGainTag = "Tp.Gain";

/// One ELEMENT of the SEND (controller to PC) or RECEIVE (PC to controller) list.
struct Element {
  std::string tag;  ///< as in the file: "DEF_RIst", "AK.A1", "Stop"
  ElementType type = ElementType::Double;
  std::optional<int> index;  ///< channel of the ETHERNET object, 1..64; empty = INTERNAL
  bool hold_on = false;      ///< RECEIVE: keep the last value in a cycle without a valid reply

  bool operator==(const Element&) const = default;
};

/// The RSI ethernet configuration that the controller loads: where it sends to, and what the elements are
/// called.
struct EthernetConfig {
  std::string address;  ///< the PC's
  std::uint16_t port = 0;
  std::string sentype;  ///< what Sen/@Type must be, or the controller silently discards the reply
  bool only_send = false;
  std::vector<Element> send;
  std::vector<Element> receive;

  /// Name of the RECEIVE element with the attributes A1..A6, all DOUBLE; the first where there are several.
  std::optional<std::string> axis_correction;
  /// Name of the RECEIVE element that asks the controller to leave RSI_MOVECORR: a BOOL called Stop, in any
  /// case.
  std::optional<std::string> stop;
  /// Whether the RECEIVE list has kGainTag, a LONG: how far the correction is ramped in.
  bool gain = false;

  /// Whether the SEND list has the built-in keyword, e.g. sends("ASPos").
  bool sends(std::string_view keyword) const;
};

/// Reads the file's text. Error: one sentence that names the element at fault.
std::expected<EthernetConfig, std::string> parse_ethernet_config(std::string_view xml);

/// What would make this configuration fail or behave badly with absolute axis corrections: of lint_kinds.hpp.
std::vector<Message> lint(const EthernetConfig& config);

}  // namespace truepose::rsi
