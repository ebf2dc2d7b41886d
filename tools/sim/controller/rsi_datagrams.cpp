#include "tools/sim/controller/rsi_datagrams.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <pugixml.hpp>

namespace truepose::sim {

namespace {

using Axes = rsi::Axes;

constexpr std::string_view kBuiltIn = "DEF_";
constexpr std::string_view kTech = "DEF_Tech.";
constexpr std::array<std::string_view, 9> kKeywords{"RIst",  "RSol",  "AIPos", "ASPos", "EIPos",
                                                    "ESPos", "MACur", "MECur", "Delay"};
constexpr int kTechGenerators = 6;
constexpr int kTechParameters = 10;

Axes to_array(const rsi::CartesianPose& p) { return {p.x_mm, p.y_mm, p.z_mm, p.a_deg, p.b_deg, p.c_deg}; }

std::vector<std::string> numbered(char letter) {
  std::vector<std::string> names;
  for (int i = 1; i <= 6; ++i) names.push_back(letter + std::to_string(i));
  return names;
}

/// "C1" to "C6" and "T1" to "T6".
bool is_tech_generator(std::string_view name) {
  return name.size() == 2 && (name[0] == 'C' || name[0] == 'T') && name[1] >= '1' &&
         name[1] < '1' + kTechGenerators;
}

}  // namespace

/// An element of the datagram: its attributes, or its text.
struct RobotDatagram::Element {
  struct Attribute {
    std::string name;
    Source source;
    std::size_t index;
  };
  std::string name;
  std::vector<Attribute> attributes;
  std::optional<Attribute> text;

  void add(const std::vector<std::string>& names, Source source) {
    for (std::size_t i = 0; i < names.size(); ++i) attributes.push_back({names[i], source, i});
  }

  void add_built_in(std::string_view keyword) {
    if (keyword == "RIst") return add({"X", "Y", "Z", "A", "B", "C"}, Source::RIst);
    if (keyword == "RSol") return add({"X", "Y", "Z", "A", "B", "C"}, Source::RSol);
    if (keyword == "AIPos") return add(numbered('A'), Source::AIPos);
    if (keyword == "ASPos") return add(numbered('A'), Source::ASPos);
    if (keyword == "MACur") return add(numbered('A'), Source::ZeroNumber);
    if (keyword == "Delay") return add({"D"}, Source::Delay);
    add(numbered('E'), Source::ZeroNumber);
  }

  void add_tech(std::string_view generator) {
    for (int i = 1; i <= kTechParameters; ++i)
      attributes.push_back({std::string{generator} + std::to_string(i), Source::ZeroNumber, 0});
  }

