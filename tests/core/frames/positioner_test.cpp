#include "core/frames/positioner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "core/compensate/target_compensation.hpp"
#include "core/math/dense_algebra.hpp"
#include "tests/core/positioner_cell.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

using namespace positioner_cell;
using testing::HasSubstr;

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

INSTANTIATE_TEST_SUITE_P(Axes, Positioner, testing::Values(1, 2));

TEST_P(Positioner, StandsWhereItIsFoundWithTheStatedSigma) {
  const int seeds = trials(400);
  Coverage root, links;
  double worst_mm = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    PositionerCell cell(drawn(), static_cast<std::uint64_t>(seed));
    const auto found = calibrated(cell.nominal(), cell.table_data(4, 24));
    ASSERT_TRUE(found) << "seed " << seed;
    const PositionerRoot found_frame = positioner_root(cell.calibrated_arm(), found->table, cell.nominal(),
                                                       Eigen::Isometry3d(cell.X_given()));
    const Eigen::Isometry3d wanted(cell.controller_root());
    // In the root's own axes: for a turntable nothing is identifiable along and about the third.
    const Eigen::Matrix3d R = wanted.linear().transpose();
    Eigen::Matrix<double, 6, 6> turned = Eigen::Matrix<double, 6, 6>::Zero();
    turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = R;
    Eigen::Vector<double, 6> error;
    error << found_frame.X_BR.translation() - wanted.translation(),
        turn_between(wanted.linear(), found_frame.X_BR.linear());
    error = turned * error;
    const Eigen::Matrix<double, 6, 6> C = turned * found_frame.covariance * turned.transpose();
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
  EXPECT_GT(root.share(), widened(0.93, -0.03)) << "of seeds 0.." << seeds - 1;
  EXPECT_LT(root.share(), widened(0.97, 0.03)) << "of seeds 0.." << seeds - 1;
  EXPECT_GE(root.of_three(), least_rate(0.99)) << "of seeds 0.." << seeds - 1;
  if (links.all > 0) {
    EXPECT_GE(links.of_three(), least_rate(0.99)) << "of seeds 0.." << seeds - 1;
  }
  EXPECT_LT(worst_mm, 0.06) << "of seeds 0.." << seeds - 1;
  std::printf("%d axes, seeds 0..%d: root within 1.96 sigma %.3f, 3 sigma %.3f, square %.3f, worst %.3f mm",
              GetParam(), seeds - 1, root.share(), root.of_three(), root.square / root.all, worst_mm);
  if (links.all > 0)
    std::printf("; axes %.3f, %.3f, square %.3f", links.share(), links.of_three(), links.square / links.all);
  std::printf("\n");
}

TEST_P(Positioner, CarriesTheWorkpieceToWhereTheArmsTcpIsSent) {
  const int seeds = trials(400);
  std::vector<double> before, after;
  double square = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    PositionerCell cell(drawn(), static_cast<std::uint64_t>(seed));
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
      const Eigen::Vector3d found_frame = table_in_base(arm.cell, found->table.cell, e) * p_FU;
      const auto q_given = compensation.at_position(given, near, p_F_mm);
      const auto q = compensation.at_position(found_frame, near, p_F_mm);
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
  EXPECT_GT(mean(before), 2);
  EXPECT_LT(mean(after), 0.04);
  EXPECT_LT(*std::ranges::max_element(after), 0.08) << "of seeds 0.." << seeds - 1;
  EXPECT_NEAR(square, 1, widened(0.15, 0.15)) << "of seeds 0.." << seeds - 1;
}

/// All readings of arm and table in one fit.
class JointFit {
 public:
  JointFit(const MeasurementData& of_arm, const MeasurementData& of_table, const CalibratedCell& arm,
           const CalibratedCell& table, const Eigen::Isometry3d& X_BR)
      : of_arm_{of_arm}, of_table_{of_table}, arm_{arm}, table_{table}, X_BR_{X_BR} {}

  /// Predicted minus measured, the arm's first, with both moved: the arm's parameters, the root in the arm's
  /// base, the table's parameters but its base.
  Eigen::VectorXd residuals(const Eigen::VectorXd& of_arm, const Eigen::VectorXd& of_root,
                            const Eigen::VectorXd& of_table) const {
    const CalibratedCell arm = moved(arm_, of_arm);
    CalibratedCell table = moved(table_, of_table);
    Matrix X_BR = rigid(of_root.head<3>(), {0, 0, 0}) * X_BR_.matrix();
    X_BR.topLeftCorner<3, 3>() = rigid({0, 0, 0}, of_root.tail<3>()).topLeftCorner<3, 3>() * X_BR_.linear();
    table.base = BasePose::of(arm.base.isometry() * Eigen::Isometry3d(X_BR));
    Eigen::VectorXd f(3 * static_cast<Eigen::Index>(of_arm_.points.size() + of_table_.points.size()));
    Eigen::Index row = 0;
    for (const auto& [cell, data] :
         {std::pair{&arm, &of_arm_}, std::pair{&std::as_const(table), &of_table_}}) {
      for (const Measurement& point : data->points) {
        f.segment<3>(row) = cell->predict(point) - point.p_WS_mm;
        row += 3;
      }
    }
    return f;
  }

 private:
  const MeasurementData &of_arm_, &of_table_;
  CalibratedCell arm_, table_;
  Eigen::Isometry3d X_BR_;
};

