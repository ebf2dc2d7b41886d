#include "core/arm/pose_check.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

using Eigen::Isometry3d, Eigen::VectorXd;

constexpr double kMmPerRad = 1000;

/// The explanation with parameters applied to it, all 0 for none.
using Applied = std::function<PoseExplanation(const VectorXd&)>;

VectorXd residuals(const PoseExplanation& e, std::span<const PoseReading> readings) {
  VectorXd r(static_cast<Eigen::Index>(6 * readings.size()));
  Eigen::Index at = 0;
  for (const PoseReading& reading : readings) {
    const Isometry3d X = e.X_base * forward_kinematics(e.fixed, reading.q);
    r.segment<3>(at) = X.translation() - reading.X_BF.translation();
    r.segment<3>(at + 3) = kMmPerRad * turn_between(reading.X_BF.linear(), X.linear());
    at += 6;
  }
  return r;
}

double rms_of(const VectorXd& r) { return r.norm() / std::sqrt(static_cast<double>(r.size()) / 6); }

/// Gauss-Newton over a few parameters in mm and mrad, which starts near enough: what is far is a quarter
/// turn.
PoseExplanation fitted(const Applied& apply, Eigen::Index parameters, std::span<const PoseReading> readings) {
  constexpr double kStep = 1e-3;
  VectorXd p = VectorXd::Zero(parameters);
  VectorXd r = residuals(apply(p), readings);
  for (int iteration = 0; iteration < 8 && parameters > 0; ++iteration) {
    Eigen::MatrixXd J(r.size(), parameters);
    for (Eigen::Index i = 0; i < parameters; ++i) {
      VectorXd ahead = p, behind = p;
      ahead[i] += kStep;
      behind[i] -= kStep;
      J.col(i) = (residuals(apply(ahead), readings) - residuals(apply(behind), readings)) / (2 * kStep);
    }
    const VectorXd next = p - smallest_solution(J, r, 1e-9), r_next = residuals(apply(next), readings);
    if (!(r_next.norm() < r.norm())) break;
    p = next;
    r = r_next;
  }
  PoseExplanation e = apply(p);
  e.rms_mm = rms_of(r);
  return e;
}

Isometry3d small_pose(const VectorXd& p) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = rotation_by(Eigen::Vector3d{p.tail<3>() / kMmPerRad});
  X.translation() = p.head<3>();
  return X;
}

/// The best of a row's signs and quarter turns.
PoseExplanation with_other_row(const RobotModel& robot, int joint, std::span<const PoseReading> readings) {
  PoseExplanation best;
  best.rms_mm = std::numeric_limits<double>::infinity();
  for (const double sign : {1.0, -1.0}) {
    for (int quarters = 0; quarters < 4; ++quarters) {
      const Applied apply = [&](const VectorXd& p) {
        PoseExplanation e{.joint = joint, .fixed = robot};
        Joint& row = e.fixed.joints[static_cast<std::size_t>(joint)];
        row.sign *= sign;
        row.a_mm += p[0];
        row.d_mm += p[1];
        row.alpha_rad += p[2] / kMmPerRad;
        row.theta_rad = std::remainder(row.theta_rad + quarters * std::numbers::pi / 2 + p[3] / kMmPerRad,
                                       2 * std::numbers::pi);
        return e;
      };
      PoseExplanation e = fitted(apply, 4, readings);
      // A sign that was not needed is none.
      if (e.rms_mm < 0.5 * best.rms_mm) best = std::move(e);
    }
  }
  return best;
}

}  // namespace

std::vector<PoseDifference> differences_of(const RobotModel& robot, std::span<const PoseReading> readings) {
  std::vector<PoseDifference> differences;
  for (const PoseReading& reading : readings) {
    const Isometry3d X = forward_kinematics(robot, reading.q);
    differences.push_back({(X.translation() - reading.X_BF.translation()).norm(),
                           angle_between(X.linear(), reading.X_BF.linear())});
  }
  return differences;
}

std::vector<PoseExplanation> explain_differences(const RobotModel& robot,
                                                 std::span<const PoseReading> readings) {
  using Place = PoseExplanation::Place;
  std::vector<PoseExplanation> found;
  for (int joint = 1; joint < robot.joint_count(); ++joint) {
    for (const double factor : {1.0, -1.0}) {
      const Applied apply = [&](const VectorXd&) {
        PoseExplanation e{.place = Place::Coupling, .joint = joint, .fixed = robot};
        e.fixed.coupling.push_back({joint, joint - 1, factor});
        return e;
      };
      found.push_back(fitted(apply, 0, readings));
    }
  }
  for (int joint = 0; joint < robot.joint_count(); ++joint)
    found.push_back(with_other_row(robot, joint, readings));
  found.push_back(fitted(
      [&](const VectorXd& p) {
        PoseExplanation e{.place = Place::Flange, .fixed = robot};
        e.fixed.X_flange = robot.X_flange * small_pose(p);
        return e;
      },
      6, readings));
  found.push_back(fitted(
      [&](const VectorXd& p) {
        return PoseExplanation{.place = Place::Base, .fixed = robot, .X_base = small_pose(p)};
      },
      6, readings));
  const double as_it_is = rms_of(residuals({.fixed = robot}, readings));
  std::ranges::stable_sort(found, {}, &PoseExplanation::rms_mm);
  const double most = std::min(as_it_is / 3, 2 * found.front().rms_mm + 1e-6);
  std::erase_if(found, [&](const PoseExplanation& e) { return !(e.rms_mm <= most); });
  return found;
}

}  // namespace truepose
