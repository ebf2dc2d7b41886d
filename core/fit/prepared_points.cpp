#include "core/fit/prepared_points.hpp"

#include <algorithm>
#include <cassert>

#include "core/arm/arm_kernel.hpp"
#include "core/arm/guide.hpp"
#include "core/arm/joint_coupling.hpp"
#include "core/arm/joint_deviation.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr int kLanes = kernels::kMostLanes;

int padded(int count) { return (count + kLanes - 1) / kLanes * kLanes; }

bool is_weight(const Eigen::Matrix3d& W) { return W == W(0, 0) * Eigen::Matrix3d::Identity(); }

/// U, upper triangular, with U'U = W'W: the same to a sum of squares.
Eigen::Matrix3d triangular(const Eigen::Matrix3d& W) {
  return is_weight(W) ? W : Eigen::Matrix3d{cholesky(W.transpose() * W).transpose()};
}

}  // namespace

PreparedPoints::PreparedPoints(const RobotModel& robot, std::span<const Measurement> points, int reflectors,
                               std::span<const Eigen::Matrix3d> W, const kernels::Kernels& code)
    : code_{&code}, reflectors_{reflectors} {
  const auto guided = guided_joints(robot);
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    links_.push_back(robot.joints[i].type);
    if (!guided[i]) continue;
    for (const GuideMotion& motion : kGuideMotions) links_.push_back(link_of_motion(motion).type);
  }
  int stations = 1;
  for (const Measurement& point : points) stations = std::max(stations, point.station + 1);
  std::vector<int> count(group(stations, 0), 0);
  for (const Measurement& point : points) ++count[group(point.station, point.smr)];
  int end = 0;
  for (const int each : count) {
    begin_.push_back(end);
    end += padded(each);
  }
  begin_.push_back(end);
  place_.reserve(points.size());
  std::vector<int> next = begin_;
  for (const Measurement& point : points) place_.push_back(next[group(point.station, point.smr)]++);

  row_lines_ = end / kLanes;
  const int rows = basis_row(static_cast<int>(robot.deviation.size()));
  lines_.assign(static_cast<std::size_t>(rows * row_lines_ + 1), {});
  const LinkNumbers number(robot);
  for (std::size_t n = 0; n < points.size(); ++n) {
    for (int axis = 0; axis < 3; ++axis) row(kX + axis)[place_[n]] = points[n].p_WS_mm[axis];
    const JointVector q_chain = chain_joints(robot.coupling, points[n].q);
    for (int i = 0; i < robot.joint_count(); ++i) {
      row(reading_row(number.of_joint(i)))[place_[n]] =
          robot.joints[static_cast<std::size_t>(i)].sign * q_chain[i];
    }
  }
  place_bases(robot, points);
  deviate(robot);
  reweight(W);
}

void PreparedPoints::place_bases(const RobotModel& robot, std::span<const Measurement> points) {
  std::vector<double> basis(robot.deviation.size());
  LoadedArm arm(robot);
  for (std::size_t n = 0; n < points.size() && !basis.empty(); ++n) {
    deviation_basis(arm.at(points[n]), points[n].q, points[n].direction, basis);
    for (std::size_t t = 0; t < basis.size(); ++t) {
      const DeviationTerm& term = robot.deviation[t];
      const bool of_guide = guide_motion(term.basis) >= 0;
      const double sign = of_guide ? 1 : robot.joints[static_cast<std::size_t>(term.joint)].sign;
      row(basis_row(static_cast<int>(t)))[place_[n]] = sign * basis[t];
    }
  }
}

void PreparedPoints::deviate(const RobotModel& robot) {
  const auto same = [](double coefficient, const DeviationTerm& term) {
    return coefficient == term.coefficient;
  };
  if (placed_ && std::ranges::equal(coefficients_, robot.deviation, same)) return;
  placed_ = true;
  coefficients_.clear();
  const int count = begin_.back();
  for (int i = 0; i < link_count(); ++i) {
    std::copy_n(row(reading_row(i)), count, row(first_row(i)));
  }
  const LinkNumbers number(robot);
  for (const DeviationTerm& term : robot.deviation) {
    const double* const basis = row(basis_row(static_cast<int>(coefficients_.size())));
    double* const moved = row(first_row(number.of(term)));
    for (int k = 0; k < count; ++k) moved[k] += term.coefficient * basis[k];
    coefficients_.push_back(term.coefficient);
  }
  for (int i = 0; i < link_count(); ++i) {
    if (links_[static_cast<std::size_t>(i)] == JointType::Prismatic) continue;
    double* const angle = row(first_row(i));
    code_->sincos(angle, row(second_row(i)), angle, count);
  }
}

void PreparedPoints::reweight(std::span<const Eigen::Matrix3d> W) {
  assert(W.empty() || static_cast<int>(W.size()) == size());
  whitened_ = !std::ranges::all_of(W, is_weight);
  for (std::size_t n = 0; n < place_.size(); ++n) {
    row(kWeight)[place_[n]] = W.empty() ? 1.0 : W[n](0, 0);
    if (!whitened_) continue;
    const Eigen::Matrix3d U = triangular(W[n]);
    int entry = kWhitening;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) row(entry++)[place_[n]] = U(i, j);
  }
}

kernels::PointBlock PreparedPoints::of(int station, int reflector) const {
  const int begin = begin_[group(station, reflector)];
  const int end = begin_[group(station, reflector) + 1];
  kernels::PointBlock block{.measured = {row(kX) + begin, row(kY) + begin, row(kZ) + begin},
                            .weight = row(kWeight) + begin,
                            .whitening = {},
                            .basis = row(basis_row(0)) + begin,
                            .first = row(first_row(0)) + begin,
                            .second = row(second_row(0)) + begin,
                            .stride = row_lines_ * kLanes,
                            .count = end - begin};
  for (int i = 0; whitened_ && i < 6; ++i) block.whitening[i] = row(kWhitening + i) + begin;
  return block;
}

kernels::LinkColumn link_column(const RobotModel& robot, const ParameterLayout& layout, int parameter) {
  const LinkNumbers number(robot);
  if (parameter < layout.deviation(0)) {
    const int of_links = parameter - layout.link(0);
    return {static_cast<kernels::ColumnKind>(of_links % ParameterLayout::kLink),
            number.of_joint(of_links / ParameterLayout::kLink)};
  }
  const int place = parameter - layout.deviation(0);
  const DeviationTerm& term = robot.deviation[static_cast<std::size_t>(place)];
  return {moves_along(robot, term) ? kernels::ColumnKind::D : kernels::ColumnKind::Theta, number.of(term),
          place};
}

PreparedModel::PreparedModel(const CalibratedCell& cell, const std::vector<kernels::LinkColumn>& columns)
    : arm{folded_with_guides(cell.robot)},
      model{.arm = &arm, .columns = columns.data(), .column_count = static_cast<int>(columns.size())} {}

const kernels::PointModel& PreparedModel::of(const Eigen::Isometry3d& X_WB, const Reflector& reflector) {
  Eigen::Map<Eigen::Matrix3d>(model.rotation) = X_WB.linear();
  Eigen::Map<Eigen::Vector3d>(model.origin) = X_WB.translation();
  Eigen::Map<Eigen::Vector3d>(model.reflector) = reflector.p_FS_mm;
  return model;
}

}  // namespace truepose
