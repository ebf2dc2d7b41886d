#include "tools/truepose/offline/table_options.hpp"

#include <algorithm>
#include <optional>

#include "config/number_text.hpp"
#include "config/table/column_name.hpp"

namespace truepose::tools {
namespace {

std::optional<config::ColumnChoice> choice_of(const std::string& text) {
  const auto at = text.find('=');
  if (at == std::string::npos || !config::is_own_column_name(text.substr(0, at))) return std::nullopt;
  std::string header = text.substr(at + 1);
  if (header.size() > 2 && header.front() == '"' && header.back() == '"')
    header = header.substr(1, header.size() - 2);
  if (header.empty()) return std::nullopt;
  return config::ColumnChoice{text.substr(0, at), header};
}

std::optional<config::TableUnits> units_in(const std::string& text) {
  const std::string angle = config::unit_word(text.substr(0, text.find(',')));
  const std::string length = config::unit_word(text.substr(std::min(text.find(',') + 1, text.size())));
  const bool is_angle = angle == "deg" || angle == "rad";
  const bool is_length = length == "mm" || length == "cm" || length == "m" || length == "inch";
  if (!text.contains(',') || !is_angle || !is_length) return std::nullopt;
  return config::TableUnits{angle, length};
}

}  // namespace

Option columns_option(TableOptions& options) {
  return {"--columns",
          &options.columns,
          "Columns of the file that have other names than ours, by their names or numbers: "
          "q1=A1,x=\"X [mm]\",y=8",
          {.check = Check{"",
                          [](const std::string& text) -> std::string {
                            if (choice_of(text)) return {};
                            return config::in_quotes(text) + " is not NAME=COLUMN, such as q1=A1 or x=7";
                          }},
           .type = "NAME=COLUMN,.."}};
}

Option units_option(TableOptions& options) {
  return {"--units",
          &options.units,
          "Units of the file's joints and coordinates where their names do not say them",
          {.check = Check{"",
                          [](const std::string& text) -> std::string {
                            if (units_in(text)) return {};
                            return config::in_quotes(text) +
                                   " is not deg or rad and mm, cm, m or inch, as rad,m";
                          }},
           .type = "deg|rad,mm|cm|m|inch"}};
}

config::TableReading reading_of(const TableOptions& options) {
  config::TableReading reading{.columns = {}, .units = units_in(options.units), .report = print_to_stderr};
  for (const std::string& each : options.columns) reading.columns.push_back(*choice_of(each));
  return reading;
}

}  // namespace truepose::tools
