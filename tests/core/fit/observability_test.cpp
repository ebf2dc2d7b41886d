#include <gtest/gtest.h>

#include "core/fit/identifiability.hpp"
#include "core/fit/measurement_model.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/singular_values.hpp"

namespace truepose {
namespace {

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
  // The condition by a decomposition of its own.
  const Eigen::VectorXd singular =
      jacobi_singular_values(kept * kept.colwise().norm().cwiseInverse().asDiagonal()).values;
  EXPECT_NEAR(o.condition() * singular.minCoeff() / singular.maxCoeff(), 1, 1e-9);
}

}  // namespace
}  // namespace truepose