  static Source input_of(rsi::ElementType type) {
    if (type == rsi::ElementType::Double) return Source::Input;
    return type == rsi::ElementType::String ? Source::Nothing : Source::InputInteger;
  }
};

std::vector<RobotDatagram::Element> RobotDatagram::elements_of(const rsi::EthernetConfig& ethernet) {
  std::vector<Element> elements;
  const auto channel = [](const rsi::Element& sent) {
    return static_cast<std::size_t>(sent.index.value_or(0));
  };
  // All that has one name is one element, where the list first names it.
  const auto named = [&elements](std::string_view name) -> Element& {
    const auto found = std::ranges::find(elements, name, &Element::name);
    if (found != elements.end()) return *found;
    return elements.emplace_back(Element{std::string{name}, {}, std::nullopt});
  };
  for (const rsi::Element& sent : ethernet.send) {
    const std::string_view tag = sent.tag;
    if (tag.starts_with(kTech)) {
      named("Tech").add_tech(tag.substr(kTech.size()));
    } else if (tag.starts_with(kBuiltIn)) {
      const std::string_view keyword = tag.substr(kBuiltIn.size());
      named(keyword).add_built_in(keyword);
    } else if (const std::size_t dot = tag.find('.'); dot != std::string_view::npos) {
      named(tag.substr(0, dot))
          .attributes.push_back(
              {std::string{tag.substr(dot + 1)}, Element::input_of(sent.type), channel(sent)});
    } else {
      named(tag).text = {{}, Element::input_of(sent.type), channel(sent)};
    }
  }
  return elements;
}

RobotDatagram::RobotDatagram(const rsi::EthernetConfig& ethernet, int decimals) : decimals_{decimals} {
  pieces_.push_back({"<Rob Type=\"KUKA\">"});
  for (const Element& element : elements_of(ethernet)) add(element);
  pieces_.push_back({"<IPOC>", Source::Ipoc});
  pieces_.push_back({"</IPOC></Rob>"});
}

void RobotDatagram::add(const Element& element) {
  pieces_.push_back({"<" + element.name});
  for (const Element::Attribute& attribute : element.attributes) {
    pieces_.push_back({" " + attribute.name + "=\"", attribute.source, attribute.index});
    pieces_.push_back({"\""});
  }
  if (!element.text) return pieces_.push_back({"/>"});
  pieces_.push_back({">", element.text->source, element.text->index});
  pieces_.push_back({"</" + element.name + ">"});
}

std::string_view RobotDatagram::write(const RobotValues& values) {
  text_.clear();
  for (const Piece& piece : pieces_) append(piece, values);
  return text_;
}

void RobotDatagram::append(const Piece& piece, const RobotValues& values) {
  text_ += piece.text;
  const auto input = [&] {
    const auto value = values.inputs.find(static_cast<int>(piece.index));
    return value == values.inputs.end() ? 0 : value->second;
  };
  switch (piece.source) {
    case Source::Nothing:
      return;
    case Source::ZeroNumber:
      return append_number(0);
    case Source::RIst:
      return append_number(to_array(values.rist)[piece.index]);
    case Source::RSol:
      return append_number(to_array(values.rsol)[piece.index]);
    case Source::AIPos:
      return append_number(values.aipos_deg[piece.index]);
    case Source::ASPos:
      return append_number(values.aspos_deg[piece.index]);
    case Source::Delay:
      text_ += std::to_string(values.delay);
      return;
    case Source::Input:
      return append_number(input());
    case Source::InputInteger:
      text_ += std::to_string(std::llround(input()));
      return;
    case Source::Ipoc:
      text_ += std::to_string(values.ipoc);
      return;
  }
}

void RobotDatagram::append_number(double value) {
  std::array<char, 64> digits;
  const auto end =
      std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed, decimals_);
  text_.append(digits.data(), end.ptr);
}

std::optional<std::string> unsendable(const rsi::EthernetConfig& ethernet) {
  for (const rsi::Element& element : ethernet.send) {
    const std::string_view tag = element.tag;
    const std::string name = "SEND element " + element.tag;
    if (tag == "DEF_Tech.T1")
      return name + ": RSI needs technology generator 1 itself (RSIBad); leave it out";
    if (tag.starts_with(kTech)) {
      if (!is_tech_generator(tag.substr(kTech.size())))
        return name + " is no built-in: Tech has C1..C6 and T2..T6";
    } else if (tag.starts_with(kBuiltIn)) {
      if (std::ranges::count(kKeywords, tag.substr(kBuiltIn.size())) > 0) continue;
      std::string known;
      for (const std::string_view keyword : kKeywords) known.append("DEF_").append(keyword).append(", ");
      return name + " is no built-in: a controller knows " + known + "DEF_Tech.C1..C6 and DEF_Tech.T2..T6";
    } else if (!element.index) {
      return name + " is INTERNAL, but no built-in (their tags begin with DEF_): give it an INDX of 1..64";
    }
  }
  return std::nullopt;
}

