#include "proto/rsi/context.hpp"

#include <algorithm>
#include <boost/algorithm/string/case_conv.hpp>
#include <boost/algorithm/string/predicate.hpp>
#include <cmath>
#include <pugixml.hpp>
#include <sstream>

#include "core/formatted.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::rsi {
namespace {

/// What the formats call the same things.
struct Words {
  ContextFormat format;
  const char *object, *type_id, *object_id, *output_object, *parameter_id;
  int first;  ///< ordinal of the first input and output of most objects
};
constexpr Words kRsiXml{ContextFormat::RsiXml, "RSIObject", "ObjTypeID", "ObjID", "OutObjID", "ParamID", 1};
constexpr Words kRsix{ContextFormat::Rsix, "RsiObject", "ObjTypeId", "ObjId", "OutObjId", "ParamId", 0};

/// The ordinal of the first input and output of a kind of object; of one that is not known that of most.
int first_of(const CatalogueObject* kind, const Words& words) {
  return kind == nullptr ? words.first : kind->first;
}

/// How many inputs or outputs an object of a kind can have.
int count(const std::vector<CataloguePort>& ports) {
  int count = 0;
  for (const CataloguePort& port : ports) count += port.copies;
  return count;
}

/// Counted from 1, as they are drawn.
std::expected<int, std::string> number(const pugi::xml_node& node, const char* attribute, int first,
                                       const std::string& object) {
  const auto ordinal = xml::to_number<int>(node.attribute(attribute).value());
  if (ordinal && *ordinal >= first) return *ordinal - first + 1;
  return std::unexpected(object + ": " + attribute + " is \"" + node.attribute(attribute).value() +
                         "\", expected " + std::to_string(first) + " or more");
}

/// @param kind  of the object; null where it is not known
std::expected<void, std::string> read_inputs(const pugi::xml_node& node, const Words& words,
                                             const CatalogueObject* kind, ContextObject& object) {
  for (const pugi::xml_node& input : node.child("Inputs").children("Input")) {
    const auto at = number(input, "InIdx", first_of(kind, words), object.id);
    if (!at) return std::unexpected(at.error());
    if (kind != nullptr && *at > count(kind->inputs)) {
      return std::unexpected(object.id + ": InIdx is \"" + input.attribute("InIdx").value() + "\", but " +
                             kind->name + " has " + std::to_string(count(kind->inputs)) + " inputs");
    }
    const auto from = number(input, "OutIdx", words.first, object.id);
    if (!from) return std::unexpected(from.error());
    if (!object.inputs.emplace(*at, ContextOutput{input.attribute(words.output_object).value(), *from})
             .second)
      return std::unexpected(object.id + ": input " + std::to_string(*at) + " is wired twice");
  }
  return {};
}

std::expected<void, std::string> read_parameters(const pugi::xml_node& node, const Words& words,
                                                 const CatalogueObject& kind, ContextObject& object) {
  for (const pugi::xml_node& parameter : node.child("Parameters").children("Parameter")) {
    const std::string_view name = parameter.attribute("Name").value();
    const CatalogueParameter* const known = kind.parameter(name);
    if (known == nullptr) continue;
    if (xml::to_number<int>(parameter.attribute(words.parameter_id).value()) != known->ordinal) {
      return std::unexpected(object.id + ": " + std::string{name} + " has " + words.parameter_id + " \"" +
                             parameter.attribute(words.parameter_id).value() +
                             "\", which is another parameter: it is " + std::to_string(known->ordinal) +
                             " in this format");
    }
    const std::string_view value = parameter.attribute("ParamValue").value();
    if (!known->values.empty()) {
      const auto chosen = xml::to_number<int>(value);
      if (!chosen || *chosen < 0 || *chosen >= static_cast<int>(known->values.size())) {
        return std::unexpected(object.id + ": " + std::string{name} + " is \"" + std::string{value} +
                               "\", expected 0 to " + std::to_string(known->values.size() - 1));
      }
    }
    object.values.emplace(name, value);
  }
  return {};
}

/// The kind that a file means by number and name: RSI 3 has kinds that share a number.
///
/// @return  null where the number is that of no kind that is known; the error says which kind it is of
std::expected<const CatalogueObject*, std::string> kind_of(int id, std::string_view name,
                                                           const Words& words) {
  const CatalogueObject* other = nullptr;
  for (const CatalogueObject& kind : object_catalogue(words.format)) {
    if (kind.id != id) continue;
    if (boost::iequals(kind.name, name)) return &kind;
    if (other == nullptr) other = &kind;
  }
  if (other == nullptr) return nullptr;
  return std::unexpected(std::string{words.type_id} + " " + std::to_string(id) + " is " + other->name +
                         ", but ObjType says " + std::string{name});
}

std::expected<ContextObject, std::string> read_object(const pugi::xml_node& node, const Words& words) {
  ContextObject object;
  object.id = node.attribute(words.object_id).value();
  if (object.id.empty()) return std::unexpected("an object has no " + std::string{words.object_id});
  const std::string_view name = node.attribute("ObjType").value();
  const auto kind =
      kind_of(xml::to_number<int>(node.attribute(words.type_id).value()).value_or(-1), name, words);
  if (!kind) return std::unexpected(object.id + ": " + kind.error());
  object.type = *kind != nullptr ? (*kind)->type : boost::to_upper_copy(std::string{name});
  if (auto read = read_inputs(node, words, *kind, object); !read) return std::unexpected(read.error());
  if (*kind == nullptr) return object;
  if (auto read = read_parameters(node, words, **kind, object); !read) return std::unexpected(read.error());
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

/// Every wire comes from an object that is there, and from an output that it has.
std::optional<std::string> loose_wire(const Context& context, ContextFormat format) {
  for (const ContextObject& object : context.objects) {
    for (const auto& [input, from] : object.inputs) {
      const std::string wired = object.id + ": input " + std::to_string(input) + " is wired to ";
      const ContextObject* const source = context.with_id(from.object);
      if (source == nullptr) return wired + from.object + ", which is not there";
      const CatalogueObject* const kind = catalogued(source->type, format);
      if (kind == nullptr || from.number <= count(kind->outputs)) continue;
      return wired + "output " + std::to_string(from.number) + " of " + from.object + ", but " + kind->name +
             " has " + std::to_string(count(kind->outputs));
    }
  }
  return std::nullopt;
}

/// Outputs counted from 1 where a kind of object counts them from another number.
void count_outputs_from_one(Context& context, const Words& words) {
  for (ContextObject& object : context.objects) {
    for (auto& [input, from] : object.inputs) {
      const ContextObject* const source = context.with_id(from.object);
      const int first =
          source == nullptr ? words.first : first_of(catalogued(source->type, words.format), words);
      from.number -= first - words.first;
    }
  }
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
  count_outputs_from_one(context, words);
  if (auto wrong = loose_wire(context, words.format)) return std::unexpected(*std::move(wrong));
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
  for (const ContextObject& object : context.objects) {
    const CatalogueObject& kind = *catalogued(object.type, format);
    pugi::xml_node node = root.append_child(words.object);
    node.append_attribute(words.type_id) = kind.id;
    node.append_attribute("ObjType") = kind.name.c_str();
    node.append_attribute(words.object_id) = object.id.c_str();
    pugi::xml_node inputs;
    for (const auto& [number, from] : object.inputs) {
      if (!inputs) inputs = node.append_child("Inputs");
      const CatalogueObject& source = *catalogued(context.with_id(from.object)->type, format);
      pugi::xml_node input = inputs.append_child("Input");
      input.append_attribute("InIdx") = number - 1 + kind.first;
      input.append_attribute(words.output_object) = from.object.c_str();
      input.append_attribute("OutIdx") = from.number - 1 + source.first;
    }
    pugi::xml_node parameters;
    for (const CatalogueParameter& parameter : kind.parameters) {
      const auto value = object.values.find(parameter.name);
      if (value == object.values.end()) continue;
      if (!parameters) parameters = node.append_child("Parameters");
      pugi::xml_node one = parameters.append_child("Parameter");
      if (parameter.fixed) one.append_attribute("IsRuntime") = "false";
      one.append_attribute("Name") = parameter.name.c_str();
      one.append_attribute(words.parameter_id) = parameter.ordinal;
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
  const auto status = [](std::string_view value) {
    return std::to_string(number_of("STATUS", "Type", value));
  };
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
           {.type = "STATUS", .id = "STATUS1", .values = {{"Type", status(kProgramState)}}},
           {.type = "STATUS", .id = "STATUS2", .values = {{"Type", status(kOperatingMode)}}},
           {.type = "OV_PRO", .id = "OV_PRO1"},
           {.type = "SEN_PINT", .id = "SEN_PINT2", .values = {{"Index", "3"}}},
           ethernet,
           correction,
           monitor,
           {.type = "STOP",
            .id = "STOP1",
            .inputs = {{1, {"ETHERNET1", 7}}},
            .values = {{"Mode", std::to_string(number_of("STOP", "Mode", kExitMoveCorr))}}},
           {.type = "MAP2SEN_PINT",
            .id = "MAP2SEN_PINT1",
            .inputs = {{1, {"ETHERNET1", 8}}},
            .values = {{"Index", "2"}}}}};
}

}  // namespace truepose::rsi
