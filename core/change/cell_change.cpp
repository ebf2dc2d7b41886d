#include "core/change/cell_change.hpp"

#include <algorithm>
#include <iterator>

#include "core/math/angles.hpp"
#include "core/math/rigid_fit.hpp"

namespace truepose {

namespace {

constexpr double kThousandth = 1e-3;

PossibleChange change_of(ChangeKind kind, int index, int first_parameter, int parameters) {
  PossibleChange change{{kind, index}, first_parameters(parameters)};
  for (int& parameter : change.free) parameter += first_parameter;
  return change;
}

/// Of the base's, the reflectors' and the links' parameters.
bool is_angle(const ParameterLayout& layout, int parameter) {
  if (parameter < layout.reflector(0)) return parameter % ParameterLayout::kBase >= 3;
  if (parameter < layout.link(0)) return false;
  const int entry = (parameter - layout.link(0)) % ParameterLayout::kLink;
  return entry != ParameterLayout::kA && entry != ParameterLayout::kD;
}

Eigen::MatrixXd directions_of(const PossibleChange& change, const CalibratedCell& cell) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  if (change.what.kind == ChangeKind::Reading) return Eigen::MatrixXd::Zero(layout.size(), 3);
  if (change.what.kind == ChangeKind::Growth) {
    Eigen::MatrixXd lengths = Eigen::MatrixXd::Zero(layout.size(), 1);
    lengths(change.free, 0) = kThousandth * parameter_values(cell)(change.free);
    return lengths;
  }
  Eigen::MatrixXd directions =
      Eigen::MatrixXd::Zero(layout.size(), static_cast<Eigen::Index>(change.free.size()));
  for (Eigen::Index k = 0; k < directions.cols(); ++k) {
    const int parameter = change.free[static_cast<std::size_t>(k)];
    directions(parameter, k) = is_angle(layout, parameter) ? kThousandth : 1;
  }
  return directions;
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

Eigen::MatrixXd directions_of(std::span<const PossibleChange> changes, const CalibratedCell& cell) {
  Eigen::MatrixXd all(ParameterLayout::of(cell).size(), 0);
  for (const PossibleChange& change : changes) {
    const Eigen::MatrixXd directions = directions_of(change, cell);
    all.conservativeResize(Eigen::NoChange, all.cols() + directions.cols());
    all.rightCols(directions.cols()) = directions;
  }
  return all;
}

Eigen::VectorXd units_of(const PossibleChange& change, const CalibratedCell& cell) {
  if (change.what.kind == ChangeKind::Reading) return Eigen::Vector3d::Ones();
  if (change.what.kind == ChangeKind::Growth) return Eigen::VectorXd::Constant(1, kThousandth);
  return directions_of({&change, 1}, cell).colwise().sum();
}

}  // namespace truepose
