#include "tools/truepose/experiment_document.hpp"

#include <boost/json.hpp>
#include <string_view>

#include "proto/record/calibration_document.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

json::object noise_json(const ExperimentOptions& options) {
  return {
      {"tracker", options.tracker_noise_mm},
      {"repeatability", options.repeatability_mm},
      {"gross",
       {{"fraction", options.gross.fraction}, {"min", options.gross.min_mm}, {"max", options.gross.max_mm}}},
      {"guess",
       {{"base", options.guess.base_mm},
        {"base_rad", options.guess.base_rad},
        {"smr", options.guess.smr_mm}}}};
}

std::string_view name_of(TrialData data) {
  switch (data) {
    case TrialData::NoiseFree:
      return "noise-free";
    case TrialData::Noisy:
      return "noisy";
    case TrialData::GrossErrors:
      break;
  }
  return "gross errors";
}

json::object method_json(const MethodResult& method) {
  json::object object{{"method", method.method},
                      {"data", name_of(method.data)},
                      {"validation", nullptr},
                      {"quartiles", nullptr},
                      {"rmse_over_bound", nullptr},
                      {"converged", method.converged},
                      {"iterations", method.iterations},
                      {"time_s", method.time_s},
                      {"convergence", json::value_from(method.convergence_mm)},
                      {"errors", json::value_from(method.errors_mm)}};
  if (method.converged > 0) {
    object["validation"] = record::statistics_json(method.validation);
    object["quartiles"] = {method.quartiles.lower, method.quartiles.median, method.quartiles.upper};
    if (method.data != TrialData::NoiseFree) object["rmse_over_bound"] = method.rmse_over_bound;
  }
  if (method.data == TrialData::GrossErrors)
    object["within_2_percent_of_oracle"] = method.within_2_percent_of_oracle;
  return object;
}

json::object design_json(const DesignResult& design) {
  return {{"design", design.design}, {"poses", design.poses}, {"rms", design.rms_mm}, {"max", design.max_mm}};
}

json::object layer_json(const LayerResult& layer) {
  return {{"layer", layer.layer},
          {"rigid", layer.rigid},
          {"poses", layer.poses},
          {"backlash_deg", layer.backlash_deg},
          {"validation", record::statistics_json(layer.validation)},
          {"model_rms", layer.model_rms_mm}};
}

json::object published_json(const PublishedComparison& pair) {
  return {{"figure", pair.figure},
          {"source", pair.source},
          {"published_mean", pair.published_mean_mm},
          {"mean", pair.mean_mm},
          {"explanation", pair.explanation}};
}

template <typename Row>
json::array rows_json(const std::vector<Row>& rows, json::object (*row_json)(const Row&)) {
  json::array array;
  for (const Row& row : rows) array.push_back(row_json(row));
  return array;
}

}  // namespace

json::object experiment_document(const ExperimentOptions& options, const ExperimentResult& result) {
  return {{"seed", options.seed},
          {"trials", options.trials},
          {"noise", noise_json(options)},
          {"bound_rms", result.bound_rms_mm},
          {"methods", rows_json(result.methods, method_json)},
          {"designs", rows_json(result.designs, design_json)},
          {"layers", rows_json(result.layers, layer_json)},
          {"published", rows_json(result.published, published_json)}};
}

}  // namespace truepose::tools
