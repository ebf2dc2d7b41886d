#include "core/change/cell_change.hpp"

#include <algorithm>
#include <iterator>

#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/math/rigid_fit.hpp"

namespace truepose {

namespace {

PossibleChange change_of(ChangeKind kind, int index, int first_parameter, int parameters) {
  PossibleChange change{{kind, index}, first_parameters(parameters)};
  for (int& parameter : change.free) parameter += first_parameter;
  return change;
}

}  // namespace

bool shows(const Measurement& point, const Change& change) {
  if (change.kind == ChangeKind::Base) return point.station == change.index;
  return change.kind != ChangeKind::Reflector || point.smr == change.index;
}

std::vector<PossibleChange> bases_of(const CalibratedCell& cell) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  std::vector<PossibleChange> all;
  for (int s = 0; s < layout.stations; ++s)
    all.push_back(change_of(ChangeKind::Base, s, layout.base(s), ParameterLayout::kBase));
  return all;
}

std::vector<PossibleChange> reflectors_of(const CalibratedCell& cell) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  std::vector<PossibleChange> all;
  for (int k = 0; k < layout.reflectors; ++k)
    all.push_back(change_of(ChangeKind::Reflector, k, layout.reflector(k), ParameterLayout::kReflector));
  return all;
}

std::vector<PossibleChange> joint_zeros_of(const CalibratedCell& cell) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  std::vector<PossibleChange> all;
  for (int i = 0; i < layout.joints; ++i)
    all.push_back(change_of(ChangeKind::JointZero, i, zero_parameter(cell.robot, layout, i), 1));
  return all;
}

PossibleChange all_zeros_of(const CalibratedCell& cell) {
  PossibleChange zeros{{ChangeKind::AllZeros}, {}};
  for (const PossibleChange& of_joint : joint_zeros_of(cell)) zeros.free.push_back(of_joint.free.front());
  return zeros;
}

PossibleChange growth_of(const CalibratedCell& cell) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  PossibleChange growth{{ChangeKind::Growth}, {}};
  for (int i = 0; i < layout.joints; ++i)
    growth.free.insert(growth.free.end(),
                       {layout.link(i) + ParameterLayout::kA, layout.link(i) + ParameterLayout::kD});
  return growth;
}

std::vector<PossibleChange> link_parameters_of(const CalibratedCell& cell) {
  using enum ParameterLayout::LinkEntry;
  const ParameterLayout layout = ParameterLayout::of(cell);
  std::vector<PossibleChange> all;
  for (int i = 1; i < layout.joints; ++i) {
    const bool turns = cell.robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
    std::vector<int> entries{kA, kAlpha, kBeta};
    if (turns && i + 1 < layout.joints) entries.push_back(kD);
    for (const int entry : entries) {
      const int parameter = layout.link(i) + entry;
      all.push_back(change_of(ChangeKind::Link, parameter, parameter, 1));
    }
  }
  return all;
}

std::vector<PossibleChange> wrong_readings(std::span<const Measurement> points) {
  constexpr std::size_t kFewestToOutvote = 3;  // of which two may call the third wrong
  std::vector<PossibleChange> all;
  if (points.size() < kFewestToOutvote) return all;
  for (std::size_t n = 0; n < points.size(); ++n)
    all.push_back({{ChangeKind::Reading, static_cast<int>(n)}, {}});
  return all;
}

std::vector<PossibleChange> shown_changes(const CalibratedCell& cell, std::span<const Measurement> points) {
  std::vector<PossibleChange> all;
  for (const auto& changes : {bases_of(cell), reflectors_of(cell), joint_zeros_of(cell)}) {
    std::ranges::copy_if(changes, std::back_inserter(all), [&](const PossibleChange& change) {
      return std::ranges::any_of(points, [&](const Measurement& point) { return shows(point, change.what); });
    });
  }
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

Eigen::VectorXd moved_between(const CalibratedCell& from, const CalibratedCell& to, const Change& change) {
  const auto index = static_cast<std::size_t>(change.index);
  if (change.kind == ChangeKind::Base) {
    const BasePose &before = from.base_at(change.index), &after = to.base_at(change.index);
    Eigen::VectorXd moved(6);
    moved << after.p_mm - before.p_mm, turn_between(before.isometry().linear(), after.isometry().linear());
    return moved;
  }
  if (change.kind == ChangeKind::Reflector)
    return to.reflectors[index].p_FS_mm - from.reflectors[index].p_FS_mm;
  const Joint &before = from.robot.joints[index], &after = to.robot.joints[index];
  const double way =
      before.type == JointType::Revolute ? after.theta_rad - before.theta_rad : after.d_mm - before.d_mm;
  return Eigen::VectorXd::Constant(1, before.sign * way);
}

std::string described(const Change& change, const Eigen::VectorXd& moved, const CalibratedCell& cell,
                      std::span<const Measurement> points) {
  const auto at = static_cast<std::size_t>(change.index);
  switch (change.kind) {
    case ChangeKind::Base:
      return formatted("the tracker or the base moved by %.2f mm and %.4f deg", moved.head<3>().norm(),
                       moved.tail<3>().norm() * kDegPerRad);
    case ChangeKind::Reflector:
      return "reflector '" + cell.reflectors[at].name + "' moved on the flange by " +
             formatted("%.2f mm", moved.norm());
    case ChangeKind::JointZero:
      return "axis " + std::to_string(change.index + 1) + "'s zero moved by " +
             (cell.robot.joints[at].type == JointType::Revolute ? formatted("%.4f deg", moved[0] * kDegPerRad)
                                                                : formatted("%.3f mm", moved[0]));
    case ChangeKind::Growth:
      return formatted("all lengths of the arm grew by %.0f ppm", 1e6 * moved[0]);
    case ChangeKind::AllZeros:
      return "the joints were mastered again";
    case ChangeKind::Load:
      return "the load on the flange changed";
    case ChangeKind::Link:
      return parameter_names(cell)[at] + " changed";
    case ChangeKind::Reading: {
      const int row = points[at].row > 0 ? points[at].row : change.index + 1;
      return "the reading of point " + std::to_string(row) + " alone is off by " +
             formatted("%.2f mm", moved.norm());
    }
  }
  return {};
}

}  // namespace truepose
