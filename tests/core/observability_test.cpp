#include "core/calibration/observability.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/calibration/identifiability.hpp"
#include "core/calibration/measurement_model.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

constexpr double kNoPrior = std::numeric_limits<double>::infinity();

TEST(Observability, MatchesTheDefinitionsOnKnownSingularValues) {
  const Eigen::MatrixXd J = Eigen::Vector3d(8, 4, 2).asDiagonal();
  const ObservabilityIndices o = observability(J, 4);
  EXPECT_NEAR(o.o1, 4.0 / 2, 1e-14);
  EXPECT_NEAR(o.o2, 0.25, 1e-14);
  EXPECT_NEAR(o.o3, 2, 1e-14);
  EXPECT_NEAR(o.o4, 0.5, 1e-14);
  EXPECT_NEAR(o.o5, 1 / (0.125 + 0.25 + 0.5), 1e-14);
}

TEST(Observability, GivesTheInverseOfTheConditionAtUnitNorm) {
  Random random{1};
  const CalibratedCell cell = example::placed(example::kr210(), random);
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, example::measured(cell, 40, 0, random).points, f, J);
  const Identifiability known = identifiability(J, conventional_preference(ParameterLayout::of(cell)));
  const Eigen::MatrixXd kept = J(Eigen::all, known.kept);
  const ObservabilityIndices o = observability(kept * column_norms(kept).cwiseInverse().asDiagonal(), 40);
  EXPECT_NEAR(o.o2 * known.condition, 1, 1e-9);
}

TEST(DataShare, IsHalfWhereDataAndPriorKnowEquallyMuch) {
  const Eigen::MatrixXd J = Eigen::Vector3d(1 / 0.3, 1 / 0.3, 1 / 0.3).asDiagonal();
  const Eigen::VectorXd share = data_share(J, Eigen::Vector3d(0.3, 0.03, 30));
  EXPECT_NEAR(share[0], 0.5, 1e-12);
  EXPECT_NEAR(share[1], 1 / 101.0, 1e-12);
  EXPECT_NEAR(share[2], 1 - 1 / 10001.0, 1e-12);
}

TEST(DataShare, GoesToThePriorForWhatNoPoseShowsAndHalvesForWhatOnlyASumShows) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, 3);
  J(0, 1) = J(0, 2) = 1e6;
  const Eigen::VectorXd share = data_share(J, Eigen::Vector3d(1, 1, 1));
  EXPECT_NEAR(share[0], 0, 1e-12);
  EXPECT_NEAR(share[1], 0.5, 1e-9);
  EXPECT_NEAR(share[2], 0.5, 1e-9);
}

TEST(DataShare, WithoutAPriorIsAllOrNothing) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, 4);
  J(0, 0) = 1e3;
  J(1, 1) = J(1, 2) = 1;
  const Eigen::VectorXd share = data_share(J, Eigen::Vector4d::Constant(kNoPrior));
  EXPECT_EQ(share, Eigen::Vector4d(1, 0, 0, 0));
}

TEST(DataShare, OfAnArmIsTheDatasExceptForItsRedundantLinks) {
  Random random{2};
  const CalibratedCell cell = example::placed(example::kr210(), random);
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, example::measured(cell, 100, 0, random).points, f, J);
  const ParameterLayout layout = ParameterLayout::of(cell);
  Eigen::VectorXd prior = Eigen::VectorXd::Constant(layout.size(), kNoPrior);
  for (int i = 0; i < layout.joints; ++i) prior.segment<5>(layout.link(i)) << 0.3, 3e-4, 0.3, 3e-4, 3e-4;
  const Eigen::VectorXd share = data_share(J / 0.02, prior);
  EXPECT_EQ(share.head(9), Eigen::VectorXd::Ones(9));
  EXPECT_NEAR(share[layout.link(0)], 0, 1e-6) << "link1.a is the base's";
  EXPECT_GT(share[layout.link(2)], 0.99) << "link3.a";
  EXPECT_NEAR(share[layout.link(2) + 2], 0.5, 0.2) << "link3.d shares with link2.d";
  EXPECT_TRUE(((share.array() > -1e-9) && (share.array() <= 1)).all());
}

}  // namespace
}  // namespace truepose
