#include "core/calibration/identification.hpp"
#include "core/compensation/regression_field.hpp"

namespace truepose {
namespace {

/// The best of several kinds where it helps; a single one whether it helps or not.
std::expected<RegressorSelection, std::string> choose_regressor(const RegressionData& data,
                                                                const std::vector<RegressorKind>& kinds) {
  auto selection = select_regressor(data, kinds);
  if (!selection || selection->regressor || kinds.size() > 1) return selection;
  auto asked = fit_regressor(kinds.front(), data);
  if (!asked) return std::unexpected(asked.error());
  selection->kind = kinds.front();
  selection->regressor = std::move(*asked);
  return selection;
}

}  // namespace

std::optional<CalibrationError> fit_residual(Identification& id) {
  const FieldData data = field_data(id.fit.cell, id.points.trusted_points());
  auto selection = choose_regressor(data.regression, id.options.residual);
  if (!selection)
    return CalibrationError{CalibrationFault::TooFewPoses, "residual field: " + selection.error()};
  if (selection->regressor) {
    id.fit.cell.robot.field =
        std::make_shared<RegressionField>(id.fit.cell.robot, selection->regressor, data.p_F_mm);
  }
  id.result.residual = std::move(*selection);
  return std::nullopt;
}

}  // namespace truepose
