#include "core/fit/placement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>

#include "core/calibrate/calibrate.hpp"
#include "core/formatted.hpp"
#include "core/math/units.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_paths.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

using Nine = Eigen::Vector<double, 9>;
using Normal = Eigen::Matrix<double, 9, 9>;

/// Where a base and one reflector might be, m.
struct Place {
  Eigen::Matrix3d R;
  Eigen::Vector3d base, reflector;

  Place moved(const Nine& step) const {
    const Eigen::Vector3d turn = step.head<3>();
    const Eigen::AngleAxisd turned(turn.norm(), turn.normalized());
    return {turned * R, base + step.segment<3>(3), reflector + step.tail<3>()};
  }
};

/// The flange by a product of the links of its own, m.
Eigen::Affine3d flange_at(const RobotModel& robot, const JointVector& q) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), z = Eigen::Vector3d::UnitZ();
  Eigen::Affine3d X = Eigen::Affine3d::Identity();
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    const double moved = joint.sign * q[static_cast<Eigen::Index>(i)];
    const bool turns = joint.type == JointType::Revolute;
    X = X * Eigen::AngleAxisd(joint.alpha_rad, x) * Eigen::Translation3d(joint.a_mm / 1000 * x) *
        Eigen::AngleAxisd(joint.theta_rad + (turns ? moved : 0), z) *
        Eigen::Translation3d((joint.d_mm + (turns ? 0 : moved)) / 1000 * z);
  }
  return X;
}

/// The best of Levenberg and Marquardt's descents from random places, by numeric derivatives.
class Searched {
 public:
  Searched(const RobotModel& robot, const MeasurementData& data, int starts, Random& random) {
    for (const Measurement& point : data.points) {
      flange_.push_back(flange_at(robot, point.q));
      seen_.push_back(point.p_WS_mm / 1000);
    }
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < starts; ++i) {
      const Place found = descended(random_place(random));
      const double cost = misses(found).squaredNorm();
      if (cost >= least) continue;
      least = cost;
      best_ = found;
    }
  }

  double rms_mm() const { return 1000 * misses(best_).norm() / std::sqrt(3.0 * points()); }

  /// Of the base's turn about the axis that the points show least, with what is left as noise.
  double turn_sigma() const {
    constexpr double kReflectorSigma_m = 100;
    const double noise_m = std::max(rms_mm(), 0.01) / 1000;
    const Eigen::MatrixXd J = derivatives(best_, misses(best_));
    Normal A = J.transpose() * J;
    A.diagonal().tail<3>().array() += std::pow(noise_m / kReflectorSigma_m, 2);
    const Eigen::MatrixXd others = A.bottomRightCorner<6, 6>(), mixed = A.bottomLeftCorner<6, 3>();
    const Eigen::Matrix3d known = A.topLeftCorner<3, 3>() - mixed.transpose() * others.ldlt().solve(mixed);
    const double least = known.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
    return least > 0 ? noise_m / std::sqrt(least) : std::numeric_limits<double>::infinity();
  }

 private:
  double points() const { return static_cast<double>(seen_.size()); }

  Place random_place(Random& random) const {
    const auto spread = [&](double by) {
      const double x = random.uniform(-by, by), y = random.uniform(-by, by), z = random.uniform(-by, by);
      return Eigen::Vector3d(x, y, z);
    };
    const Place any{Eigen::Matrix3d::Identity(), seen_[0] + spread(3), spread(0.5)};
    Nine turn = Nine::Zero();
    turn.head<3>() = spread(std::numbers::pi);
    return any.moved(turn);
  }

  Eigen::VectorXd misses(const Place& place) const {
    Eigen::VectorXd f(3 * static_cast<Eigen::Index>(seen_.size()));
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      f.segment<3>(3 * static_cast<Eigen::Index>(k)) =
          place.R * (flange_[k] * place.reflector) + place.base - seen_[k];
    }
    return f;
  }

  Eigen::MatrixXd derivatives(const Place& place, const Eigen::VectorXd& here) const {
    constexpr double kStep = 1e-7;
    Eigen::MatrixXd J(here.size(), 9);
    for (int k = 0; k < 9; ++k) J.col(k) = (misses(place.moved(kStep * Nine::Unit(k))) - here) / kStep;
    return J;
  }

  Place descended(Place place) const {
    constexpr int kMostSteps = 200;
    double damping = 1e-3;
    Eigen::VectorXd f = misses(place);
    for (int i = 0; i < kMostSteps && damping < 1e8; ++i) {
      const Eigen::MatrixXd J = derivatives(place, f);
      Normal A = J.transpose() * J;
      A.diagonal() += damping * (A.diagonal() + Nine::Constant(1e-9));
      const Place next = place.moved(-A.ldlt().solve(J.transpose() * f));
      const Eigen::VectorXd next_f = misses(next);
      const double gained = f.squaredNorm() - next_f.squaredNorm();
      damping = gained > 0 ? std::max(damping / 5, 1e-12) : damping * 5;
      if (!(gained > 0)) continue;
      place = next;
      f = next_f;
      if (gained < 1e-9 * f.squaredNorm()) break;
    }
    return place;
  }

  std::vector<Eigen::Affine3d> flange_;
  std::vector<Eigen::Vector3d> seen_;
  Place best_;
};

