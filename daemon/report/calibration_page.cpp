#include <fmt/format.h>

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/calibrate/option_names.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;

/// "Leica AT960, serial 4 · Campaign 0cd9d377 · 2026-11-21 21:34 UTC", of which what is not known is left
/// out.
std::string identity(const ReportDocument& document) {
  const std::string& model = document.model;
  std::string text;
  for (const std::string& part :
       {document.tracker, document.campaign, model.empty() ? model : "Model " + model.substr(0, 8),
        time_text(document.date)}) {
    if (!part.empty()) text += (text.empty() ? "" : " · ") + part;
  }
  return text;
}

/// Of a document, its arm as it is written: the record's angles would come back in other last digits.
struct WrittenArm {
  std::optional<json::value> arm;
};
void layout(record::Io& io, WrittenArm& x) { io.optional("arm", x.arm); }

/// The shortest texts that bring the numbers back.
std::string fields(const auto& numbers) {
  std::string text;
  for (const auto number : numbers) text += fmt::format("{},", number);
  return text;
}

std::vector<EmbeddedFile> embedded_files(const ReportDocument& document, const FurtherDocuments& further) {
  std::vector<EmbeddedFile> files;
  // A measurement file is of one station.
  if (std::string csv = measurements_csv(document.points); document.stations.empty() && !csv.empty()) {
    files.push_back({"measurements.csv", "text/csv", std::move(csv),
                     "what was measured, as truepose calibrate --data reads it"});
  }
  if (const auto arm = record::from_json<WrittenArm>(document.json).value().arm) {
    files.push_back({"robot.yaml", "application/yaml", control::json_text(*arm) + "\n",
                     "the data sheet's arm, as truepose calibrate --robot reads it"});
  }
  if (document.production) {
    files.push_back({"production.csv", "text/csv", production_csv(document.production->path),
                     "where the reflector was in production, in the robot's base frame"});
  }
  const auto add = [&files](const char* name, const json::object& from, const char* about) {
    files.push_back({name, "application/json", control::json_text(from) + "\n", about});
  };
  add("report.json", document.json, "everything that is shown here, as truepose report --document reads it");
  if (further.iso9283) add("iso9283.json", *further.iso9283, "the test by ISO 9283");
  if (further.frame) add("frame.json", *further.frame, "the tool or base that was measured");
  return files;
}

}  // namespace

std::string csv_text(std::string_view text) {
  std::ostringstream field;
  field << std::quoted(text, '"', '"');
  return field.str();
}

std::string measurements_csv(const std::vector<record::Point>& points) {
  // A column that some points may lack is there only where all have it, but for the excess: it is empty where
  // there is none.
  const auto all_have = [&points](auto member) {
    return std::ranges::all_of(points, [member](const record::Point& point) { return member(point); });
  };
  if (points.empty() || !all_have([](const auto& p) { return p.position.has_value(); })) return {};
  const bool direction = all_have([](const auto&p) { return !p.direction.empty(); }),
             payload = all_have([](const auto&p) { return p.payload.has_value(); }),
             turns = std::ranges::any_of(points, [](const auto&p) { return p.orientation.has_value(); }),
             sigma = all_have([](const auto&p) { return p.sigma.has_value(); }),
             excess = std::ranges::any_of(points, [](const auto&p) { return p.excess.has_value(); }),
             time = all_have([](const auto&p) { return !p.time.empty(); });

  std::string csv;
  const std::size_t joints = points.front().joints.size();
  for (std::size_t i = 1; i <= joints; ++i) csv += fmt::format("q{},", i);
  csv += "x,y,z,";
  for (std::size_t i = 1; direction && i <= joints; ++i) csv += fmt::format("dir{},", i);
  if (payload) csv += "payload_kg,payload_x,payload_y,payload_z,";
  if (turns) csv += "a,b,c,sigma_abc,";
  csv += fmt::format("{}{}{}smr,set,pose\n", sigma ? "sigma," : "", excess ? "excess," : "",
                     time ? "time," : "");
  for (const record::Point& point : points) {
    csv += fields(point.joints) + fields(*point.position);
    if (direction) csv += fields(point.direction);
    if (payload) csv += fmt::format("{},", point.payload->mass_kg) + fields(point.payload->centre_mm);
    if (const auto& turn = point.orientation)
      csv += fmt::format("{},{},{},{},", turn->a, turn->b, turn->c, turn->sigma);
    else if (turns)
      csv += ",,,,";
    if (sigma) csv += fmt::format("{},", *point.sigma);
    if (excess && point.excess) csv += fmt::format("{}", *point.excess);
    if (excess) csv += ",";
    if (time) csv += csv_text(point.time) + ",";
    csv += fmt::format("{},{},{}\n", csv_text(point.smr), name_of(kPoseSetNames, point.set), point.pose);
  }
  return csv;
}

std::string render_html(const ReportDocument& document, const FurtherDocuments& further) {
  const std::string robot = document.robot.empty() ? "Robot arm" : document.robot;
  std::string body = page_header("Calibration report", robot, identity(document));
  for (const auto section :
       {summary_section, statistics_section, turns_section, production_section, conditions_section,
        histogram_section, cloud_section, point_sections, joint_section, layer_section, transfer_section,
        rejected_section, drift_section, parameters_section, unknown_section, stream_section}) {
    body += section(document);
  }
  if (further.frame) body += frame_section(*further.frame);
  if (further.iso9283) body += iso9283_section(*further.iso9283);
  body += raw_data_section(embedded_files(document, further));
  return html_page(robot + ": calibration report", body);
}

}  // namespace truepose::report
