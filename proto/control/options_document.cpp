#include "proto/control/options_document.hpp"

#include <boost/json/object.hpp>
#include <string>

#include "core/identify/option_names.hpp"

namespace truepose::control {
namespace {

namespace json = boost::json;

std::string residual_text(const CalibrateOptions& options) {
  if (options.residual.empty()) return "none";
  return options.residual.size() > 1 ? "auto" : std::string{name_of(options.residual.front())};
}

std::string harmonics_text(const CalibrateOptions& options) {
  std::string text;
  for (const int order : options.harmonics) text += (text.empty() ? "" : ", ") + std::to_string(order);
  return text;
}

}  // namespace

json::object options_json(const CalibrateOptions& options) {
  json::object document{{"Loss", name_of(kLossNames, options.loss)},
                        {"Prior", name_of(kPriorNames, options.prior)},
                        {"Joint deviations", options.deviation ? "auto" : "none"},
                        {"Residual field", residual_text(options)}};
  if (options.deviation) document["Harmonics looked for"] = harmonics_text(options);
  return document;
}

json::object noise_json(const MeasurementNoise& noise) {
  const TrackerNoiseModel& tracker = noise.tracker;
  json::object document{{"range_mm", tracker.range_mm},
                        {"transverse_mm_per_m", tracker.transverse_mm_per_m},
                        {"repeatability_mm", noise.repeatability_mm}};
  if (tracker.range_mm_per_m > 0) document["range_mm_per_m"] = tracker.range_mm_per_m;
  if (tracker.transverse_mm > 0) document["transverse_mm"] = tracker.transverse_mm;
  return document;
}

}  // namespace truepose::control
