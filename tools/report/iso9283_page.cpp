#include <fmt/format.h>

#include <algorithm>
#include <boost/json/object.hpp>
#include <initializer_list>
#include <utility>

#include "core/math/angles.hpp"
#include "proto/control/json_text.hpp"
#include "proto/xml/escape.hpp"
#include "tools/report/charts.hpp"
#include "tools/report/json_node.hpp"
#include "tools/report/page.hpp"
#include "tools/report/sections.hpp"

namespace truepose::report {
namespace {

/// The standard's worked figures are compared digit by digit, so these have one more than other errors.
std::string iso_mm(const Node& figure) { return fmt::format("{:.4f}", figure.number()); }

/// "P1 +x, 60 min": the point and, where there are several, the direction and the series.
std::string place_of(const Node& node, std::initializer_list<std::string_view> members) {
  std::string text;
  for (const std::string_view member : members) {
    const std::string part = node[member].text();
    if (!part.empty()) text += (text.empty() ? "" : ", ") + part;
  }
  return xml::escaped(text);
}

std::string frame_sentence(const Node& document) {
  const std::string frame = document["frame"].text();
  if (frame == "model") return "Measured poses were brought into the robot's base by the model's base pose.";
  if (frame == "fitted")
    return "The measuring frame was fitted to the commanded positions: AP is relative to that fit, and the "
           "absolute one is greater.";
  return "Measured poses were taken as given, in the frame of the commanded ones.";
}

std::string set_table(const std::vector<Node>& sets) {
  std::vector<Column> columns{{},
                              {"cycles"},
                              {"AP<sub>p</sub>", "strong"},
                              {"AP<sub>x</sub>"},
                              {"AP<sub>y</sub>"},
                              {"AP<sub>z</sub>"},
                              {"RP<sub>l</sub>", "strong first"}};
  const bool angles = std::ranges::any_of(sets, [](const Node& set) { return set["RP"]["a"].exists(); });
  if (angles) {
    columns.insert(columns.end(), {{"AP<sub>a</sub>", "first"},
                                   {"AP<sub>b</sub>"},
                                   {"AP<sub>c</sub>"},
                                   {"RP<sub>a</sub>", "first"},
                                   {"RP<sub>b</sub>"},
                                   {"RP<sub>c</sub>"}});
  }
  Table table{"iso9283", std::move(columns)};
  for (const Node& set : sets) {
    const Node ap = set["AP"], rp = set["RP"];
    std::vector<std::string> cells{fmt::format("{}", set["cycles"].integer())};
    for (const char* name : {"p", "x", "y", "z"}) cells.push_back(iso_mm(ap[name]));
    cells.push_back(iso_mm(rp["l"]));
    for (const Node& characteristic : {ap, rp}) {
      for (const char* name : {"a", "b", "c"}) {
        const Node angle = characteristic[name];
        // A dash where this set tells none.
        if (angles)
          cells.push_back(angle.exists() ? fmt::format("{:.4f}", angle.number() * kDegPerRad) : "-");
      }
    }
    table.row(place_of(set, {"point", "direction", "time"}), cells);
  }
  return std::move(table).scrolled();
}

std::string set_chart(const std::vector<Node>& sets) {
  Series accuracy{"Accuracy AP, of the position", kGeometricColor, Marker::Circle};
  Series repeatability{"Repeatability RP, of the position", kBeforeColor, Marker::Diamond};
  double x = 0;
  for (const Node& set : sets) {
    x += 1;
    const std::string name = set["point"].text();
    accuracy.points.push_back({x, set["AP"]["p"].number(), name});
    repeatability.points.push_back({x, set["RP"]["l"].number(), name});
  }
  return charts(point_chart_svg({.title = "Position accuracy and repeatability",
                                 .x_label = "set of cycles",
                                 .y_unit = "mm",
                                 .series = {std::move(accuracy), std::move(repeatability)}}));
}

std::string variation_list(const Node& variations) {
  return sentence_list(
      "Multi-directional variation of the position accuracy", variations.each([](const Node& v) {
        return fmt::format("{}: vAP<sub>p</sub> {} mm over {} directions", place_of(v, {"point", "time"}),
                           iso_mm(v["vAP"]["p"]), v["directions"].elements().size());
      }));
}

std::string drift_list(const Node& drifts) {
  return sentence_list("Drift of the pose characteristics", drifts.each([](const Node& d) {
    const std::vector<std::string> times = d["times"].texts();
    if (times.empty()) d["times"].fail("a list of series");
    return fmt::format(
        "{}: dAP<sub>p</sub> {} mm, dRP<sub>l</sub> {} mm from {} to {}; the mean position moved by {} mm",
        place_of(d, {"point", "direction"}), iso_mm(d["dAP"]["p"]), iso_mm(d["dRP"]["l"]),
        xml::escaped(times.front()), xml::escaped(times.back()), iso_mm(d["moved"]));
  }));
}

/// The greatest value of AP's or RP's figure over all sets.
double worst(const std::vector<Node>& sets, std::string_view characteristic, std::string_view name) {
  double value = 0;
  for (const Node& set : sets) value = std::max(value, set[characteristic][name].number());
  return value;
}

}  // namespace

std::string iso9283_section(const boost::json::object& json) {
  const Node document{json, "ISO 9283 document"};
  const std::vector<Node> sets = document["sets"].elements();
  const std::string standard = xml::escaped(document["standard"].text());
  std::string html = fmt::format(
      "<p>At worst AP<sub>p</sub> {:.4f} mm and RP<sub>l</sub> {:.4f} mm, over {} sets of cycles.</p>\n",
      worst(sets, "AP", "p"), worst(sets, "RP", "l"), sets.size());
  html += note(frame_sentence(document) + " Lengths in mm, angles in degrees.");
  if (!document["complete"].flag()) {
    html += fmt::format(
        "<p class=\"caution\">The standard asks for 30 cycles, and some poses have {}: these figures do not "
        "comply.</p>\n",
        document["cycles"].integer());
  }
  return section("Pose accuracy and repeatability by " + standard,
                 html + set_table(sets) + set_chart(sets) + variation_list(document["variations"]) +
                     drift_list(document["drifts"]));
}

std::string render_iso9283_html(const boost::json::object& document, const std::string& data_file,
                                std::vector<EmbeddedFile> files) {
  files.push_back(
      {"iso9283.json", "application/json", control::json_text(document) + "\n", "every figure of this page"});
  return html_page("ISO 9283 test", page_header("ISO 9283 test", data_file) + iso9283_section(document) +
                                        raw_data_section(files));
}

}  // namespace truepose::report
