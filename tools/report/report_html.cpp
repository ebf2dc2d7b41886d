#include "tools/report/report_html.hpp"

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/control/json_text.hpp"
#include "tools/report/cloud_section.hpp"
#include "tools/report/conditions_section.hpp"
#include "tools/report/experiment_sections.hpp"
#include "tools/report/html_page.hpp"
#include "tools/report/iso9283_section.hpp"
#include "tools/report/joint_section.hpp"
#include "tools/report/knowledge_sections.hpp"
#include "tools/report/layer_section.hpp"
#include "tools/report/raw_data.hpp"
#include "tools/report/report_charts.hpp"
#include "tools/report/report_document.hpp"
#include "tools/report/report_tables.hpp"
#include "tools/report/summary_section.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;

/// "Leica AT960, serial 4 · Campaign 0cd9d377 · 2026-11-21 21:34 UTC", of which what is not known is left
/// out.
std::string identity(const ReportDocument& document) {
  std::string text;
  for (const std::string& part :
       {document.tracker, document.campaign,
        document.model.empty() ? "" : "Model " + document.model.substr(0, 8), time_text(document.date)}) {
    if (!part.empty()) text += (text.empty() ? "" : " · ") + part;
  }
  return text;
}

std::vector<EmbeddedFile> embedded_files(const json::object& document, const FurtherDocuments& further) {
  std::vector<EmbeddedFile> files;
  if (std::string csv = measurements_csv(document); !csv.empty()) {
    files.push_back({"measurements.csv", "text/csv", std::move(csv),
                     "what was measured, as truepose calibrate --data reads it"});
  }
  if (const json::value* arm = document.if_contains("arm")) {
    files.push_back({"robot.yaml", "application/yaml", control::json_text(*arm) + "\n",
                     "the data sheet's arm, as truepose calibrate --robot reads it"});
  }
  const auto add = [&files](const char* name, const json::object& from, const char* about) {
    files.push_back({name, "application/json", control::json_text(from) + "\n", about});
  };
  add("report.json", document, "everything that is shown here, as truepose report --document reads it");
  if (further.iso9283) add("iso9283.json", *further.iso9283, "the test by ISO 9283");
  if (further.experiment) add("experiment.json", *further.experiment, "the experiment");
  return files;
}

}  // namespace

std::string render_html(const json::object& json, const FurtherDocuments& further) {
  const ReportDocument document = read_document(json);
  const std::string robot = document.robot.empty() ? "Robot arm" : document.robot;
  std::string body = page_header("Calibration report", robot, identity(document));
  body += summary_section(document) + statistics_section(document) + conditions_section(document) +
          histogram_section(document) + cloud_section(document) + point_sections(document) +
          joint_section(document) + layer_section(document) + transfer_section(document) +
          rejected_section(document) + drift_section(document) + parameters_section(document) +
          unknown_section(document) + stream_section(document);
  if (further.iso9283) body += iso9283_section(*further.iso9283);
  if (further.experiment) body += experiment_sections(*further.experiment);
  body += raw_data_section(embedded_files(json, further));
  return html_page(robot + ": calibration report", body);
}

}  // namespace truepose::report
