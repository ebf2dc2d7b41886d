// Rails that are not straight: what identification leaves of them. The true arm is the text book's chain of
// matrices with a carriage that errs by functions which the model does not have.

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>
#include <string>

#include "core/calibrate/calibrate.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/plain_kinematics.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

constexpr double kTravel_mm = 5000;

RobotModel kr210_on_five_metres() {
  RobotModel robot = example::kr210_on_a_rail();
  robot.joints[0].min = -kTravel_mm / 2;
  robot.joints[0].max = kTravel_mm / 2;
  return robot;
}

/// A natural cubic spline through a random point each 0.8 m.
class RandomSpline {
 public:
  RandomSpline(double sigma, Random& random) {
    const Eigen::Index n = static_cast<Eigen::Index>(kTravel_mm / kKnot_mm) + 2;
    y_.resize(n);
    for (double& y : y_) y = sigma * random.normal();
    Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    for (Eigen::Index k = 1; k + 1 < n; ++k) {
      A.row(k).segment<3>(k - 1) << 1, 4, 1;
      b[k] = 6 * (y_[k - 1] - 2 * y_[k] + y_[k + 1]);
    }
    bend_ = A.partialPivLu().solve(b);
  }
  double at(double x_mm) const {
    const double at = (x_mm + kTravel_mm / 2) / kKnot_mm;
    const auto k = static_cast<Eigen::Index>(at);
    const double t = at - std::floor(at), u = 1 - t;
    return u * y_[k] + t * y_[k + 1] + ((u * u * u - u) * bend_[k] + (t * t * t - t) * bend_[k + 1]) / 6;
  }

 private:
  static constexpr double kKnot_mm = 800;
  Eigen::VectorXd y_, bend_;
};

/// A wave that no half waves of the travel make up, and a spline; RMS `size` together.
class CarriageError {
 public:
  CarriageError(double size, Random& random)
      : amplitude_{size},  // RMS size / sqrt(2), as the spline's
        length_mm_{random.uniform(2700, 4300)},
        phase_{random.uniform(0, 2 * std::numbers::pi)},
        spline_{size / std::numbers::sqrt2, random} {}
  double at(double x_mm) const {
    return amplitude_ * std::sin(2 * std::numbers::pi * x_mm / length_mm_ + phase_) + spline_.at(x_mm);
  }

 private:
  double amplitude_, length_mm_, phase_;
  RandomSpline spline_;
};

/// An arm whose carriage is shifted across its way (mm) and turned (rad) by these.
struct TrueRail {
  CalibratedCell cell;  ///< straight
  std::vector<CarriageError> shift, turn;

  Eigen::Vector3d predict(const JointVector& q) const {
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Joint& joint = cell.robot.joints[static_cast<std::size_t>(i)];
      const bool turns = joint.type == JointType::Revolute;
      const double moved = joint.sign * q[i];
      T = T * plain::turned(1, joint.beta_rad) * plain::turned(0, joint.alpha_rad) *
          plain::shifted({joint.a_mm, 0, 0}) * plain::turned(2, joint.theta_rad + (turns ? moved : 0)) *
          plain::shifted({0, 0, joint.d_mm + (turns ? 0 : moved)});
      if (i == 0 && !shift.empty()) {
        T = T * plain::shifted({shift[0].at(q[0]), shift[1].at(q[0]), 0});
        for (int axis = 2; axis >= 0; --axis)
          T = T * plain::turned(axis, turn[static_cast<std::size_t>(axis)].at(q[0]));
      }
    }
    return cell.base.isometry() * plain::moved(T, cell.reflectors[0].p_FS_mm);
  }
};

TrueRail true_rail(double shift_mm, double turn_rad, Random& random) {
  TrueRail rail{
      example::placed(example::deviating(kr210_on_five_metres(), random, 0.5, 1e-3), random), {}, {}};
  for (int k = 0; k < 2 && shift_mm > 0; ++k) rail.shift.emplace_back(shift_mm, random);
  for (int k = 0; k < 3 && turn_rad > 0; ++k) rail.turn.emplace_back(turn_rad, random);
  return rail;
}