double rms_mm(const CalibratedCell& cell, const MeasurementData& data) {
  double sum = 0;
  for (const Measurement& m : data.points) sum += (cell.predict(m.q, m.smr) - m.p_WS_mm).squaredNorm();
  return std::sqrt(sum / (3.0 * static_cast<double>(data.points.size())));
}

class CoarseFitOnPaths : public testing::TestWithParam<RobotModel> {};

TEST_P(CoarseFitOnPaths, IsTheBestThatRandomStartsFindOrTellsThatTheBasesTurnIsOpen) {
  const RobotModel& nominal = GetParam();
  const int starts = all_trials() ? 500 : 10;
  int refused = 0, cases = 0;
  for (const example::Path path : example::kPaths) {
    for (const double turn_deg : {0.0, 0.01, 0.1, 1.0, 5.0}) {
      for (int trial = 0; trial < trials(40); ++trial) {
        Random random{static_cast<std::uint64_t>(trial)};
        const CalibratedCell truth = example::placed(example::deviating(nominal, random, 0.5, 1e-3), random);
        const auto poses = example::along(nominal, path, 30, turn_deg * kRadPerDeg, random);
        const MeasurementData data = example::measured(truth, poses, example::kSigma_mm, random);
        const Searched best(nominal, data, starts, random);
        const auto fit = coarse_fit(nominal, data);
        const std::string where =
            formatted("%s, %s, %.2f deg, seed %d", nominal.name.c_str(), name_of(path), turn_deg, trial);
        ++cases;
        if (fit) {
          EXPECT_LT(rms_mm(*fit, data), 1.001 * best.rms_mm()) << where;
          EXPECT_LT(best.turn_sigma(), 0.11) << where;
        } else {
          ++refused;
          EXPECT_EQ(fit.error().fault, CalibrationFault::NotSeparable) << where;
          EXPECT_GT(best.turn_sigma(), 0.09) << where;
        }
      }
    }
  }
  std::cout << nominal.name << ": " << refused << " of " << cases << " leave the base's turn open\n";
}

TEST_P(CoarseFitOnPaths, LeadsToAModelThatIsBetterThanTheNominalArmBetweenItsPoses) {
  const RobotModel& nominal = GetParam();
  for (const example::Path path : example::kPaths) {
    for (const double turn_deg : {0.0, 0.01, 0.1, 1.0, 5.0}) {
      for (int trial = 0; trial < trials(20); ++trial) {
        Random random{1000 + static_cast<std::uint64_t>(trial)};
        const CalibratedCell truth = example::placed(example::deviating(nominal, random, 0.5, 1e-3), random);
        const auto poses = example::along(nominal, path, 60, turn_deg * kRadPerDeg, random);
        MeasurementData data = example::measured(truth, poses, example::kSigma_mm, random);
        for (std::size_t k = 1; k < data.points.size(); k += 2) data.points[k].set = PoseSet::Validate;
        const auto result = calibrate(nominal, data);
        const std::string where = formatted("%s, %s, %.2f deg, seed %d", nominal.name.c_str(), name_of(path),
                                            turn_deg, 1000 + trial);
        if (result) {
          EXPECT_LT(result->validate->after.mean, result->validate->before.mean) << where;
        } else {
          EXPECT_EQ(result.error().fault, CalibrationFault::NotSeparable)
              << where << ": " << result.error().detail;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfArms, CoarseFitOnPaths,
                         testing::Values(example::kr210(), example::ur10(), example::seven_axis(),
                                         example::kr210_on_a_rail(), example::scara()),
                         [](const auto& arm) { return "Arm" + std::to_string(arm.index); });

}  // namespace
}  // namespace truepose
