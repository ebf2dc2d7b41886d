#include "proto/rsi/context.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <pugixml.hpp>
#include <sstream>

#include "core/formatted.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::rsi {
namespace {

/// A parameter's ordinals, which differ between the formats. Those of a file that cannot be changed while it
/// runs are counted apart.
constexpr int kAny = -1;
struct ParameterType {
  std::string_view name;
  int in_rsi_xml, in_rsix;  ///< kAny where it is not published
  bool at_runtime = true;
};

struct ObjectType {
  std::string_view in_rsi_xml, in_rsix;  ///< names
  int id;
  std::vector<ParameterType> parameters;
};

std::vector<ParameterType> of_axes(std::string_view name, int first_in_rsi_xml, int first_in_rsix) {
  static constexpr std::array<std::string_view, 18> kNames{
      "LowerLimA1", "LowerLimA2", "LowerLimA3", "LowerLimA4", "LowerLimA5", "LowerLimA6",
      "UpperLimA1", "UpperLimA2", "UpperLimA3", "UpperLimA4", "UpperLimA5", "UpperLimA6",
      "MaxA1",      "MaxA2",      "MaxA3",      "MaxA4",      "MaxA5",      "MaxA6"};
  std::vector<ParameterType> parameters;
  for (const std::string_view one : kNames) {
    if (!one.starts_with(name)) continue;
    parameters.push_back({one, first_in_rsi_xml++, first_in_rsix++});
  }
  return parameters;
}

std::vector<ParameterType> together(std::vector<ParameterType> a, const std::vector<ParameterType>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// As the contexts of public drivers that ran on controllers have them (kuka-external-control-sdk, RSI 4.1;
/// kuka_experimental, RSI 4.0; kuka_rsi_driver and rsi-pi, RSI 3).
const std::vector<ObjectType>& object_types() {
  static const std::vector<ObjectType> types{
      {"ETHERNET",
       "Ethernet",
       64,
       {{"ConfigFile", 1, 0, false}, {"Timeout", 1, 0}, {"Flag", 4, 3}, {"Precision", 8, 7}}},
      {"AXISCORR", "AxisCorr", 33, together(of_axes("LowerLim", 1, 0), of_axes("UpperLim", 13, 6))},
      {"AXISCORRMON", "AxisCorrMon", 82, of_axes("Max", 1, 0)},
      {"POSCORR",
       "PosCorr",
       27,
       {{"LowerLimX", kAny, 0},
        {"LowerLimY", kAny, 1},
        {"LowerLimZ", kAny, 2},
        {"UpperLimX", kAny, 3},
        {"UpperLimY", kAny, 4},
        {"UpperLimZ", kAny, 5},
        {"MaxRotAngle", kAny, 6},
        {"RefCorrSys", kAny, 0, false}}},
      {"POSCORRMON", "PosCorrMon", 81, {{"MaxTrans", kAny, 0}, {"MaxRotAngle", kAny, 1}}},
      {"STOP", "Stop", 18, {{"Mode", 1, 0}}},
      {"STATUS", "Status", 62, {{"Type", 1, 0}}},
      {"OV_PRO", "Ov_Pro", 63, {}},
      {"SEN_PINT", "Sen_PInt", 57, {{"Index", 1, 0}}},
      {"MAP2SEN_PINT", "Map2Sen_PInt", 16, {{"Index", 1, 0}}},
  };
  return types;
}

const ObjectType* type_of_id(int id) {
  const auto found = std::ranges::find(object_types(), id, &ObjectType::id);
  return found == object_types().end() ? nullptr : &*found;
}

const ObjectType& type_named(std::string_view name) {
  return *std::ranges::find(object_types(), name, &ObjectType::in_rsi_xml);
}

/// What the formats call the same things.
struct Words {
  ContextFormat format;
  const char *object, *type_id, *object_id, *output_object, *parameter_id;
  int first;  ///< ordinal of the first input, output and parameter
};
constexpr Words kRsiXml{ContextFormat::RsiXml, "RSIObject", "ObjTypeID", "ObjID", "OutObjID", "ParamID", 1};
constexpr Words kRsix{ContextFormat::Rsix, "RsiObject", "ObjTypeId", "ObjId", "OutObjId", "ParamId", 0};

std::expected<int, std::string> ordinal(const pugi::xml_node& node, const char* attribute, int first,
                                        const std::string& object) {
  const auto number = xml::to_number<int>(node.attribute(attribute).value());
  if (number && *number >= first) return *number - first + 1;
  return std::unexpected(object + ": " + attribute + " is \"" + node.attribute(attribute).value() +
                         "\", expected " + std::to_string(first) + " or more");
}

std::expected<void, std::string> read_inputs(const pugi::xml_node& node, const Words& words,
                                             ContextObject& object) {
  for (const pugi::xml_node& input : node.child("Inputs").children("Input")) {
    const auto at = ordinal(input, "InIdx", words.first, object.id);
    if (!at) return std::unexpected(at.error());
    const auto from = ordinal(input, "OutIdx", words.first, object.id);
    if (!from) return std::unexpected(from.error());
    if (!object.inputs.emplace(*at, ContextOutput{input.attribute(words.output_object).value(), *from})
             .second)
      return std::unexpected(object.id + ": input " + std::to_string(*at) + " is wired twice");
  }
  return {};
}

std::expected<void, std::string> read_parameters(const pugi::xml_node& node, const Words& words,
                                                 const ObjectType& type, ContextObject& object) {
  for (const pugi::xml_node& parameter : node.child("Parameters").children("Parameter")) {
    const std::string_view name = parameter.attribute("Name").value();
    const auto known = std::ranges::find(type.parameters, name, &ParameterType::name);
    if (known == type.parameters.end()) continue;
    const int expected = words.format == ContextFormat::RsiXml ? known->in_rsi_xml : known->in_rsix;
    const auto number = xml::to_number<int>(parameter.attribute(words.parameter_id).value());
    if (expected != kAny && number != expected) {
      return std::unexpected(object.id + ": " + std::string{name} + " has " + words.parameter_id + " \"" +
                             parameter.attribute(words.parameter_id).value() +
                             "\", which is another parameter: " + "it is " + std::to_string(expected) +
                             " in this format");
    }
    object.values.emplace(name, parameter.attribute("ParamValue").value());
  }
  return {};
}

std::expected<ContextObject, std::string> read_object(const pugi::xml_node& node, const Words& words) {
  ContextObject object;
  object.id = node.attribute(words.object_id).value();
  if (object.id.empty()) return std::unexpected("an object has no " + std::string{words.object_id});
  const auto id = xml::to_number<int>(node.attribute(words.type_id).value());
  const ObjectType* const type = id ? type_of_id(*id) : nullptr;
  const std::string_view name = node.attribute("ObjType").value();
  if (type != nullptr && name != (words.format == ContextFormat::RsiXml ? type->in_rsi_xml : type->in_rsix)) {
    return std::unexpected(object.id + ": " + words.type_id + " " + std::to_string(*id) + " is " +
                           std::string{type->in_rsi_xml} + ", but ObjType says " + std::string{name});
  }
  object.type = type != nullptr ? type->in_rsi_xml : name;
  if (auto read = read_inputs(node, words, object); !read) return std::unexpected(read.error());
  if (type == nullptr) return object;
  if (auto read = read_parameters(node, words, *type, object); !read) return std::unexpected(read.error());
  return object;
}

/// The element that holds the objects of a new document.
pugi::xml_node objects_of(pugi::xml_document& document, ContextFormat format) {
  constexpr const char* kInstance = "http://www.w3.org/2001/XMLSchema-instance";
  if (format == ContextFormat::RsiXml) {
    pugi::xml_node root = document.append_child("RSIObjects");
    root.append_attribute("xsi:noNamespaceSchemaLocation") =
        "/Roboter/Config/System/Common/Schemes/RSIContext.xsd";
    root.append_attribute("xmlns:xsi") = kInstance;
    return root;
  }
  pugi::xml_node root = document.append_child("RsiContext");
  if (format == ContextFormat::Rsix40) {
    root.append_attribute("xmlns:xsi") = kInstance;
    root.append_attribute("xmlns:xsd") = "http://www.w3.org/2001/XMLSchema";
    root.append_attribute("Version") = "0.1.0";
    return root.append_child("RsiObjects");
  }
  root.append_attribute("xsi:schemaLocation") = "RsiContext RsiContext.xsd";
  root.append_attribute("SchemaVersion") = "2.0.0";
  root.append_attribute("xmlns:xsi") = kInstance;
  root.append_attribute("xmlns") = "RsiContext";
  pugi::xml_node objects = root.append_child("RsiObjects");
  objects.append_attribute("xmlns") = "RsiDriver";
  return objects;
}

/// Every wire comes from an object that is there.
std::optional<std::string> loose_wire(const Context& context) {
  for (const ContextObject& object : context.objects) {
    for (const auto& [input, from] : object.inputs) {
      if (context.with_id(from.object) != nullptr) continue;
      return object.id + ": input " + std::to_string(input) + " is wired to " + from.object +
             ", which is not there";
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> ContextObject::number(std::string_view parameter) const {
  const auto found = values.find(parameter);
  return found == values.end() ? std::nullopt : xml::to_number<double>(found->second);
}

const ContextObject* Context::of_type(std::string_view type) const {
  const auto found = std::ranges::find(objects, type, &ContextObject::type);
  return found == objects.end() ? nullptr : &*found;
}

const ContextObject* Context::with_id(std::string_view id) const {
  const auto found = std::ranges::find(objects, id, &ContextObject::id);
  return found == objects.end() ? nullptr : &*found;
}

std::expected<Context, std::string> parse_context(std::string_view xml) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(xml.data(), xml.size());
  if (!parsed) {
    return std::unexpected("not an XML document: " + std::string{parsed.description()} + " at byte " +
                           std::to_string(parsed.offset));
  }
  const pugi::xml_node old_root = document.child("RSIObjects");
  const pugi::xml_node root = old_root ? old_root : document.child("RsiContext").child("RsiObjects");
  if (!root)
    return std::unexpected("neither RSIObjects (.rsi.xml) nor RsiContext (.rsix): this is no RSI context");
  const Words& words = old_root ? kRsiXml : kRsix;
  Context context;
  for (const pugi::xml_node& node : root.children(words.object)) {
    auto object = read_object(node, words);
    if (!object) return std::unexpected(object.error());
    if (context.with_id(object->id) != nullptr) return std::unexpected("there are two objects " + object->id);
    context.objects.push_back(*std::move(object));
  }
  if (auto wrong = loose_wire(context)) return std::unexpected(*std::move(wrong));
  return context;
}

std::string context_xml(const Context& context, ContextFormat format) {
  const bool old = format == ContextFormat::RsiXml;
  const Words& words = old ? kRsiXml : kRsix;
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "utf-8";
  pugi::xml_node root = objects_of(document, format);
  const auto ordinal_of = [&](int number) { return number - 1 + words.first; };
  for (const ContextObject& object : context.objects) {
    const ObjectType& type = type_named(object.type);
    pugi::xml_node node = root.append_child(words.object);
    node.append_attribute(words.type_id) = type.id;
    node.append_attribute("ObjType") = std::string{old ? type.in_rsi_xml : type.in_rsix}.c_str();
    node.append_attribute(words.object_id) = object.id.c_str();
    pugi::xml_node inputs;
    for (const auto& [number, from] : object.inputs) {
      if (!inputs) inputs = node.append_child("Inputs");
      pugi::xml_node input = inputs.append_child("Input");
      input.append_attribute("InIdx") = ordinal_of(number);
      input.append_attribute(words.output_object) = from.object.c_str();
      input.append_attribute("OutIdx") = ordinal_of(from.number);
    }
    pugi::xml_node parameters;
    for (const ParameterType& parameter : type.parameters) {
      const auto value = object.values.find(parameter.name);
      if (value == object.values.end()) continue;
      if (!parameters) parameters = node.append_child("Parameters");
      pugi::xml_node one = parameters.append_child("Parameter");
      if (!parameter.at_runtime) one.append_attribute("IsRuntime") = "false";
      one.append_attribute("Name") = std::string{parameter.name}.c_str();
      one.append_attribute(words.parameter_id) = old ? parameter.in_rsi_xml : parameter.in_rsix;
      one.append_attribute("ParamValue") = value->second.c_str();
    }
  }
  std::ostringstream text;
  document.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  return text.str();
}

Context truepose_context(const ContextDemands& demands) {
  // Above the limits of AXISCORR, which clamps, since reaching it stops RSI.
  const double ceiling_deg = std::ceil(demands.max_total_deg + 1);
  ContextObject ethernet{.type = "ETHERNET", .id = "ETHERNET1"};
  ethernet.inputs = {{1, {"SEN_PINT1", 1}},
                     {2, {"STATUS1", 1}},
                     {3, {"STATUS2", 1}},
                     {4, {"OV_PRO1", 1}},
                     {5, {"SEN_PINT2", 1}}};
  ethernet.values = {{"ConfigFile", demands.ethernet_file},
                     {"Timeout", std::to_string(demands.timeout_cycles)},
                     {"Flag", "-1"},
                     {"Precision", "4"}};
  ContextObject correction{.type = "AXISCORR", .id = "AXISCORR1"};
  ContextObject monitor{.type = "AXISCORRMON", .id = "AXISCORRMON1"};
  for (int axis = 1; axis <= 6; ++axis) {
    correction.inputs.emplace(axis, ContextOutput{"ETHERNET1", axis});
    correction.values["LowerLimA" + std::to_string(axis)] = formatted("%g", -demands.max_total_deg);
    correction.values["UpperLimA" + std::to_string(axis)] = formatted("%g", demands.max_total_deg);
    monitor.values["MaxA" + std::to_string(axis)] = formatted("%g", ceiling_deg);
  }
  return {{{.type = "SEN_PINT", .id = "SEN_PINT1", .values = {{"Index", "1"}}},
           {.type = "STATUS", .id = "STATUS1", .values = {{"Type", "2"}}},
           {.type = "STATUS", .id = "STATUS2", .values = {{"Type", "1"}}},
           {.type = "OV_PRO", .id = "OV_PRO1"},
           {.type = "SEN_PINT", .id = "SEN_PINT2", .values = {{"Index", "3"}}},
           ethernet,
           correction,
           monitor,
           {.type = "STOP", .id = "STOP1", .inputs = {{1, {"ETHERNET1", 7}}}, .values = {{"Mode", "4"}}},
           {.type = "MAP2SEN_PINT",
            .id = "MAP2SEN_PINT1",
            .inputs = {{1, {"ETHERNET1", 8}}},
            .values = {{"Index", "2"}}}}};
}

}  // namespace truepose::rsi