/// At random poses anywhere, or at so many stops along the rail.
MeasurementData rail_readings(const TrueRail& rail, int identify, int validate, int stops, Random& random) {
  MeasurementData data{.smr_names = {rail.cell.reflectors[0].name}};
  for (int k = 0; k < identify + validate; ++k) {
    Measurement point{.q = example::random_joints(rail.cell.robot, random), .row = k + 1};
    if (stops > 0) point.q[0] = kTravel_mm * (k % stops / (stops - 1.0) - 0.5);
    point.p_WS_mm = rail.predict(point.q);
    if (k < identify) {
      for (double& x : point.p_WS_mm) x += example::kSigma_mm * random.normal();
    } else {
      point.set = PoseSet::Validate;
    }
    data.points.push_back(point);
  }
  return data;
}

struct RailErrors {
  double mean = 0, max = 0;

  void add(const ErrorStatistics& of_one) {
    mean += of_one.mean;
    max = std::max(max, of_one.max);
  }
};

struct RailOutcome {
  RailErrors geometry, layers;
  double promised_mm = 0;  ///< RMS over the arms, by the transfer uncertainty
  double rms_mm = 0;
};

RailOutcome identified_rails(double shift_mm, double turn_rad, int arms, int stops = 0) {
  constexpr int kIdentify = 120, kValidate = 200;
  RailOutcome outcome;
  double squares = 0;
  for (int seed = 1; seed <= arms; ++seed) {
    Random random{static_cast<std::uint64_t>(seed)};
    const TrueRail rail = true_rail(shift_mm, turn_rad, random);
    const MeasurementData data = rail_readings(rail, kIdentify, kValidate, stops, random);
    const auto result = calibrate(kr210_on_five_metres(), data, {.non_geometric = true});
    EXPECT_TRUE(result) << result.error().detail;
    if (!result) return {};
    outcome.geometry.add(result->validate->geometric);
    outcome.layers.add(result->validate->after);
    outcome.promised_mm += result->transfer.rms_mm / arms;
    squares += result->validate->after.rms * result->validate->after.rms;
  }
  outcome.geometry.mean /= arms;
  outcome.layers.mean /= arms;
  outcome.rms_mm = std::sqrt(squares / arms);
  std::cout << arms << " arms, rail off by " << shift_mm << " mm and " << 1e3 * turn_rad << " mrad, "
            << (stops > 0 ? std::to_string(stops) + " stops" : "anywhere") << ": geometry "
            << outcome.geometry.mean << " (max " << outcome.geometry.max << "), with deviations "
            << outcome.layers.mean << " (max " << outcome.layers.max << ") mm; RMS " << outcome.rms_mm
            << ", promised " << outcome.promised_mm << "\n";
  return outcome;
}

TEST(RailGuides, ThatAreNotStraightAreIdentifiedWithTheArm) {
  const RailOutcome outcome = identified_rails(0.2, 0.08e-3, trials(100));
  EXPECT_LT(outcome.layers.mean, 0.03);
  EXPECT_GT(outcome.geometry.mean, 0.25);
  EXPECT_NEAR(outcome.rms_mm, outcome.promised_mm, 0.3 * outcome.promised_mm);
}

TEST(RailGuides, AreKnownAtTheStopsWhereAnArmWasMeasured) {
  EXPECT_LT(identified_rails(0.2, 0.08e-3, trials(100), 6).layers.mean, 0.02);
}

TEST(RailGuides, ThatAreStraightCostNothing) {
  const RailOutcome outcome = identified_rails(0, 0, trials(100));
  EXPECT_LT(outcome.layers.mean, 1.05 * outcome.geometry.mean);
}

}  // namespace
}  // namespace truepose
