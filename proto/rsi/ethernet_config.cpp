#include "proto/rsi/ethernet_config.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <pugixml.hpp>

#include "proto/rsi/lint_kinds.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::rsi {
namespace {

constexpr int kMaxChannels = 64;          // inputs and outputs of the ETHERNET object
constexpr std::size_t kLongestName = 64;  // a reply with all its names fits into its buffer

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::toupper(x) == std::toupper(y); });
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}

/// Whether a reply can carry the text as the name of an element.
bool is_name(std::string_view text) {
  const auto goes_on = [](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '.' || c == '-'; };
  return !text.empty() && text.size() <= kLongestName && is_letter(text[0]) &&
         std::ranges::all_of(text, goes_on);
}

/// Whether a reply can carry the text in quotes.
bool is_plain(std::string_view text) {
  const auto is_plain_one = [](char c) {
    return static_cast<unsigned char>(c) >= ' ' && c != 0x7f && !std::string_view{"<>&\"'"}.contains(c);
  };
  return !text.empty() && text.size() <= kLongestName && std::ranges::all_of(text, is_plain_one);
}

std::optional<bool> to_flag(std::string_view text) {
  text = xml::trimmed(text);
  if (text == "1" || equal_ignoring_case(text, "TRUE")) return true;
  if (text == "0" || equal_ignoring_case(text, "FALSE")) return false;
  return std::nullopt;
}

std::optional<ElementType> to_type(std::string_view text) {
  if (text == "BOOL") return ElementType::Bool;
  if (text == "STRING") return ElementType::String;
  if (text == "LONG") return ElementType::Long;
  if (text == "DOUBLE") return ElementType::Double;
  return std::nullopt;
}

std::expected<Element, std::string> read_element(const pugi::xml_node& node, bool received) {
  Element element;
  element.tag = node.attribute("TAG").value();
  if (element.tag.empty()) return std::unexpected("an ELEMENT has no TAG");
  const auto wrong = [&](const char* attribute, const char* expected) {
    return std::unexpected("element " + element.tag + ": " + attribute + " is \"" +
                           node.attribute(attribute).value() + "\", expected " + expected);
  };
  if (!is_name(element.tag)) return wrong("TAG", "a name of letters and digits");

  const std::optional<ElementType> type = to_type(node.attribute("TYPE").value());
  if (!type) return wrong("TYPE", "BOOL, STRING, LONG or DOUBLE");
  element.type = *type;

  const std::string_view index = xml::trimmed(node.attribute("INDX").value());
  if (index != "INTERNAL") {
    element.index = xml::to_number<int>(index);
    if (!element.index || *element.index < 1 || *element.index > kMaxChannels)
      return wrong("INDX", "INTERNAL or 1..64");
  }
  if (received) {
    const pugi::xml_attribute hold_on = node.attribute("HOLDON");
    const std::optional<bool> flag = hold_on ? to_flag(hold_on.value()) : std::optional{false};
    if (!flag) return wrong("HOLDON", "0 or 1");
    element.hold_on = *flag;
  }
  return element;
}

std::expected<std::vector<Element>, std::string> read_elements(const pugi::xml_node& list, bool received) {
  std::vector<Element> elements;
  for (const pugi::xml_node& node : list.child("ELEMENTS").children("ELEMENT")) {
    auto element = read_element(node, received);
    if (!element) return std::unexpected(std::string{list.name()} + " " + element.error());
    const bool repeated =
        std::ranges::any_of(elements, [&](const Element& other) { return other.tag == element->tag; });
    if (repeated)
      return std::unexpected(std::string{list.name()} + " element " + element->tag + " is listed twice");
    elements.push_back(std::move(*element));
  }
  return elements;
}

const Element* find(const std::vector<Element>& elements, std::string_view tag) {
  const auto found = std::ranges::find(elements, tag, &Element::tag);
  return found == elements.end() ? nullptr : &*found;
}

constexpr std::array<std::string_view, 6> kOfAxes{".A1", ".A2", ".A3", ".A4", ".A5", ".A6"};
constexpr std::array<std::string_view, 6> kOfPose{".X", ".Y", ".Z", ".A", ".B", ".C"};

/// Names of the elements that have all these components, all DOUBLE.
std::vector<std::string> corrections_of(const std::vector<Element>& receive,
                                        const std::array<std::string_view, 6>& components) {
  std::vector<std::string> names;
  for (const Element& element : receive) {
    if (!element.tag.ends_with(components[0])) continue;
    const std::string name = element.tag.substr(0, element.tag.size() - components[0].size());
    const bool complete = std::ranges::all_of(components, [&](std::string_view component) {
      const Element* found = find(receive, name + std::string{component});
      return found && found->type == ElementType::Double;
    });
    if (complete) names.push_back(name);
  }
  return names;
}

}  // namespace

