#include "tools/report/iso9283_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "core/math/angles.hpp"
#include "proto/control/json_text.hpp"
#include "proto/xml/escape.hpp"
#include "tools/report/html_page.hpp"
#include "tools/report/report_style.hpp"
#include "tools/report/svg_chart.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;

double figure_of(const json::value& object, std::string_view name) {
  return object.at(name).to_number<double>();
}

/// The standard's worked figures are compared digit by digit, so these have one more than other errors.
std::string iso_mm(const json::value& object, std::string_view name) {
  return fmt::format("{:.4f}", figure_of(object, name));
}

std::string word(const json::value& object, std::string_view name) {
  return std::string(object.at(name).as_string());
}

/// "P1 +x, 60 min": the point and, where there are several, the direction and the series.
std::string place(const json::value& object, std::initializer_list<std::string_view> members) {
  std::string text;
  for (const std::string_view member : members) {
    const std::string part = word(object, member);
    if (!part.empty()) text += (text.empty() ? "" : ", ") + part;
  }
  return xml::escaped(text);
}

std::string frame_sentence(const json::object& document) {
  const std::string_view frame = document.at("frame").as_string();
  if (frame == "model") return "Measured poses were brought into the robot's base by the model's base pose.";
  if (frame == "fitted")
    return "The measuring frame was fitted to the commanded positions: AP is relative to that fit, and the "
           "absolute one is greater.";
  return "Measured poses were taken as given, in the frame of the commanded ones.";
}

bool oriented(const json::value& set) { return set.at("RP").as_object().contains("a"); }

/// Cells of AP or RP about a, b, c in degrees; dashes where this set tells none.
std::string angle_cells(const json::value& characteristic) {
  std::string html;
  for (const char* name : {"a", "b", "c"}) {
    const json::value* angle = characteristic.as_object().if_contains(name);
    html += angle ? fmt::format("<td>{:.4f}</td>", angle->to_number<double>() * kDegPerRad) : "<td>-</td>";
  }
  return html;
}

std::string set_table(const json::array& sets) {
  const bool angles = std::ranges::any_of(sets, oriented);
  std::string html = fmt::format(
      "<div class=\"scroll\"><table "
      "class=\"iso9283\">\n<thead>\n<tr><th></th><th>cycles</th><th>AP<sub>p</sub></th>"
      "<th>AP<sub>x</sub></th><th>AP<sub>y</sub></th><th>AP<sub>z</sub></th><th "
      "class=\"first\">RP<sub>l</sub></th>"
      "{}</tr>\n</thead>\n<tbody>\n",
      angles ? "<th class=\"first\">AP<sub>a</sub></th><th>AP<sub>b</sub></th><th>AP<sub>c</sub></th>"
               "<th class=\"first\">RP<sub>a</sub></th><th>RP<sub>b</sub></th><th>RP<sub>c</sub></th>"
             : "");
  for (const json::value& set : sets) {
    const json::value &ap = set.at("AP"), &rp = set.at("RP");
    html += fmt::format(
        "<tr><th scope=\"row\">{}</th><td>{}</td><td "
        "class=\"strong\">{}</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td class=\"strong first\">{}</td>{}</tr>\n",
        place(set, {"point", "direction", "time"}), set.at("cycles").to_number<long long>(), iso_mm(ap, "p"),
        iso_mm(ap, "x"), iso_mm(ap, "y"), iso_mm(ap, "z"), iso_mm(rp, "l"),
        angles ? angle_cells(ap) + angle_cells(rp) : "");
  }
  return html + "</tbody>\n</table></div>\n";
}

std::string set_chart(const json::array& sets) {
  Series accuracy{"Accuracy AP, of the position", std::string(kGeometricColor), Marker::Circle, {}};
  Series repeatability{"Repeatability RP, of the position", std::string(kBeforeColor), Marker::Diamond, {}};
  double x = 0;
  for (const json::value& set : sets) {
    x += 1;
    const std::string name = word(set, "point");
    accuracy.points.push_back({x, figure_of(set.at("AP"), "p"), name});
    repeatability.points.push_back({x, figure_of(set.at("RP"), "l"), name});
  }
  return "<div class=\"charts\">\n" +
         point_chart_svg({.title = "Position accuracy and repeatability",
                          .x_label = "set of cycles",
                          .y_unit = "mm",
                          .series = {std::move(accuracy), std::move(repeatability)}}) +
         "</div>\n";
}

std::string variation_list(const json::array& variations) {
  if (variations.empty()) return "";
  std::string html =
      "<h3>Multi-directional variation of the position accuracy</h3>\n<ul class=\"sentences\">\n";
  for (const json::value& v : variations) {
    html +=
        fmt::format("<li>{}: vAP<sub>p</sub> {} mm over {} directions</li>\n", place(v, {"point", "time"}),
                    iso_mm(v.at("vAP"), "p"), v.at("directions").as_array().size());
  }
  return html + "</ul>\n";
}

std::string drift_list(const json::array& drifts) {
  if (drifts.empty()) return "";
  std::string html = "<h3>Drift of the pose characteristics</h3>\n<ul class=\"sentences\">\n";
  for (const json::value& d : drifts) {
    const json::array& times = d.at("times").as_array();
    html += fmt::format(
        "<li>{}: dAP<sub>p</sub> {} mm, dRP<sub>l</sub> {} mm from {} to {}; the mean position moved by {} "
        "mm</li>\n",
        place(d, {"point", "direction"}), iso_mm(d.at("dAP"), "p"), iso_mm(d.at("dRP"), "l"),
        xml::escaped(std::string_view(times.front().as_string())),
        xml::escaped(std::string_view(times.back().as_string())), iso_mm(d, "moved"));
  }
  return html + "</ul>\n";
}

/// The greatest value of AP's or RP's figure over all sets.
double worst(const json::array& sets, std::string_view characteristic, std::string_view name) {
  double value = 0;
  for (const json::value& set : sets) value = std::max(value, figure_of(set.at(characteristic), name));
  return value;
}

}  // namespace

std::string iso9283_section(const json::object& document) {
  const json::array& sets = document.at("sets").as_array();
  std::string html = fmt::format(
      "<section>\n<h2>Pose accuracy and repeatability by {}</h2>\n<p>At worst AP<sub>p</sub> {:.4f} mm and "
      "RP<sub>l</sub> {:.4f} mm, over {} sets of cycles.</p>\n<p class=\"note\">{} Lengths in mm, "
      "angles in "
      "degrees.</p>\n",
      xml::escaped(std::string_view(document.at("standard").as_string())), worst(sets, "AP", "p"),
      worst(sets, "RP", "l"), sets.size(), frame_sentence(document));
  if (!document.at("complete").as_bool()) {
    html += fmt::format(
        "<p class=\"caution\">The standard asks for 30 cycles, and some poses have {}: these figures do not "
        "comply.</p>\n",
        document.at("cycles").to_number<long long>());
  }
  return html + set_table(sets) + set_chart(sets) + variation_list(document.at("variations").as_array()) +
         drift_list(document.at("drifts").as_array()) + "</section>\n";
}

std::string render_iso9283_html(const json::object& document, const std::string& data_file,
                                std::vector<EmbeddedFile> files) {
  files.push_back(
      {"iso9283.json", "application/json", control::json_text(document) + "\n", "every figure of this page"});
  return html_page("ISO 9283 test", page_header("ISO 9283 test", data_file, "") + iso9283_section(document) +
                                        raw_data_section(files));
}

}  // namespace truepose::report
