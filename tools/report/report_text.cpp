#include "tools/report/report_text.hpp"

#include <fmt/format.h>

#include <boost/json/object.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/report/number_text.hpp"
#include "tools/report/report_document.hpp"

namespace truepose::report {
namespace {

using Columns = std::vector<std::pair<std::string_view, const ErrorStatistics*>>;

template <typename Value>
std::string row(std::string_view name, const Columns& columns, Value value) {
  std::string line = fmt::format("  {:<10}", name);
  for (const auto& [title, statistics] : columns)
    line += fmt::format("{:>13}", error_text(value(*statistics)));
  return line + "\n";
}

std::string table(std::string_view title, const Stages& stages, const ErrorStatistics* remeasured) {
  Columns columns{{"before", &stages.before}, {"geometric", &stages.geometric}};
  if (has_layers(stages)) columns.emplace_back("all layers", &stages.after);
  if (remeasured != nullptr) columns.emplace_back("compensated", remeasured);

  std::string text =
      fmt::format("{}: {} poses, {} points\n  {:<10}", title, stages.poses, stages.points, "mm");
  for (const auto& [name, statistics] : columns) text += fmt::format("{:>13}", name);
  text += "\n";
  using S = const ErrorStatistics&;
  text += row("mean", columns, [](S s) { return s.mean; }) + row("max", columns, [](S s) { return s.max; }) +
          row("min", columns, [](S s) { return s.min; }) + row("RMS", columns, [](S s) { return s.rms; });
  const std::pair<std::string_view, AxisStatistics ErrorStatistics::*> axes[] = {
      {"x", &ErrorStatistics::x}, {"y", &ErrorStatistics::y}, {"z", &ErrorStatistics::z}};
  for (const auto& [name, axis] : axes) {
    text += row(fmt::format("mean |{}|", name), columns, [&](S s) { return (s.*axis).mean_abs; }) +
            row(fmt::format("max |{}|", name), columns, [&](S s) { return (s.*axis).max_abs; });
  }
  return text;
}

}  // namespace

std::string render_text(const boost::json::object& json) {
  const ReportDocument document = read_document(json);
  const ErrorStatistics* remeasured = document.remeasured ? &*document.remeasured : nullptr;
  std::string text = table("Identification", document.identify, document.validate ? nullptr : remeasured);
  if (document.validate) text += fmt::format("\n{}", table("Validation", *document.validate, remeasured));

  const double before = document.judged().before.mean, after = document.achieved().mean;
  text += fmt::format("\nMean position error {} mm -> {} mm, {}. {} of {} parameters determined.\n",
                      error_text(before), error_text(after),
                      after < before ? factor_text(before, after) + " times more accurate" : "no improvement",
                      document.rank, document.parameters.size());
  if (!document.converged) text += "The identification did not converge: do not use this model.\n";
  if (!document.validate) text += "Nothing was validated: these are the errors of the fitted points.\n";
  return text;
}

}  // namespace truepose::report
