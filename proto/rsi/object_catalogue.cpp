#include "proto/rsi/object_catalogue.hpp"

#include <algorithm>
#include <array>
#include <boost/algorithm/string/case_conv.hpp>
#include <boost/algorithm/string/classification.hpp>
#include <boost/algorithm/string/predicate.hpp>
#include <boost/algorithm/string/split.hpp>
#include <boost/algorithm/string/trim.hpp>
#include <string>

#include "proto/rsi/object_table.hpp"
#include "proto/xml/scanner.hpp"

namespace truepose::rsi {
namespace {

/// A line of the table, by its columns.
enum Column { kId, kName, kFrom, kUntil, kInputs, kOutputs, kParameters, kInRsi3, kColumns };

std::vector<std::string> parts(const std::string& text, const char* separators) {
  std::vector<std::string> parts;
  if (text != "-") boost::split(parts, text, boost::is_any_of(separators), boost::token_compress_on);
  return parts;
}

int whole(const std::string& text) { return xml::to_number<int>(text).value_or(-1); }

/// "0:In1*64"
CataloguePort port_of(const std::string& text) {
  const std::vector<std::string> copies = parts(text.substr(text.find(':') + 1), "*");
  return {copies.front(), copies.size() > 1 ? whole(copies.back()) : 1};
}

std::vector<CataloguePort> ports_of(const std::string& text) {
  std::vector<CataloguePort> ports;
  for (const std::string& each : parts(text, " ")) ports.push_back(port_of(each));
  return ports;
}

/// "0:Mode:Enum{0:InfoMessage 1:PathNormal}=InfoMessage fixed"
CatalogueParameter parameter_of(std::string text) {
  boost::trim(text);
  CatalogueParameter parameter;
  constexpr std::string_view kFixed = " fixed";
  if (text.ends_with(kFixed)) {
    parameter.fixed = true;
    text.resize(text.size() - kFixed.size());
  }
  const std::size_t equals = text.find('=', text.find('}') == std::string::npos ? 0 : text.find('}'));
  parameter.otherwise = text.substr(equals + 1);
  const std::string head = text.substr(0, equals);
  if (const std::size_t open = head.find('{'); open != std::string::npos) {
    for (const std::string& value : parts(head.substr(open + 1, head.size() - open - 2), " "))
      parameter.values.push_back(value.substr(value.find(':') + 1));
  }
  const std::vector<std::string> words = parts(head.substr(0, head.find('{')), ":");
  parameter.ordinal = whole(words.at(0));
  parameter.name = words.at(1);
  return parameter;
}

std::vector<CatalogueParameter> parameters_of(const std::string& text) {
  std::vector<CatalogueParameter> parameters;
  for (const std::string& each : parts(text, ";")) parameters.push_back(parameter_of(each));
  return parameters;
}

/// An object as RSI 3 has it, by what the last column says: "same", or what differs.
void take_as_in_rsi_3(CatalogueObject& object, const std::string& said) {
  object.name = object.type;
  object.first = 1;
  const std::vector<CatalogueParameter> later = std::move(object.parameters);
  object.parameters = {};
  if (said == "same") {
    object.parameters = later;
    for (CatalogueParameter& each : object.parameters) ++each.ordinal;
    return;
  }
  for (const std::string& each : parts(said, " ")) {
    const std::vector<std::string> name_number = parts(each, "=");
    const std::string& name = name_number.at(0);
    const int number = whole(name_number.at(1));
    if (name == "id") {
      object.id = number;
    } else if (name == "first") {
      object.first = number;
    } else {
      const auto known = std::ranges::find(later, name, &CatalogueParameter::name);
      CatalogueParameter parameter = known == later.end() ? CatalogueParameter{.name = name} : *known;
      parameter.ordinal = number;
      object.parameters.push_back(std::move(parameter));
    }
  }
}

std::vector<CatalogueObject> catalogue_of(ContextFormat format) {
  std::vector<CatalogueObject> objects;
  for (const std::string& line : parts(std::string{object_table()}, "\n")) {
    if (line.empty() || line.starts_with('#')) continue;
    const std::vector<std::string> row = parts(line, "\t");
    const bool is_there = format == ContextFormat::RsiXml  ? row.at(kInRsi3) != "-" && row.at(kFrom) == "4.1"
                          : format == ContextFormat::Rsix6 ? row.at(kUntil) == "6.2"
                                                           : row.at(kFrom) != "6.2";
    if (!is_there) continue;
    CatalogueObject object{.type = boost::to_upper_copy(row.at(kName)),
                           .name = row.at(kName),
                           .id = whole(row.at(kId)),
                           .inputs = ports_of(row.at(kInputs)),
                           .outputs = ports_of(row.at(kOutputs)),
                           .parameters = parameters_of(row.at(kParameters))};
    if (format == ContextFormat::RsiXml) take_as_in_rsi_3(object, row.at(kInRsi3));
    objects.push_back(std::move(object));
  }
  return objects;
}

}  // namespace

const CatalogueParameter* CatalogueObject::parameter(std::string_view named) const {
  const auto found = std::ranges::find(parameters, named, &CatalogueParameter::name);
  return found == parameters.end() ? nullptr : &*found;
}

const std::vector<CatalogueObject>& object_catalogue(ContextFormat format) {
  static const std::array catalogues{catalogue_of(ContextFormat::RsiXml), catalogue_of(ContextFormat::Rsix40),
                                     catalogue_of(ContextFormat::Rsix), catalogue_of(ContextFormat::Rsix6)};
  return catalogues.at(static_cast<std::size_t>(format));
}

const CatalogueObject* catalogued(std::string_view type, ContextFormat format) {
  const std::vector<CatalogueObject>& all = object_catalogue(format);
  const auto found =
      std::ranges::find_if(all, [&](const CatalogueObject& each) { return boost::iequals(each.type, type); });
  return found == all.end() ? nullptr : &*found;
}

int number_of(std::string_view type, std::string_view parameter, std::string_view value) {
  const CatalogueObject* const object = catalogued(type);
  const CatalogueParameter* const known = object == nullptr ? nullptr : object->parameter(parameter);
  if (known == nullptr) return -1;
  const auto found = std::ranges::find(known->values, value);
  return found == known->values.end() ? -1 : static_cast<int>(found - known->values.begin());
}

double otherwise(std::string_view type, std::string_view parameter) {
  const CatalogueObject* const object = catalogued(type);
  const CatalogueParameter* const known = object == nullptr ? nullptr : object->parameter(parameter);
  if (known == nullptr) return 0;
  if (!known->values.empty()) return number_of(type, parameter, known->otherwise);
  return xml::to_number<double>(known->otherwise).value_or(0);
}

}  // namespace truepose::rsi
