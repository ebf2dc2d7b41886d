#include "tools/sim/rsi_datagrams.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "proto/xml/scanner.hpp"

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
  std::optional<Source> text;

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

  static Source input_of(const rsi::Element& sent) {
    if (sent.tag == "Tp.Ask") return Source::Ask;
    if (sent.tag == "Tp.Pro") return Source::Program;
    return zero_of(sent.type);
  }

  static Source zero_of(rsi::ElementType type) {
    if (type == rsi::ElementType::Double) return Source::ZeroNumber;
    return type == rsi::ElementType::String ? Source::Nothing : Source::ZeroInteger;
  }
};

std::vector<RobotDatagram::Element> RobotDatagram::elements_of(const rsi::EthernetConfig& ethernet) {
  std::vector<Element> elements;
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
          .attributes.push_back({std::string{tag.substr(dot + 1)}, Element::input_of(sent), 0});
    } else {
      named(tag).text = Element::zero_of(sent.type);
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
  pieces_.push_back({">", *element.text});
  pieces_.push_back({"</" + element.name + ">"});
}

std::string_view RobotDatagram::write(const RobotValues& values) {
  text_.clear();
  for (const Piece& piece : pieces_) append(piece, values);
  return text_;
}

void RobotDatagram::append(const Piece& piece, const RobotValues& values) {
  text_ += piece.text;
  switch (piece.source) {
    case Source::Nothing:
      return;
    case Source::ZeroNumber:
      return append_number(0);
    case Source::ZeroInteger:
      text_ += '0';
      return;
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
    case Source::Ask:
      text_ += std::to_string(values.program.ask.value_or(0));
      return;
    case Source::Program:
      text_ += std::to_string(values.program.state.value_or(0));
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

ReplyNames::ReplyNames(const rsi::EthernetConfig& ethernet) : elements_{"IPOC"}, names_{"IPOC"} {
  for (const rsi::Element& element : ethernet.receive) {
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

std::vector<std::string> ReplyNames::new_strangers(std::string_view reply) {
  std::vector<std::string> strangers;
  const auto tell = [&](std::string name) {
    if (told_.insert(name).second) strangers.push_back(std::move(name));
  };
  xml::Scanner scanner{reply};
  for (auto event = scanner.next(); event != xml::Scanner::Event::End; event = scanner.next()) {
    if (event == xml::Scanner::Event::Malformed) return strangers;
    if (event != xml::Scanner::Event::Open || scanner.depth() != 2) continue;
    const std::string element{scanner.name()};
    if (!elements_.contains(element)) {
      tell(element);
      continue;
    }
    for (const xml::Attribute& attribute : scanner.attributes()) {
      std::string name = element + "." + std::string{attribute.name};
      if (!names_.contains(name)) tell(std::move(name));
    }
  }
  return strangers;
}

}  // namespace truepose::sim
