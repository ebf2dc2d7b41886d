#include "tools/report/report_text.hpp"

#include <fmt/format.h>

#include <boost/json/object.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/report/findings_text.hpp"
#include "tools/report/number_text.hpp"
#include "tools/report/report_document.hpp"

namespace truepose::report {
namespace {

struct Column {
  std::string_view title;
  const ErrorStatistics* errors;
  const StageSpread* spread = nullptr;  ///< over the runs of the validation, where there were several
};
using Columns = std::vector<Column>;

/// @param deviation  of the value over the runs of the validation; null where it is not known
template <typename Value>
std::string row(std::string_view name, const Columns& columns, Value value,
                double StageSpread::*deviation = nullptr) {
  std::string line = fmt::format("  {:<10}", name);
  for (const Column& column : columns) {
    const double mm = value(*column.errors);
    if (!column.spread) {
      line += fmt::format("{:>13}", error_text(mm));
    } else if (deviation) {
      line += fmt::format("{:>18}", error_text(mm, column.spread->*deviation));
    } else {
      line += fmt::format("{:>10}        ", error_text(mm));  // as wide as with " ± 0.003"
    }
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

std::string table(std::string_view title, const Stages& stages, const ErrorStatistics* remeasured,
                  const Spread* spread) {
  const auto of = [spread](StageSpread Spread::*stage) { return spread ? &(spread->*stage) : nullptr; };
  Columns columns{{"before", &stages.before, of(&Spread::before)},
                  {"geometric", &stages.geometric, of(&Spread::geometric)}};
  if (has_layers(stages)) columns.push_back({"all layers", &stages.after, of(&Spread::after)});
  if (remeasured != nullptr) columns.push_back({"compensated", remeasured});

  std::string text = fmt::format("{}\n  {:<10}", title, "mm");
  for (const Column& column : columns) text += fmt::format("{:>{}}", column.title, column.spread ? 18 : 13);
  text += "\n";
  using S = const ErrorStatistics&;
  text += row(
              "mean", columns, [](S s) { return s.mean; }, &StageSpread::mean) +
          row(
              "max", columns, [](S s) { return s.max; }, &StageSpread::max) +
          row("min", columns, [](S s) { return s.min; }) +
          row(
              "RMS", columns, [](S s) { return s.rms; }, &StageSpread::rms);
  const std::pair<std::string_view, AxisStatistics ErrorStatistics::*> axes[] = {
      {"x", &ErrorStatistics::x}, {"y", &ErrorStatistics::y}, {"z", &ErrorStatistics::z}};
  for (const auto& [name, axis] : axes) {
    text += row(fmt::format("mean |{}|", name), columns, [&](S s) { return (s.*axis).mean_abs; }) +
            row(fmt::format("max |{}|", name), columns, [&](S s) { return (s.*axis).max_abs; });
  }
  return text;
}

std::string tables(const ReportDocument& document) {
  const ErrorStatistics* remeasured = document.remeasured ? &*document.remeasured : nullptr;
  const auto counts = [](std::string_view set, const Stages& stages) {
    return fmt::format("{}: {} poses, {} points", set, stages.poses, stages.points);
  };
  std::string text = table(counts("Identification", document.identify), document.identify,
                           document.validate ? nullptr : remeasured, nullptr);
  if (!document.validate) return text;
  std::string title = counts("Validation", *document.validate);
  if (const std::string runs = validation_text(document); !runs.empty()) title += ", " + runs;
  const Spread* spread = document.findings.spread ? &*document.findings.spread : nullptr;
  return text + "\n" + table(title, *document.validate, remeasured, spread);
}

}  // namespace

std::string render_text(const boost::json::object& json) {
  const ReportDocument document = read_document(json);
  std::string text = tables(document);

  const double before = document.judged().before.mean, after = document.achieved().mean;
  text += fmt::format(
      "\nMean position error {} mm -> {} mm, {}. {} of {} geometric parameters determined.\n",
      error_text(before), error_text(after),
      document.improved() ? factor_text(before, after) + " times more accurate" : "no improvement",
      document.rank, document.geometric_parameters());
  if (!document.converged) text += "The identification did not converge: do not use this model.\n";
  if (!document.validate) text += "Nothing was validated: these are the errors of the fitted points.\n";
  return text + findings_text(document);
}

std::string why_unusable(const boost::json::object& json) {
  const ReportDocument document = read_document(json);
  if (!document.converged) return "the identification did not converge";
  if (!document.validate || document.improved()) return {};
  return "on validation poses the calibrated arm is no better than the nominal one";
}

}  // namespace truepose::report
