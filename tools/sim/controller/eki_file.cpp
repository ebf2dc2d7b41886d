#include "tools/sim/controller/eki_file.hpp"

#include <pugixml.hpp>

namespace truepose::sim {
namespace {

std::optional<int> number(const pugi::xml_attribute& attribute) {
  return attribute ? std::optional{attribute.as_int()} : std::nullopt;
}

std::expected<std::optional<EkiFile::Type>, std::string> type_of(const pugi::xml_node& element) {
  const std::string_view type = element.attribute("Type").value();
  if (type == "INT") return EkiFile::Type::Int;
  if (type == "REAL") return EkiFile::Type::Real;
  if (type == "BOOL") return EkiFile::Type::Bool;
  if (type == "STRING") return EkiFile::Type::String;
  if (type == "FRAME") return EkiFile::Type::Frame;
  if (type.empty() && element.attribute("Set_Flag")) return std::nullopt;
  return std::unexpected(std::string{element.attribute("Tag").value()} + ": Type \"" + std::string{type} +
                         "\" is not simulated: INT, REAL, BOOL, STRING, FRAME");
}

/// The PC is the client of a TCP channel, and documents are XML.
std::optional<std::string> not_simulated(const pugi::xml_node& root) {
  const pugi::xml_node configuration = root.child("CONFIGURATION");
  if (std::string_view{configuration.child("EXTERNAL").child_value("TYPE")} != "Client")
    return "EXTERNAL/TYPE: only Client is simulated, where the robot listens";
  const pugi::xml_node internal = configuration.child("INTERNAL");
  const std::string_view protocol = internal.child_value("PROTOCOL");
  if (!protocol.empty() && protocol != "TCP")
    return "INTERNAL/PROTOCOL: " + std::string{protocol} + " is not simulated, only TCP";
  if (std::string_view{internal.child("BUFFERING").attribute("Mode").as_string("FIFO")} != "FIFO")
    return "INTERNAL/BUFFERING: only FIFO is simulated";
  for (const char* part : {"RECEIVE", "SEND"}) {
    if (root.child(part).child("RAW")) return std::string{part} + ": RAW is not simulated, only XML";
  }
  return std::nullopt;
}

}  // namespace

std::expected<EkiFile, std::string> parse_eki_file(std::string_view xml) {
  pugi::xml_document document;
  if (const auto parsed = document.load_buffer(xml.data(), xml.size()); !parsed)
    return std::unexpected("not an XML document: " + std::string{parsed.description()});
  const pugi::xml_node root = document.child("ETHERNETKRL");
  if (!root) return std::unexpected("its root is not ETHERNETKRL");
  if (auto what = not_simulated(root)) return std::unexpected(*std::move(what));
  const pugi::xml_node internal = root.child("CONFIGURATION").child("INTERNAL");
  EkiFile file;
  file.of_submit = std::string_view{internal.child_value("ENVIRONMENT")} == "Submit";
  file.buffered = internal.child("BUFFERING").attribute("Limit").as_uint(16);
  file.alive_flag = number(internal.child("ALIVE").attribute("Set_Flag"));
  file.port = static_cast<std::uint16_t>(internal.child("PORT").text().as_uint());
  for (const pugi::xml_node& element : root.child("RECEIVE").child("XML").children("ELEMENT")) {
    const auto type = type_of(element);
    if (!type) return std::unexpected(type.error());
    file.receive.push_back({element.attribute("Tag").value(), *type, number(element.attribute("Set_Flag"))});
  }
  for (const pugi::xml_node& element : root.child("SEND").child("XML").children("ELEMENT"))
    file.send.emplace_back(element.attribute("Tag").value());
  return file;
}

}  // namespace truepose::sim