namespace {

/// What a RECEIVE element's value is in a reply; nothing where it is not there.
std::optional<std::string> text_of(const pugi::xml_node& reply, const std::string& tag) {
  const std::size_t dot = tag.find('.');
  const pugi::xml_node element = reply.child(tag.substr(0, dot).c_str());
  if (dot == std::string::npos)
    return element ? std::optional<std::string>{element.child_value()} : std::nullopt;
  const pugi::xml_attribute attribute = element.attribute(tag.substr(dot + 1).c_str());
  return attribute ? std::optional<std::string>{attribute.value()} : std::nullopt;
}

std::unexpected<ReplyFault> refused(ReplyFault::Cause cause, std::string text) {
  return std::unexpected{ReplyFault{cause, std::move(text)}};
}

/// Its beginning, in printable ASCII.
std::string excerpt(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string shown{text.substr(0, kMost)};
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '.');
  return '"' + shown + '"';
}

std::optional<double> number_in(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return text.empty() || *end != '\0' || !std::isfinite(number) ? std::nullopt : std::optional{number};
}

}  // namespace

ReplyReader::ReplyReader(rsi::EthernetConfig ethernet)
    : ethernet_{std::move(ethernet)}, elements_{"IPOC"}, names_{"IPOC"} {
  for (const rsi::Element& element : ethernet_.receive) {
    std::string tag = element.tag;
    const bool built_in = tag.starts_with(kBuiltIn);
    if (built_in) tag.erase(0, kBuiltIn.size());
    elements_.insert(tag.substr(0, tag.find('.')));
    names_.insert(tag);
    // DEF_Tech.T2 stands for the attributes T21 to T210.
    for (int i = 1; built_in && tag.starts_with("Tech.") && i <= kTechParameters; ++i)
      names_.insert(tag + std::to_string(i));
  }
}

std::expected<ReplyReader::Reply, ReplyFault> ReplyReader::read(std::string_view datagram) {
  using Cause = ReplyFault::Cause;
  const std::string& sentype = ethernet_.sentype;
  pugi::xml_document document;
  const auto parsed = document.load_buffer(datagram.data(), datagram.size());
  const pugi::xml_node reply = document.child("Sen");
  if (!parsed || !reply)
    return refused(Cause::NoXml, "is no XML document Sen (it begins " + excerpt(datagram) +
                                     "). Send <Sen Type=\"" + sentype + "\">.");
  for (const pugi::xml_node& element : reply.children()) {
    const std::string name = element.name();
    if (!elements_.contains(name)) {
      tell(name);
      continue;
    }
    for (const pugi::xml_attribute& attribute : element.attributes()) tell(name + "." + attribute.name());
  }
  if (const char* const type = reply.attribute("Type").value(); type != sentype)
    return refused(Cause::Sentype, "SENTYPE is " + excerpt(type) + ", the configuration says " +
                                       excerpt(sentype) + ". Send that as Type of Sen.");
  Reply read;
  const std::string_view ipoc = reply.child_value("IPOC");
  const auto [end, fault] = std::from_chars(ipoc.data(), ipoc.data() + ipoc.size(), read.ipoc);
  if (ipoc.empty() || fault != std::errc{} || end != ipoc.data() + ipoc.size())
    return refused(Cause::NoIpoc,
                   "IPOC is " + excerpt(ipoc) + ", no whole number. Copy the IPOC of the packet.");
  for (const rsi::Element& element : ethernet_.receive) {
    const auto text = element.index ? text_of(reply, element.tag) : std::nullopt;
    if (!text || element.type == rsi::ElementType::String) continue;
    const auto number = number_in(*text);
    if (!number)
      return refused(Cause::NoNumber, element.tag + " is " + excerpt(*text) +
                                          ", no number. Send digits with a decimal point.");
    read.outputs[*element.index] = *number;
  }
  return read;
}

/// Only what the list does not have.
void ReplyReader::tell(std::string name) {
  if (!names_.contains(name) && returned_names_.insert(name).second)
    unknown_names_.push_back(std::move(name));
}

}  // namespace truepose::sim
