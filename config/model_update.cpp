#include "config/model_update.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace truepose::config {

ModelFile at_temperatures(ModelFile model, std::span<const double> temperature_c) {
  if (!model.thermal) return model;
  const CalibratedCell cell = model.cell;
  if (model.covariance.size() > 0)
    model.covariance = covariance_at_temperatures(cell, model.covariance, *model.thermal, temperature_c);
  model.cell.robot = truepose::at_temperatures(cell.robot, *model.thermal, temperature_c);
  model.thermal = with_reference(*std::move(model.thermal), cell, temperature_c);
  return model;
}

ModelFile updated_model(const ModelFile& old, const DriftUpdate& update, std::string updates,
                        std::string created) {
  ModelFile model = old;
  model.created = std::move(created);
  model.updates = std::move(updates);
  model.cell = update.cell;
  model.covariance = update.covariance;
  model.validation_mean_mm = update.left_out_mm;
  model.validation.clear();
  model.largest_correction_deg = 0;
  const std::vector<std::string> names = parameter_names(update.cell);
  const Eigen::VectorXd values = parameter_values(update.cell);
  for (IdentifiedParameter& parameter : model.parameters) {
    const auto index = std::ranges::find(names, parameter.name) - names.begin();
    if (index == values.size() || parameter.value == values[index]) continue;
    parameter.value = values[index];
    parameter.sigma = std::sqrt(update.covariance(index, index));
    parameter.identified = true;
  }
  return model;
}

}  // namespace truepose::config
