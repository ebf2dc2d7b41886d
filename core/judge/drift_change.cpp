#include "core/judge/drift_change.hpp"

#include <algorithm>

#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/math/rigid_fit.hpp"

namespace truepose {

std::vector<PossibleChange> changes_of_cell(const CalibratedCell& cell, std::span<const Measurement> points) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  std::vector<PossibleChange> all{{DriftCauseKind::Base, 0, {0, 1, 2, 3, 4, 5}}};
  for (int k = 0; k < layout.reflectors; ++k) {
    if (std::ranges::find(points, k, &Measurement::smr) == points.end()) continue;
    const int first = layout.reflector(k);
    all.push_back({DriftCauseKind::Reflector, k, {first, first + 1, first + 2}});
  }
  for (int i = 0; i < layout.joints; ++i)
    all.push_back({DriftCauseKind::JointZero, i, {zero_parameter(cell.robot, layout, i)}});
  return all;
}

PossibleChange growth_of(const CalibratedCell& cell) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  PossibleChange growth{DriftCauseKind::Growth, 0, {}};
  for (int i = 0; i < layout.joints; ++i)
    growth.free.insert(growth.free.end(), {layout.link(i), layout.link(i) + 2});  // a and d
  return growth;
}

std::vector<PossibleChange> wrong_readings(std::span<const Measurement> points) {
  constexpr std::size_t kFewestToOutvote = 3;  // of which two may call the third wrong
  std::vector<PossibleChange> all;
  if (points.size() < kFewestToOutvote) return all;
  for (std::size_t n = 0; n < points.size(); ++n)
    all.push_back({DriftCauseKind::Reading, static_cast<int>(n), {}});
  return all;
}

CalibratedCell with_fitted_base(const CalibratedCell& cell, std::span<const Measurement> points) {
  std::vector<Eigen::Vector3d> predicted, measured;
  for (const Measurement& point : points) {
    predicted.push_back(cell.predict(point));
    measured.push_back(point.p_WS_mm);
  }
  CalibratedCell fitted = cell;
  if (const auto X = rigid_fit(predicted, measured)) fitted.base = BasePose::of(*X * cell.base.isometry());
  return fitted;
}

Eigen::VectorXd moved_between(const CalibratedCell& from, const CalibratedCell& to,
                              const PossibleChange& change) {
  const auto index = static_cast<std::size_t>(change.index);
  if (change.kind == DriftCauseKind::Base) {
    Eigen::VectorXd moved(6);
    moved << to.base.p_mm - from.base.p_mm,
        turn_between(from.base.isometry().linear(), to.base.isometry().linear());
    return moved;
  }
  if (change.kind == DriftCauseKind::Reflector)
    return to.reflectors[index].p_FS_mm - from.reflectors[index].p_FS_mm;
  const Joint &before = from.robot.joints[index], &after = to.robot.joints[index];
  const double way =
      before.type == JointType::Revolute ? after.theta_rad - before.theta_rad : after.d_mm - before.d_mm;
  return Eigen::VectorXd::Constant(1, before.sign * way);
}

std::string described(DriftCauseKind kind, int index, const Eigen::VectorXd& moved,
                      const CalibratedCell& cell, std::span<const Measurement> points) {
  const auto at = static_cast<std::size_t>(index);
  switch (kind) {
    case DriftCauseKind::Base:
      return formatted("the tracker or the base moved by %.2f mm and %.4f deg", moved.head<3>().norm(),
                       moved.tail<3>().norm() * kDegPerRad);
    case DriftCauseKind::Reflector:
      return "reflector '" + cell.reflectors[at].name + "' moved on the flange by " +
             formatted("%.2f mm", moved.norm());
    case DriftCauseKind::JointZero:
      return "axis " + std::to_string(index + 1) + "'s zero moved by " +
             (cell.robot.joints[at].type == JointType::Revolute ? formatted("%.4f deg", moved[0] * kDegPerRad)
                                                                : formatted("%.3f mm", moved[0]));
    case DriftCauseKind::Growth:
      return formatted("all lengths of the arm grew by %.0f ppm", 1e6 * moved[0]);
    case DriftCauseKind::Reading: {
      const int row = points[at].row > 0 ? points[at].row : index + 1;
      return "the reading of point " + std::to_string(row) + " alone is off by " +
             formatted("%.2f mm", moved.norm());
    }
  }
  return {};
}

}  // namespace truepose