bool EthernetConfig::sends(std::string_view keyword) const {
  return find(send, "DEF_" + std::string{keyword}) != nullptr;
}

std::expected<EthernetConfig, std::string> parse_ethernet_config(std::string_view xml) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(xml.data(), xml.size());
  if (!parsed) {
    return std::unexpected("not an XML document: " + std::string{parsed.description()} + " at byte " +
                           std::to_string(parsed.offset));
  }
  const pugi::xml_node root = document.child("ROOT");
  const pugi::xml_node settings = root.child("CONFIG");
  if (!settings) return std::unexpected("no ROOT/CONFIG: this is not an RSI ethernet configuration");

  EthernetConfig config;
  config.address = xml::trimmed(settings.child_value("IP_NUMBER"));
  if (config.address.empty())
    return std::unexpected("CONFIG/IP_NUMBER is missing: it must be the PC's address");
  const auto port = xml::to_number<std::uint16_t>(settings.child_value("PORT"));
  if (!port || *port == 0) {
    return std::unexpected("CONFIG/PORT is \"" + std::string{settings.child_value("PORT")} +
                           "\", expected 1..65535");
  }
  config.port = *port;
  config.sentype = xml::trimmed(settings.child_value("SENTYPE"));
  if (!is_plain(config.sentype)) {
    return std::unexpected("CONFIG/SENTYPE is \"" + config.sentype + "\", expected a plain name");
  }
  if (const pugi::xml_node only_send = settings.child("ONLYSEND")) {
    const std::optional<bool> flag = to_flag(only_send.child_value());
    if (!flag) {
      return std::unexpected("CONFIG/ONLYSEND is \"" + std::string{only_send.child_value()} +
                             "\", expected TRUE or FALSE");
    }
    config.only_send = *flag;
  }

  auto send = read_elements(root.child("SEND"), false);
  if (!send) return std::unexpected(send.error());
  config.send = std::move(*send);
  auto receive = read_elements(root.child("RECEIVE"), true);
  if (!receive) return std::unexpected(receive.error());
  config.receive = std::move(*receive);

  const std::vector<std::string> corrections = corrections_of(config.receive, kOfAxes);
  if (!corrections.empty()) config.axis_correction = corrections.front();
  const auto stop = std::ranges::find_if(config.receive, [](const Element& element) {
    return element.type == ElementType::Bool && equal_ignoring_case(element.tag, "Stop");
  });
  if (stop != config.receive.end()) config.stop = stop->tag;
  const Element* gain = find(config.receive, kGainTag);
  config.gain = gain != nullptr && gain->type == ElementType::Long;
  return config;
}

std::vector<Message> lint(const EthernetConfig& config) {
  std::vector<Message> found;
  if (config.only_send) found.push_back(message<LintKind::OnlySend>());
  const std::vector<std::string> corrections = corrections_of(config.receive, kOfAxes);
  if (corrections.empty()) {
    found.push_back(message<LintKind::NoCorrection>());
  } else if (corrections.size() > 1) {
    found.push_back(message<LintKind::SeveralCorrections>(corrections.front()));
  }
  const std::vector<std::string> of_pose = corrections_of(config.receive, kOfPose);
  for (const std::string& name : of_pose) found.push_back(message<LintKind::Cartesian>(name));
  for (const Element& element : config.receive) {
    const bool is_of_pose = std::ranges::any_of(
        of_pose, [&](const std::string& name) { return element.tag.starts_with(name + "."); });
    if (is_of_pose) continue;
    const bool corrects = config.axis_correction && element.tag.starts_with(*config.axis_correction + ".A");
    if (corrects && !element.hold_on) found.push_back(message<LintKind::HoldOn>(element.tag));
    const bool is_stop_or_gain = element.tag == config.stop || (config.gain && element.tag == kGainTag);
    if (!corrects && !is_stop_or_gain && !element.tag.starts_with("DEF_"))
      found.push_back(message<LintKind::NeverSent>(element.tag));
  }
  if (!config.stop) found.push_back(message<LintKind::StopElement>());
  if (config.sends("Tech.T1") || find(config.receive, "DEF_Tech.T1"))
    found.push_back(message<LintKind::Generator>());
  if (!config.sends("ASPos")) found.push_back(message<LintKind::Aspos>());
  if (!config.sends("AIPos")) found.push_back(message<LintKind::Aipos>());
  if (!config.sends("RIst")) found.push_back(message<LintKind::Rist>());
  if (!config.sends("Delay")) found.push_back(message<LintKind::Delay>());
  return found;
}

}  // namespace truepose::rsi
