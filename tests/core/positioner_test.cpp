#include "core/identify/positioner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>
#include <numeric>

#include "core/compensate/target_compensation.hpp"
#include "core/identify/calibrate.hpp"
#include "core/identify/tool_frame.hpp"
#include "core/judge/calibration_verdict.hpp"
#include "core/judge/model_noise.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/plain_kinematics.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;
using Matrix = Eigen::Matrix4d;

constexpr double kTracker_mm = 0.02;   // per axis
constexpr double kEccentric = 0.2e-3;  // of each gear, rad: 0.1 mm at half a metre

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

Joint table_joint(double a_mm, double alpha_deg, double d_mm, double most_deg) {
  return {.a_mm = a_mm,
          .alpha_rad = alpha_deg * kRadPerDeg,
          .d_mm = d_mm,
          .min = -most_deg * kRadPerDeg,
          .max = most_deg * kRadPerDeg,
          .speed = 1};
}

RobotModel turntable() { return {.name = "turntable", .joints = {table_joint(0, 0, 450, 185)}}; }
RobotModel tilt_and_turn() {
  return {.name = "tilt and turn", .joints = {table_joint(0, 90, 0, 90), table_joint(120, -90, 250, 185)}};
}

Eigen::Vector3d normal(Random& random, double sigma) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

Matrix rigid(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& turn_rad) {
  Matrix X = plain::shifted(p_mm);
  if (turn_rad.norm() > 0)
    X.topLeftCorner<3, 3>() = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()).toRotationMatrix();
  return X;
}

const MeasurementNoise kNoise{.tracker = {.range_mm = kTracker_mm, .transverse_mm = kTracker_mm}};

/// A KR 210 and a positioner beside it, as they truly are, by kinematics of the test's own; all that is
/// measured of them, and what is made of that.
class Cell {
 public:
  Cell(RobotModel table, std::uint64_t seed)
      : random_(seed), nominal_(std::move(table)), drawn_arm_(example::kr210()) {
    arm_ = example::placed(example::with_paper_errors(drawn_arm_), random_);
    X_WB_ = arm_.base.isometry().matrix();
    // What link 1 errs by is the base's by convention: the arm cannot tell one from the other.
    const auto first = [](const Joint& j) -> Matrix {
      return plain::turned(1, j.beta_rad) * plain::turned(0, j.alpha_rad) * plain::shifted({j.a_mm, 0, 0});
    };
    const Joint &drawn = drawn_arm_.joints[0], &real = arm_.robot.joints[0];
    X_WB_told_ = X_WB_ * first(real) * plain::turned(2, real.theta_rad - drawn.theta_rad) *
                 plain::shifted({0, 0, real.d_mm - drawn.d_mm}) * first(drawn).inverse();

    X_given_ = plain::kuka_frame({1900, 350, -150}, {25, 0, 0});
    X_root_ = X_given_ * rigid(random_.uniform(2, 4) * normal(random_, 1).normalized(),
                               random_.uniform(2e-3, 4e-3) * normal(random_, 1).normalized());
    truth_ = nominal_;
    if (truth_.joint_count() == 2) {
      truth_.joints[1].a_mm += 0.3 * random_.normal();
      truth_.joints[1].alpha_rad += 3e-4 * random_.normal();
    }
    for (double& phase : phases_) phase = random_.uniform(0, 2 * std::numbers::pi);
    X_FU_ = plain::kuka_frame({random_.uniform(-150, 150), random_.uniform(-150, 150), 80},
                              {random_.uniform(-170, 170), 3, -2});
  }

  JointVector angles() { return example::random_joints(nominal_, random_); }
  Eigen::Vector3d on_table() {
    const double angle = random_.uniform(0, 2 * std::numbers::pi), radius = random_.uniform(150, 600);
    return {radius * std::cos(angle), radius * std::sin(angle), random_.uniform(20, 350)};
  }
  /// The table in the tracker's frame.
  Matrix table_at(const JointVector& q) const {
    JointVector turned = q;
    for (Eigen::Index i = 0; i < q.size(); ++i)
      turned[i] += eccentric_ * std::sin(q[i] + phases_[static_cast<std::size_t>(i)]);
    return X_WB_told_ * X_root_ * plain::flange(truth_, turned);
  }
  Eigen::Vector3d seen(const Eigen::Vector3d& p_W_mm) { return p_W_mm + normal(random_, kTracker_mm); }

  /// Reflectors anywhere on the table, read at so many angles.
  MeasurementData table_data(int reflectors, int poses) {
    std::vector<Eigen::Vector3d> p_F_mm;
    MeasurementData data;
    for (int k = 0; k < reflectors; ++k) {
      p_F_mm.push_back(on_table());
      data.smr_names.push_back(std::to_string(k + 1));
    }
    for (int i = 0; i < poses; ++i) {
      JointVector q = angles();
      // A turntable is turned in steps.
      if (q.size() == 1) q[0] = nominal_.joints[0].min * (1 - 2.0 * i / (poses - 1));
      for (int k = 0; k < reflectors; ++k)
        data.points.push_back(
            {.q = q,
             .p_WS_mm = seen(plain::moved(table_at(q), p_F_mm[static_cast<std::size_t>(k)])),
             .smr = k,
             .row = static_cast<int>(data.points.size()) + 1});
    }
    return data;
  }

