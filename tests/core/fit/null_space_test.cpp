#include "core/fit/null_space.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "core/fit/identifiability.hpp"
#include "core/fit/measurement_model.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::UnorderedElementsAre;

struct NullSpaceResult {
  NullSpace null_space;
  std::vector<std::string> unknown, weak;
};

/// What the poses of `data` tell of `cell`; every statement is checked against the Jacobian.
NullSpaceResult null_space_result(const CalibratedCell& cell, const MeasurementData& data) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, data.points, f, J);
  const ParameterLayout layout = ParameterLayout::of(cell);
  NullSpaceResult out{.null_space = null_space(J / example::kSigma_mm, parameter_names(cell),
                                               conventional_preference(layout), usual_deviation(layout))};
  EXPECT_EQ(out.null_space.basis.cols(), layout.size() - out.null_space.rank);
  EXPECT_LT((J * out.null_space.basis).norm(), 1e-9 * J.norm());
  for (const Combination& c : out.null_space.unknown) out.unknown.push_back(c.sentence);
  for (const Combination& c : out.null_space.weak) out.weak.push_back(c.sentence);
  return out;
}

/// The arm with its base in line with the tracker's axes, so that their names match.
CalibratedCell aligned(const RobotModel& robot, int reflectors = 1) {
  Random random{1};
  CalibratedCell cell = example::placed(robot, random, reflectors);
  cell.base.rxyz_rad.setZero();
  return cell;
}

NullSpaceResult null_space_of_random_poses(const CalibratedCell& cell, int poses = 60) {
  Random random{2};
  return null_space_result(cell, example::measured(cell, poses, 0, random));
}

TEST(NullSpace, NamesTheTwelveRedundanciesOfASixAxisArm) {
  const NullSpaceResult t = null_space_of_random_poses(aligned(example::kr210()));
  EXPECT_EQ(t.null_space.rank, 27);
  EXPECT_GT(t.null_space.gap, 1e10);
  EXPECT_THAT(t.unknown,
              UnorderedElementsAre("base.x and link1.a move together: only their sum is known",
                                   "base.z and link1.d move together: only their sum is known",
                                   "base.rx and link1.alpha move together: only their sum is known",
                                   "base.ry and link1.beta move together: only their sum is known",
                                   "base.rz and link1.theta move together: only their sum is known",
                                   "link2.beta cannot be separated from base.z and link2.theta",
                                   "link2.d and link3.d move together: only their sum is known",
                                   "link4.beta cannot be separated from link2.d and link4.theta",
                                   "link5.theta and link5.beta move together: only their difference is known",
                                   "link6.theta and link6.beta cannot be separated from smr.1.x and smr.1.y",
                                   "smr.1.z and link6.d move together: only their sum is known"));
  EXPECT_TRUE(t.weak.empty());
}

TEST(NullSpace, SpeaksOfAllAxesOfTheTrackerWhereTheBaseStandsAskew) {
  Random random{3};
  const NullSpaceResult t = null_space_of_random_poses(example::placed(example::kr210(), random));
  EXPECT_THAT(t.unknown, Contains("link1.a and link1.d cannot be separated from base.x, base.y and base.z"));
  EXPECT_THAT(
      t.unknown,
      Contains(
          "link1.alpha, link1.theta and link1.beta cannot be separated from base.rx, base.ry and base.rz"));
}

TEST(NullSpace, GivesTheToolItsOrientationWithThreeReflectors) {
  const NullSpaceResult t = null_space_of_random_poses(aligned(example::kr210(), 3));
  EXPECT_EQ(t.null_space.rank, 27 + 6);
  EXPECT_THAT(t.unknown, Contains("link6.d cannot be separated from smr.1.z, smr.2.z and smr.3.z"));
}

TEST(NullSpace, CountsFourParametersForAnAxisThatTurnsAndTwoForOneThatSlides) {
  EXPECT_EQ(null_space_of_random_poses(aligned(example::seven_axis())).null_space.rank, 4 * 7 + 3);
  const NullSpaceResult rail = null_space_of_random_poses(aligned(example::kr210_on_a_rail()));
  EXPECT_EQ(rail.null_space.rank, 2 + 4 * 6 + 3);
  EXPECT_THAT(rail.unknown, Contains("base.x, link1.a and link2.a move together: only their sum is known"));
  EXPECT_THAT(rail.unknown, Contains("link3.d and link4.d move together: only their sum is known"));
}

/// Poses in which only axes 2, 3 and 5 move, and the flange keeps its orientation.
MeasurementData of_one_orientation(const CalibratedCell& cell) {
  Random random{4};
  MeasurementData data = example::measured(cell, 40, 0, random);
  for (Measurement& point : data.points) {
    point.q[0] = point.q[3] = point.q[5] = 0;
    point.q[4] = -point.q[1] - point.q[2];
  }
  return data;
}

