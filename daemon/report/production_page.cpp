#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::report {

std::string render_production_html(const record::ProductionDocument& document) {
  const record::Production& production = document.production;
  return html_page(
      production.path.program + ": path report",
      page_header("Path report", document.robot, "Model " + document.model) + production_section(production) +
          raw_data_section(
              {{"production.csv", "text/csv", production_csv(production.path),
                "where the reflector was in production, in the robot's base frame"},
               {"report.json", "application/json", control::json_text(record::to_json(document)) + "\n",
                "everything that is shown here"}}));
}

}  // namespace truepose::report