  /// The arm by 60 poses of its own.
  MeasuringCell calibrated_arm() {
    MeasurementData data{.smr_names = {"1"}};
    for (const JointVector& q : random_poses(drawn_arm_, 60, random_))
      data.points.push_back({.q = q, .p_WS_mm = seen(tcp(q))});
    const auto calibration = calibrate(drawn_arm_, data, {.noise = kNoise});
    return {calibration->cell, calibration->covariance, kNoise};
  }
  /// The TCP is the reflector.
  Eigen::Vector3d tcp(const JointVector& q) const {
    return plain::moved(X_WB_ * plain::flange(arm_.robot, q), arm_.reflectors[0].p_FS_mm);
  }

  /// Reflectors at origin, x and xy of the workpiece, each at so many angles of the table.
  FrameReadings workpiece(int times) {
    FrameReadings data{.points = {{kOrigin, {}}, {kOnX, {}}, {kInXy, {}}}};
    const std::vector<Eigen::Vector3d> p_U_mm{{0, 0, 0}, {350, 0, 0}, {40, 300, 0}};
    for (int i = 0; i < times; ++i) {
      const JointVector q = angles();
      for (std::size_t k = 0; k < p_U_mm.size(); ++k)
        data.readings.push_back({.point = k,
                                 .q = q,
                                 .p_WS_mm = seen(plain::moved(table_at(q) * X_FU_, p_U_mm[k])),
                                 .row = 3 * i + static_cast<int>(k) + 1});
    }
    return data;
  }

  Random& random() { return random_; }
  RobotModel& nominal() { return nominal_; }
  RobotModel& truth() { return truth_; }
  const RobotModel& drawn_arm() const { return drawn_arm_; }
  const Matrix& X_given() const { return X_given_; }
  const Matrix& X_root() const { return X_root_; }
  const Matrix& X_FU() const { return X_FU_; }
  void make_round() { eccentric_ = 0; }

  /// Of the roots that no reading tells from the true one, that which is nearest to the given one.
  Matrix told_root() const {
    if (nominal_.joint_count() > 1) return X_root_;
    const auto likeness = [&](double rad) {
      return (X_given_.transpose() * X_root_ * plain::turned(2, rad)).topLeftCorner<3, 3>().trace();
    };
    double low = -0.1, high = 0.1;
    for (int i = 0; i < 100; ++i) {
      const double left = low + (high - low) / 3, right = high - (high - low) / 3;
      (likeness(left) < likeness(right) ? low : high) = likeness(left) < likeness(right) ? left : right;
    }
    const Eigen::Vector3d off = plain::moved(X_root_.inverse(), X_given_.topRightCorner<3, 1>());
    return X_root_ * plain::shifted({0, 0, off.z()}) * plain::turned(2, (low + high) / 2);
  }

 private:
  Random random_;
  RobotModel nominal_, truth_, drawn_arm_;
  CalibratedCell arm_;
  Matrix X_WB_, X_WB_told_, X_given_, X_root_, X_FU_;
  double eccentric_ = kEccentric;
  double phases_[2] = {0, 0};
};

struct Found {
  Calibration calibration;
  MeasuringCell table;
};

std::optional<Found> calibrated(const RobotModel& nominal, const MeasurementData& data) {
  auto calibration = calibrate(nominal, data, {.noise = kNoise, .deviation = true});
  if (!calibration) {
    ADD_FAILURE() << calibration.error().detail;
    return std::nullopt;
  }
  MeasuringCell table{calibration->cell, calibration->covariance, kNoise};
  return Found{*std::move(calibration), std::move(table)};
}

/// Errors over their standard deviations, and the share of them within 1.96.
struct Coverage {
  int all = 0, within = 0, within_three = 0;
  double square = 0;
  void add(double error, double sigma) {
    ++all;
    within += std::abs(error) < 1.96 * sigma;
    within_three += std::abs(error) < 3 * sigma;
    square += error * error / (sigma * sigma);
  }
  double share() const { return static_cast<double>(within) / all; }
  double of_three() const { return static_cast<double>(within_three) / all; }
};

class Positioner : public testing::TestWithParam<int> {
 protected:
  RobotModel drawn() const { return GetParam() == 1 ? turntable() : tilt_and_turn(); }
};
INSTANTIATE_TEST_SUITE_P(Axes, Positioner, testing::Values(1, 2));

