#include "tools/report/experiment_html.hpp"

#include <boost/json/object.hpp>

#include "proto/control/json_text.hpp"
#include "tools/report/experiment_sections.hpp"
#include "tools/report/html_page.hpp"
#include "tools/report/raw_data.hpp"

namespace truepose::report {

std::string render_experiment_html(const boost::json::object& document) {
  return html_page("Calibration experiment",
                   experiment_sections(document) + raw_data_section({{"experiment.json", "application/json",
                                                                      control::json_text(document) + "\n",
                                                                      "every figure of this page"}}));
}

}  // namespace truepose::report
