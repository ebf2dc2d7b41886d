#include <fmt/format.h>

#include <algorithm>
#include <boost/json/object.hpp>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/math/angles.hpp"
#include "daemon/report/charts.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/iso9283_document.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

using Sets = std::vector<record::Iso9283Document::Set>;

/// The standard's worked figures are compared digit by digit, so these have one more than other errors.
std::string iso_mm(double mm) { return fmt::format("{:.4f}", mm); }

/// "P1, +x, 60 min": the point and, where there are several, the direction and the series.
std::string place_of(std::initializer_list<std::string_view> parts) {
  std::string text;
  for (const std::string_view part : parts) {
    if (!part.empty()) text += fmt::format("{}{}", text.empty() ? "" : ", ", part);
  }
  return xml::escaped(text);
}

std::string_view frame_sentence(record::Iso9283Frame frame) {
  switch (frame) {
    case record::Iso9283Frame::Model:
      return "Measured poses were brought into the robot's base by the model's base pose.";
    case record::Iso9283Frame::Fitted:
      return "The measuring frame was fitted to the commanded positions: AP is relative to that fit, and the "
             "absolute one is greater.";
    case record::Iso9283Frame::AsGiven:
      break;
  }
  return "Measured poses were taken as given, in the frame of the commanded ones.";
}

/// Three angles, a dash for each where this set tells none.
void add_angles(std::vector<std::string>& cells, const std::optional<Eigen::Vector3d>& abc_rad) {
  for (int i = 0; i < 3; ++i)
    cells.push_back(abc_rad ? fmt::format("{:.4f}", (*abc_rad)[i] * kDegPerRad) : "-");
}

std::string set_table(const Sets& sets) {
  std::vector<Column> columns{{},
                              {"cycles"},
                              {"AP<sub>p</sub>", "strong"},
                              {"AP<sub>x</sub>"},
                              {"AP<sub>y</sub>"},
                              {"AP<sub>z</sub>"},
                              {"RP<sub>l</sub>", "strong first"}};
  const bool angles = std::ranges::any_of(
      sets, [](const auto& set) { return set.characteristics.repeatability.abc_rad.has_value(); });
  if (angles) {
    columns.insert(columns.end(), {{"AP<sub>a</sub>", "first"},
                                   {"AP<sub>b</sub>"},
                                   {"AP<sub>c</sub>"},
                                   {"RP<sub>a</sub>", "first"},
                                   {"RP<sub>b</sub>"},
                                   {"RP<sub>c</sub>"}});
  }
  Table table{"iso9283", std::move(columns)};
  for (const auto& [point, direction, time, cycles, characteristics] : sets) {
    const auto& [ap, rp] = characteristics;
    std::vector<std::string> cells{fmt::format("{}", cycles), iso_mm(ap.p_mm)};
    for (const double mm : ap.xyz_mm) cells.push_back(iso_mm(mm));
    cells.push_back(iso_mm(rp.l_mm));
    if (angles) {
      add_angles(cells, ap.abc_rad);
      add_angles(cells, rp.abc_rad);
    }
    table.row(place_of({point, direction, time}), cells);
  }
  return std::move(table).scrolled();
}

std::string set_chart(const Sets& sets) {
  Series accuracy{"Accuracy AP, of the position", kGeometricColor, Marker::Circle};
  Series repeatability{"Repeatability RP, of the position", kBeforeColor, Marker::Diamond};
  double x = 0;
  for (const auto& set : sets) {
    x += 1;
    accuracy.points.push_back({x, set.characteristics.accuracy.p_mm, set.point});
    repeatability.points.push_back({x, set.characteristics.repeatability.l_mm, set.point});
  }
  return charts(point_chart_svg({.title = "Position accuracy and repeatability",
                                 .x_label = "set of cycles",
                                 .y_unit = "mm",
                                 .series = {std::move(accuracy), std::move(repeatability)}}));
}

std::string variation_list(const std::vector<record::Iso9283Document::Variation>& variations) {
  std::vector<std::string> sentences;
  for (const auto& [point, time, directions, variation] : variations)
    sentences.push_back(fmt::format("{}: vAP<sub>p</sub> {} mm over {} directions", place_of({point, time}),
                                    iso_mm(variation.p_mm), directions.size()));
  return sentence_list("Multi-directional variation of the position accuracy", sentences);
}

std::string drift_list(const std::vector<record::Iso9283Document::Drift>& drifts) {
  std::vector<std::string> sentences;
  for (const auto& [point, direction, times, drift] : drifts) {
    sentences.push_back(fmt::format(
        "{}: dAP<sub>p</sub> {} mm, dRP<sub>l</sub> {} mm from {} to {}; the mean position moved by {} mm",
        place_of({point, direction}), iso_mm(drift.ap_p_mm), iso_mm(drift.rp_l_mm),
        xml::escaped(times.front()), xml::escaped(times.back()), iso_mm(drift.moved_mm)));
  }
  return sentence_list("Drift of the pose characteristics", sentences);
}

}  // namespace

std::string iso9283_section(const boost::json::object& json) {
  const auto read = record::read_iso9283_document(json);
  if (!read) throw std::invalid_argument("ISO 9283 document: " + read.error());
  const Sets& sets = read->sets;
  double worst_ap_mm = 0, worst_rp_mm = 0;
  for (const auto& set : sets) {
    worst_ap_mm = std::max(worst_ap_mm, set.characteristics.accuracy.p_mm);
    worst_rp_mm = std::max(worst_rp_mm, set.characteristics.repeatability.l_mm);
  }
  std::string html = fmt::format(
      "<p>At worst AP<sub>p</sub> {:.4f} mm and RP<sub>l</sub> {:.4f} mm, over {} sets of cycles.</p>\n",
      worst_ap_mm, worst_rp_mm, sets.size());
  html += note(fmt::format("{} Lengths in mm, angles in degrees.", frame_sentence(read->frame)));
  if (!read->missing.empty()) {
    html += fmt::format(
        "<p class=\"caution\">No cycle came to {}: these figures do not hold there, as the standard asks for 30 "
        "cycles at every commanded pose, and they do not comply.</p>\n",
        xml::escaped(fmt::format("{}", fmt::join(read->missing, ", "))));
  } else if (!read->complete) {
    html += fmt::format(
        "<p class=\"caution\">The standard asks for 30 cycles, and some poses have {}: these figures do not "
        "comply.</p>\n",
        read->cycles);
  }
  return section(
      "Pose accuracy and repeatability by " + xml::escaped(read->standard),
      html + set_table(sets) + set_chart(sets) + variation_list(read->variations) + drift_list(read->drifts));
}

std::string render_iso9283_html(const boost::json::object& document, const std::string& data_file,
                                std::vector<EmbeddedFile> files) {
  files.push_back(
      {"iso9283.json", "application/json", control::json_text(document) + "\n", "every figure of this page"});
  return html_page("ISO 9283 test", page_header("ISO 9283 test", data_file) + iso9283_section(document) +
                                        raw_data_section(files));
}

}  // namespace truepose::report
