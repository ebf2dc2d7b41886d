#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>

#include "core/identify/calibrate.hpp"
#include "core/identify/measurement_model.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

/// Mean squared error of the predicted points of `fresh` that no unbiased estimate from `data` goes below.
double cramer_rao(const CalibratedCell& truth, const MeasurementData& data, const MeasurementData& fresh) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J, J_fresh;
  residuals_with_jacobian(truth, data.points, f, J);
  residuals_with_jacobian(truth, fresh.points, f, J_fresh);
  const Eigen::VectorXd scale = J.colwise().norm().cwiseMax(1e-12).cwiseInverse();
  Eigen::BDCSVD<Eigen::MatrixXd> svd(J * scale.asDiagonal(), Eigen::ComputeThinV);
  svd.setThreshold(1e-9);
  const Eigen::Index rank = svd.rank();
  const Eigen::MatrixXd directions = J_fresh * scale.asDiagonal() * svd.matrixV().leftCols(rank) *
                                     svd.singularValues().head(rank).cwiseInverse().asDiagonal();
  return example::kSigma_mm * example::kSigma_mm * directions.squaredNorm() /
         static_cast<double>(fresh.points.size());
}

struct Outcome {
  int rank = 0;
  double rmse_over_bound = 0;
};

/// Identifies arms that deviate from `nominal`, and judges them where the points truly are.
Outcome identified(const RobotModel& nominal, int reflectors, std::uint64_t seed) {
  constexpr int kTrials = 25, kPoses = 40;
  Random random{seed};
  Outcome outcome;
  double squared = 0, bound = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const CalibratedCell truth =
        example::placed(example::deviating(nominal, random, 0.5, 1e-3), random, reflectors);
    MeasurementData data = example::measured(truth, kPoses, example::kSigma_mm, random);
    MeasurementData fresh = example::measured(truth, kPoses, 0, random);
    bound += cramer_rao(truth, data, fresh);
    for (Measurement& point : fresh.points) {
      point.set = PoseSet::Validate;
      data.points.push_back(point);
    }
    const auto result = calibrate(nominal, data);
    EXPECT_TRUE(result) << result.error().detail;
    if (!result) return {};
    EXPECT_TRUE(trial == 0 || result->rank == outcome.rank);
    outcome.rank = result->rank;
    squared += result->validate->geometric.rms * result->validate->geometric.rms;
  }
  outcome.rmse_over_bound = std::sqrt(squared / bound);
  return outcome;
}

TEST(OtherArms, ASevenAxisArmIsIdentifiedAtTheStatisticalLimit) {
  const Outcome outcome = identified(example::seven_axis(), 1, 1);
  EXPECT_EQ(outcome.rank, 4 * 7 + 3);
  EXPECT_NEAR(outcome.rmse_over_bound, 1, 0.05);
}

TEST(OtherArms, AnArmOnARailIsIdentifiedAtTheStatisticalLimit) {
  const Outcome outcome = identified(example::kr210_on_a_rail(), 1, 2);
  EXPECT_EQ(outcome.rank, 2 + 4 * 6 + 3);
  EXPECT_NEAR(outcome.rmse_over_bound, 1, 0.05);
}

TEST(OtherArms, ThreeReflectorsGiveTheOrientationOfTheToolToo) {
  const Outcome outcome = identified(example::kr210(), 3, 3);
  EXPECT_EQ(outcome.rank, 27 + 6);
  EXPECT_NEAR(outcome.rmse_over_bound, 1, 0.05);
}

TEST(OtherArms, AToolOfSeveralReflectorsIsFoundWhereEachPoseShowsOnlyOneOfThem) {
  Random random{4};
  const CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random, 3);
  MeasurementData data = example::measured(truth, 90, 0, random);
  std::erase_if(data.points, [](const Measurement& m) { return (m.row - 1) / 3 % 3 != m.smr; });
  const auto result = calibrate(example::kr210(), data);
  ASSERT_TRUE(result);
  const auto distance = [](const CalibratedCell& cell, std::size_t i, std::size_t j) {
    return (cell.reflectors[i].p_FS_mm - cell.reflectors[j].p_FS_mm).norm();
  };
  EXPECT_NEAR(distance(result->cell, 0, 1), distance(truth, 0, 1), 1e-6);
  EXPECT_NEAR(distance(result->cell, 1, 2), distance(truth, 1, 2), 1e-6);
}

}  // namespace
}  // namespace truepose
