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

namespace {

/// Values and standard deviations of the parameters that are another now.
void update_parameters(ModelFile& model) {
  const std::vector<std::string> names = parameter_names(model.cell);
  const Eigen::VectorXd values = parameter_values(model.cell);
  for (IdentifiedParameter& parameter : model.parameters) {
    const auto index = std::ranges::find(names, parameter.name) - names.begin();
    if (index == values.size() || parameter.value == values[index]) continue;
    parameter.value = values[index];
    if (model.covariance.size() > 0) parameter.sigma = std::sqrt(model.covariance(index, index));
    parameter.identified = true;
  }
}

}  // namespace

ModelFile seen_from(ModelFile model, const Eigen::Isometry3d& X_now_first) {
  if (X_now_first.matrix() == Eigen::Matrix4d::Identity()) return model;
  model.cell.base = BasePose::of(X_now_first * model.cell.base.isometry());
  for (ValidationPoint& point : model.validation) point.p_WS_mm = X_now_first * point.p_WS_mm;
  if (model.covariance.size() > 0) {
    // Position and rotation of the base are given along the tracker's axes.
    const Eigen::Matrix3d R = X_now_first.linear();
    for (const Eigen::Index block : {0, 3}) {
      model.covariance.middleRows<3>(block) = (R * model.covariance.middleRows<3>(block)).eval();
      model.covariance.middleCols<3>(block) = (model.covariance.middleCols<3>(block) * R.transpose()).eval();
    }
  }
  update_parameters(model);
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
  update_parameters(model);
  return model;
}

}  // namespace truepose::config
