#include "tools/report/raw_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;

std::string quoted(std::string_view text) {
  std::string field = "\"";
  for (const char c : text) {
    if (c == '"') field += '"';
    field += c;
  }
  return field + '"';
}

/// The shortest text that brings the number back.
std::string number(const json::value& value) { return fmt::format("{}", value.to_number<double>()); }

std::string field(const json::object& point, std::string_view member) {
  const json::value* value = point.if_contains(member);
  if (value == nullptr) return {};
  return value->is_string() ? quoted(std::string_view(value->get_string())) : number(*value);
}

std::string fields(const json::object& point, std::string_view member) {
  std::string text;
  for (const json::value& element : point.at(member).as_array()) text += number(element) + ",";
  return text;
}

/// A column that some points may lack is there only where all have it: a measurement file has no empty cells.
bool all_have(const json::array& points, std::string_view member) {
  return std::ranges::all_of(points,
                             [&](const json::value& point) { return point.as_object().contains(member); });
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

}  // namespace

std::string measurements_csv(const json::object& document) {
  const json::value* list = document.if_contains("points");
  if (list == nullptr || list->as_array().empty() || !all_have(list->as_array(), "position")) return {};
  const json::array& points = list->as_array();
  const bool direction = all_have(points, "direction"), sigma = all_have(points, "sigma"),
             time = all_have(points, "time");

  std::string csv;
  const std::size_t joints = points.front().at("joints").as_array().size();
  for (std::size_t i = 1; i <= joints; ++i) csv += fmt::format("q{},", i);
  csv += "x,y,z,";
  for (std::size_t i = 1; direction && i <= joints; ++i) csv += fmt::format("dir{},", i);
  csv += fmt::format("{}{}smr,set\n", sigma ? "sigma," : "", time ? "time," : "");
  for (const json::value& element : points) {
    const json::object& point = element.as_object();
    csv += fields(point, "joints") + fields(point, "position");
    if (direction) csv += fields(point, "direction");
    if (sigma) csv += field(point, "sigma") + ",";
    if (time) csv += field(point, "time") + ",";
    csv += field(point, "smr") + "," + std::string(std::string_view(point.at("set").as_string())) + "\n";
  }
  return csv;
}

std::string raw_data_section(const std::vector<EmbeddedFile>& files) {
  if (files.empty()) return "";
  std::string html =
      "<section class=\"whole raw\">\n<h2>Raw data</h2>\n<p class=\"note\">This page carries what it was "
      "made from, so that every figure can be computed again.</p>\n<ul class=\"files\">\n";
  for (const EmbeddedFile& file : files) {
    html +=
        fmt::format("<li><a download=\"{0}\" href=\"data:{1};base64,{2}\">{0}</a> ({3:.0f} kB): {4}</li>\n",
                    xml::escaped(file.name), file.type, base64(file.content),
                    std::max(1.0, static_cast<double>(file.content.size()) / 1000), file.about);
  }
  return html + "</ul>\n</section>\n";
}

}  // namespace truepose::report
