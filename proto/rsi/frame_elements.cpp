#include "proto/rsi/frame_elements.hpp"

#include <algorithm>
#include <array>

#include "proto/xml/scanner.hpp"

namespace truepose::rsi {

namespace {

constexpr std::string_view kBuiltInTag = "DEF_", kStampElement = "IPOC";

int decimals_of(std::string_view number) {
  const std::size_t point = number.find('.');
  return point == std::string_view::npos ? 0 : static_cast<int>(number.size() - point - 1);
}

/// Whether a tag of the SEND list brings this name into the frame. DEF_RIst stands for all attributes of
/// RIst, and DEF_Tech.C1 for C11 to C110 of Tech.
bool brings(const Element& element, std::string_view name) {
  std::string_view tag = element.tag;
  if (!tag.starts_with(kBuiltInTag)) return tag == name;
  tag.remove_prefix(kBuiltInTag.size());
  if (tag.contains('.')) return name.starts_with(tag);
  return name == tag || (name.starts_with(tag) && name.substr(tag.size()).starts_with('.'));
}

}  // namespace

std::expected<FrameElements, FrameError> frame_elements(std::string_view frame) {
  FrameElements elements;
  xml::Scanner scanner{frame};
  for (auto event = scanner.next(); event != xml::Scanner::Event::End; event = scanner.next()) {
    if (event == xml::Scanner::Event::Malformed)
      return std::unexpected(FrameError{.offset = scanner.offset()});
    if (event != xml::Scanner::Event::Open || scanner.depth() != 2) continue;
    const std::string element{scanner.name()};
    if (scanner.attributes().empty()) elements.names.push_back(element);
    for (const xml::Attribute& attribute : scanner.attributes()) {
      elements.names.push_back(element + "." + std::string{attribute.name});
      elements.decimals = std::max(elements.decimals, decimals_of(xml::trimmed(attribute.value)));
    }
  }
  return elements;
}

NameDifference compare_names(const FrameElements& found, const EthernetConfig& ethernet) {
  NameDifference difference;
  const auto is_sent = [&](std::string_view name) {
    return std::ranges::any_of(ethernet.send, [&](const Element& e) { return brings(e, name); });
  };
  for (const std::string& name : found.names) {
    if (name == kStampElement || is_sent(name)) continue;
    // An element of which nothing is known is named once, not by each of its attributes.
    const std::string element = name.substr(0, name.find('.'));
    const bool known_in_part = std::ranges::any_of(found.names, [&](const std::string& other) {
      return other.starts_with(element + ".") && is_sent(other);
    });
    const std::string& unknown = known_in_part ? name : element;
    if (std::ranges::count(difference.unknown, unknown) == 0) difference.unknown.push_back(unknown);
  }
  for (const Element& element : ethernet.send) {
    if (std::ranges::none_of(found.names, [&](const std::string& name) { return brings(element, name); }))
      difference.missing.push_back(element.tag);
  }
  return difference;
}

}  // namespace truepose::rsi
