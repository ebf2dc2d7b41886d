#include "tools/sim/reply_names.hpp"

#include "proto/xml/scanner.hpp"

namespace truepose::sim {

ReplyNames::ReplyNames(const rsi::EthernetConfig& ethernet) : elements_{"IPOC"}, names_{"IPOC"} {
  constexpr std::string_view kBuiltIn = "DEF_";
  constexpr int kTechParameters = 10;
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