TEST(NullSpace, NamesBaseAndReflectorWhereTheFlangeNeverTurns) {
  Random random{5};
  const CalibratedCell askew = example::placed(example::kr210(), random);
  EXPECT_THAT(
      null_space_result(askew, of_one_orientation(askew)).unknown,
      Contains(testing::AllOf(testing::StartsWith("smr.1.*, "),
                              testing::EndsWith("cannot be separated from base.x, base.y and base.z"))));
  const CalibratedCell straight = aligned(example::kr210());
  EXPECT_THAT(null_space_result(straight, of_one_orientation(straight)).unknown,
              Contains(testing::StartsWith("base.y, smr.1.y, ")));
}

TEST(NullSpace, SaysOfBaseAndReflectorAloneThatOneOrientationCannotSeparateThem) {
  Random random{5};
  const CalibratedCell cell = example::placed(example::kr210(), random);
  const MeasurementData data = of_one_orientation(cell);
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, data.points, f, J);
  const std::vector<std::string> names = parameter_names(cell);
  const NullSpace space = null_space(J.leftCols(9) / example::kSigma_mm, std::span{names}.first(9),
                                     Eigen::VectorXd::Ones(9), Eigen::VectorXd::Ones(9));
  ASSERT_EQ(space.unknown.size(), 1U);
  EXPECT_EQ(space.unknown[0].sentence, "smr.1.* cannot be separated from base.x, base.y and base.z");
  EXPECT_THAT(space.unknown[0].parameters, ElementsAre(0, 1, 2, 6, 7, 8));
}

TEST(NullSpace, LeavesACircleOfOneMovedAxisItsSevenParameters) {
  const CalibratedCell cell = aligned(example::kr210());
  Random random{6};
  MeasurementData data = example::measured(cell, 40, 0, random);
  for (Measurement& point : data.points) point.q.tail<5>() = data.points[0].q.tail<5>();
  const NullSpaceResult t = null_space_result(cell, data);
  EXPECT_EQ(t.null_space.rank, 7);  // its centre, its plane, its radius and where it begins
  EXPECT_LT(t.unknown.size(), 12U) << "many parameters, few sentences";
}

TEST(NullSpace, SaysWhenAParameterDoesNotShowAtAll) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Random(12, 4);
  J.col(2).setZero();
  const std::vector<std::string> names{"link1.a", "link1.d", "link2.a", "link3.d"};
  const NullSpace space = null_space(J, names, Eigen::VectorXd::Ones(4), Eigen::VectorXd::Constant(4, 1e3));
  ASSERT_EQ(space.unknown.size(), 1U);
  EXPECT_EQ(space.unknown[0].sentence, "link2.a does not show in these poses");
}

TEST(NullSpace, TellsSumDifferenceAndAnyOtherCombinationApart) {
  const std::vector<std::string> names{"link1.a", "link2.a"};
  for (const auto& [factor, known] :
       {std::pair{1., "their sum"}, {-1., "their difference"}, {2., "one combination of them"}}) {
    Eigen::MatrixXd J = Eigen::MatrixXd::Random(9, 2);
    J.col(1) = factor * J.col(0);
    const NullSpace space = null_space(J, names, Eigen::VectorXd::Ones(2), Eigen::VectorXd::Constant(2, 1e3));
    ASSERT_EQ(space.unknown.size(), 1U);
    EXPECT_EQ(space.unknown[0].sentence,
              std::string("link1.a and link2.a move together: only ") + known + " is known");
  }
}

TEST(NullSpace, KeepsExactRelationsOfAnArmThatDeviatesFewAndShort) {
  Random random{7};
  const NullSpaceResult t =
      null_space_of_random_poses(example::placed(example::with_paper_errors(example::kr210()), random));
  EXPECT_EQ(t.null_space.rank, 27);
  for (const std::string& sentence : t.unknown) EXPECT_LT(std::ranges::count(sentence, ','), 5) << sentence;
}

TEST(NullSpace, CallsWeakWhatTheDataKnowLessWellThanTheDataSheet) {
  const CalibratedCell cell = aligned(example::kr210());
  Random random{8};
  MeasurementData data = example::measured(cell, 40, 0, random);
  // Axis 4 hardly moves: its place is seen, but at a sigma far beyond what arms deviate.
  for (Measurement& point : data.points) point.q[3] = 0.3 + 0.001 * point.q[3];
  const NullSpaceResult t = null_space_result(cell, data);
  EXPECT_EQ(t.null_space.rank, 27);
  ASSERT_FALSE(t.weak.empty());
  EXPECT_THAT(t.weak, Contains(testing::HasSubstr("weakly known")));
  EXPECT_THAT(t.weak[0], testing::HasSubstr("link4."));
}

}  // namespace
}  // namespace truepose
