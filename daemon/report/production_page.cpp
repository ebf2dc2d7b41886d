#include <boost/json.hpp>
#include <stdexcept>
#include <string>

#include "daemon/report/page.hpp"
#include "daemon/report/report.hpp"
#include "daemon/report/sections.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;

record::Production production_of(const json::object& document) {
  const json::value* const production = document.if_contains("production");
  if (production == nullptr || !production->is_object())
    throw std::invalid_argument{"production: missing, expected an object"};
  auto read = record::read_production(production->as_object());
  if (!read) throw std::invalid_argument{"production: " + read.error()};
  return *std::move(read);
}

std::string text_in(const json::object& document, const char* name) {
  const json::value* const text = document.if_contains(name);
  return text != nullptr && text->is_string() ? std::string{text->as_string()} : "";
}

}  // namespace

std::string render_production_html(const json::object& document) {
  const record::Production production = production_of(document);
  return html_page(
      production.path.program + ": path report",
      page_header("Path report", text_in(document, "robot"), "Model " + text_in(document, "model")) +
          production_section(production) +
          raw_data_section({{"production.csv", "text/csv", production_csv(production.path),
                             "where the reflector was in production, in the robot's base frame"},
                            {"report.json", "application/json", control::json_text(document) + "\n",
                             "everything that is shown here"}}));
}

std::string render_production_text(const json::object& document) {
  return production_text(production_of(document));
}

std::string why_production_unusable(const json::object& document) {
  return why_refuted(production_of(document));
}

}  // namespace truepose::report