TEST_P(Positioner, StandsWhereItIsFoundWithTheSigmaThatIsTold) {
  const int seeds = trials(200);
  Coverage root, links;
  double worst_mm = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    Cell cell(drawn(), static_cast<std::uint64_t>(seed));
    const auto found = calibrated(cell.nominal(), cell.table_data(4, 24));
    ASSERT_TRUE(found) << "seed " << seed;
    const PositionerRoot told = positioner_root(cell.calibrated_arm(), found->table, cell.nominal(),
                                                Eigen::Isometry3d(cell.X_given()));
    const Eigen::Isometry3d wanted(cell.told_root());
    // In the root's own axes: of a turntable nothing is told along and about the third.
    const Eigen::Matrix3d R = wanted.linear().transpose();
    Eigen::Matrix<double, 6, 6> turned = Eigen::Matrix<double, 6, 6>::Zero();
    turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = R;
    Eigen::Vector<double, 6> error;
    error << told.X_BR.translation() - wanted.translation(),
        turn_between(wanted.linear(), told.X_BR.linear());
    error = turned * error;
    const Eigen::Matrix<double, 6, 6> C = turned * told.covariance * turned.transpose();
    for (Eigen::Index i = 0; i < 6; ++i) {
      if (GetParam() == 1 && i % 3 == 2) {
        EXPECT_LT(std::abs(error[i]), i < 3 ? 2e-3 : 2e-6) << "seed " << seed << " " << i;
        continue;
      }
      root.add(error[i], std::sqrt(C(i, i)));
    }
    worst_mm = std::max(worst_mm, error.head<3>().norm());
    if (GetParam() == 2) {
      const int at = ParameterLayout::of(found->table.cell).link(1);
      const Joint &is = found->table.cell.robot.joints[1], &truly = cell.truth().joints[1];
      links.add(is.a_mm - truly.a_mm, std::sqrt(found->table.covariance(at, at)));
      links.add(is.alpha_rad - truly.alpha_rad, std::sqrt(found->table.covariance(at + 1, at + 1)));
    }
  }
  std::printf("%d axes, seeds 0..%d: root within 1.96 sigma %.3f, 3 sigma %.3f, square %.3f, worst %.3f mm",
              GetParam(), seeds - 1, root.share(), root.of_three(), root.square / root.all, worst_mm);
  if (links.all > 0)
    std::printf("; axes %.3f, %.3f, square %.3f", links.share(), links.of_three(), links.square / links.all);
  std::printf("\n");
}

TEST_P(Positioner, CarriesTheWorkpieceToWhereTheArmsTcpIsSent) {
  const int seeds = trials(200);
  std::vector<double> before, after;
  Coverage sigma;
  double square = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    Cell cell(drawn(), static_cast<std::uint64_t>(seed));
    const auto found = calibrated(cell.nominal(), cell.table_data(4, 24));
    ASSERT_TRUE(found) << "seed " << seed;
    const MeasuringCell arm = cell.calibrated_arm();
    const auto workpiece = tool_frame(cell.workpiece(4), found->table);
    ASSERT_TRUE(workpiece) << workpiece.error();
    EXPECT_TRUE(workpiece->is_sound()) << "seed " << seed;
    const TargetCompensation compensation(cell.drawn_arm(), arm.cell.robot);
    const Eigen::Vector3d p_F_mm = arm.cell.reflectors[0].p_FS_mm;
    JointVector near(6);
    near << -0.2, -1.3, 1.5, 0.2, 0.8, 0.1;
    std::vector<double> of_given, of_found;
    while (of_found.size() < 50) {
      const JointVector e = cell.angles();
      const Eigen::Vector3d p_U(cell.random().uniform(-200, 400), cell.random().uniform(-200, 400),
                                cell.random().uniform(0, 250));
      const Eigen::Vector3d truly = plain::moved(cell.table_at(e) * cell.X_FU(), p_U);
      const Eigen::Vector3d given =
          plain::moved(cell.X_given() * plain::flange(cell.nominal(), e) * cell.X_FU(), p_U);
      const Eigen::Vector3d p_FU = workpiece->X * p_U;
      const Eigen::Vector3d told = table_in_base(arm.cell, found->table.cell, e) * p_FU;
      const auto q_given = compensation.at_position(given, near, p_F_mm);
      const auto q = compensation.at_position(told, near, p_F_mm);
      if (!q || !q_given) continue;
      of_given.push_back((cell.tcp(q_given->q) - truly).norm());
      of_found.push_back((cell.tcp(q->q) - truly).norm());
      const Eigen::Matrix3d C =
          tcp_covariance(arm.cell, arm.covariance, q->q, p_F_mm) +
          tcp_covariance(found->table.cell, found->table.covariance, e, p_FU, &*workpiece);
      const Eigen::Vector3d error = cell.tcp(q->q) - truly;
      square += error.dot(C.inverse() * error) / 3 / 50 / seeds;
    }
    before.push_back(mean(of_given));
    after.push_back(mean(of_found));
  }
  std::printf(
      "%d axes, seeds 0..%d: mean %.3f mm before, %.4f after, at worst %.4f; square over variance %.3f\n",
      GetParam(), seeds - 1, mean(before), mean(after), *std::ranges::max_element(after), square);
}

}  // namespace
}  // namespace truepose