std::vector<Eigen::Index> known_of(const Eigen::MatrixXd& covariance, Eigen::Index first) {
  std::vector<Eigen::Index> known;
  for (Eigen::Index k = first; k < covariance.rows(); ++k)
    if (covariance(k, k) > 0) known.push_back(k);
  return known;
}

// All readings in one fit, with the root in the arm's base among the unknowns.
TEST(PositionerRoot, OfOneAfterTheOtherIsThatOfTheFitOfBothTogether) {
  PositionerCell cell(tilt_and_turn(), 11);
  cell.make_eccentric(0);
  const MeasurementData of_table = cell.table_data(4, 24), of_arm = cell.arm_data();
  const auto arm = calibrate(cell.drawn_arm(), of_arm, {.noise = kNoise});
  const auto table = calibrate(cell.nominal(), of_table, {.noise = kNoise});
  ASSERT_TRUE(arm && table);
  const PositionerRoot root =
      positioner_root({arm->cell, arm->covariance, kNoise}, {table->cell, table->covariance, kNoise},
                      cell.nominal(), Eigen::Isometry3d(cell.X_given()));
  const auto arm_known = known_of(arm->covariance, 0), table_known = known_of(table->covariance, 6);
  const auto arms = std::ssize(arm_known), all = arms + 6 + std::ssize(table_known);
  const JointFit fit(of_arm, of_table, arm->cell, table->cell, root.X_BR);
  const auto at = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd of_arm_step = Eigen::VectorXd::Zero(arm->covariance.rows());
    Eigen::VectorXd of_table_step = Eigen::VectorXd::Zero(table->covariance.rows());
    for (Eigen::Index k = 0; k < arms; ++k) of_arm_step[arm_known[static_cast<std::size_t>(k)]] = x[k];
    for (Eigen::Index k = arms + 6; k < all; ++k)
      of_table_step[table_known[static_cast<std::size_t>(k - arms - 6)]] = x[k];
    Eigen::VectorXd f = fit.residuals(of_arm_step, x.segment<6>(arms), of_table_step);
    const Eigen::Index rows = 3 * std::ssize(of_arm.points);
    f.head(rows) /= arm->sigma0_mm;
    f.tail(f.size() - rows) /= table->sigma0_mm;
    return f;
  };
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(all), f = at(none);
  Eigen::MatrixXd J(f.size(), all);
  for (Eigen::Index k = 0; k < all; ++k) {
    const Eigen::VectorXd step = 1e-5 * Eigen::VectorXd::Unit(all, k);
    J.col(k) = (at(step) - at(-step)) / 2e-5;
  }
  const CholeskyFactor normal(J.transpose() * J);
  const Eigen::VectorXd step = normal.solve(J.transpose() * f);
  const Eigen::MatrixXd covariance = normal.inverse();
  for (Eigen::Index i = 0; i < 6; ++i) {
    const double sigma = std::sqrt(covariance(arms + i, arms + i));
    EXPECT_LT(std::abs(step[arms + i]), 1e-3 * sigma) << i << ": it is where both together have it";
    EXPECT_NEAR(std::sqrt(root.covariance(i, i)), sigma, 1e-3 * sigma) << i;
  }
}

TEST(WhyTurned, TellsARootThatStandsTheOtherWayRoundThanItWasGiven) {
  const RobotModel arm = example::kr210(), table = tilt_and_turn();
  const Eigen::Isometry3d X_given(plain::kuka_frame({1900, 350, -150}, {25, 0, 0}));
  const Eigen::Isometry3d X_turned(plain::kuka_frame({1900, 350, -150}, {204, 1, 0}));
  EXPECT_EQ(why_turned(X_given, arm, table, X_given), "");
  EXPECT_EQ(why_turned(X_turned, arm, table, std::nullopt), "");
  EXPECT_THAT(why_turned(X_turned, arm, table, X_given),
              HasSubstr("turned by 179 deg from where it was given"));
}

TEST(WorkpieceFrame, IsWhereTheNominalTableAndItsRootPutWhatWasMeasured) {
  for (int seed = 0; seed < 20; ++seed) {
    PositionerCell cell(turntable(), static_cast<std::uint64_t>(seed));
    cell.make_eccentric(0);
    const auto table = calibrate(cell.nominal(), cell.table_data(4, 24), {.noise = kNoise});
    ASSERT_TRUE(table);
    const MeasuringCell arm = cell.calibrated_arm(), by{table->cell, table->covariance, kNoise};
    const Eigen::Isometry3d X_given(cell.X_given());
    const auto on_table = tool_frame(cell.workpiece(4), by);
    ASSERT_TRUE(on_table);
    const MeasuredFrame found_frame = workpiece_frame(*on_table, arm, by, cell.nominal(), X_given);
    const Matrix wanted =
        (cell.controller_root() * plain::flange(cell.nominal(), JointVector::Zero(1))).inverse() *
        cell.X_root() * plain::flange(cell.truth(), JointVector::Zero(1)) * cell.X_FU();
    const Eigen::Vector3d error = found_frame.X.translation() - wanted.topRightCorner<3, 1>();
    for (Eigen::Index i = 0; i < 3; ++i)
      EXPECT_LT(std::abs(error[i]), 4.5 * std::sqrt(found_frame.covariance(i, i)))
          << "seed " << seed << " " << i;
    EXPECT_LT(found_frame.sigma_mm(), 0.05) << "seed " << seed;
  }
}

}  // namespace
}  // namespace truepose
