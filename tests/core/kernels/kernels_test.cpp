#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/arm/arm_kernel.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/random.hpp"
#include "tests/allocations.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/on_every_isa.hpp"
#include "tests/sanitized.hpp"

namespace truepose {
namespace {

using example::kArms;
using example::kEveryIsa;
using example::kr210;
using example::OnEveryIsa;
using example::random_arm;
using example::random_joints;
using kernels::Isa;

class Kernels : public OnEveryIsa {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, Kernels, kEveryIsa, example::isa_name);

double ulps(double actual, long double exact) {
  const double nearest = static_cast<double>(exact);
  const double ulp = std::nextafter(std::abs(nearest), HUGE_VAL) - std::abs(nearest);
  return static_cast<double>(std::abs(static_cast<long double>(actual) - exact)) / ulp;
}

TEST_P(Kernels, TakeSineAndCosineWithinTwoUlpUpToTheReachOfTheirReduction) {
  Random random{1};
  std::vector<double> angles{0., 1e-300, 1e-9, std::numbers::pi, 1e5, -1e5};
  for (const double range : {1e-3, 1., 4., 100., 1e5}) {
    for (int i = 0; i < 50000; ++i) angles.push_back(random.uniform(-range, range));
  }
  // The doubles nearest to the multiples of pi/2, where nearly all digits cancel, and their neighbours.
  for (int k = 1; k <= 63661; ++k) {
    const double multiple = k * std::numbers::pi / 2;
    for (const double angle : {std::nextafter(multiple, 0), multiple, std::nextafter(multiple, 1e9)})
      angles.push_back(angle);
  }
  std::vector<double> sine(angles.size()), cosine(angles.size());
  code().sincos(angles.data(), sine.data(), cosine.data(), static_cast<int>(angles.size()));
  double worst = 0;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    worst = std::max({worst, ulps(sine[i], std::sin(static_cast<long double>(angles[i]))),
                      ulps(cosine[i], std::cos(static_cast<long double>(angles[i])))});
  }
  EXPECT_LE(worst, 2);
  RecordProperty("worst_ulp", std::to_string(worst));
}

TEST_P(Kernels, TakeSineAndCosineOfAnglesBeyondTheirReachFromTheLibrary) {
  const std::vector<double> angles{0.5, 100000.5, -3e7, 1e22, -1e300, 1., 2., 3., 1e9};
  std::vector<double> sine(angles.size()), cosine(angles.size());
  code().sincos(angles.data(), sine.data(), cosine.data(), static_cast<int>(angles.size()));
  for (std::size_t i = 0; i < angles.size(); ++i) {
    EXPECT_NEAR(sine[i], std::sin(angles[i]), 3e-16);
    EXPECT_NEAR(cosine[i], std::cos(angles[i]), 3e-16);
  }
  const double not_angles[]{NAN, INFINITY, -INFINITY};
  code().sincos(not_angles, sine.data(), cosine.data(), 3);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(std::isnan(sine[static_cast<std::size_t>(i)]));
}

TEST_P(Kernels, SayTheSamePoseAndJacobianAsTheReference) {
  Random random{2};
  for (const std::string& types : kArms) {
    for (int trial = 0; trial < 100; ++trial) {
      const RobotModel robot = random_arm(types, random);
      const ArmKernel arm{robot, code()};
      const JointVector q = random_joints(robot, random);
      const PoseAndJacobian expected = forward_with_jacobian(robot, q);
      const double scale = 1 + expected.X_BF.translation().norm();

      EXPECT_LT((arm.forward(q).matrix() - expected.X_BF.matrix()).norm(), 1e-12 * scale) << types;
      PoseAndJacobian actual;
      arm.forward_with_jacobian(q, actual);
      EXPECT_LT((actual.X_BF.matrix() - expected.X_BF.matrix()).norm(), 1e-12 * scale) << types;
      ASSERT_EQ(actual.J.cols(), expected.J.cols());
      EXPECT_LT((actual.J - expected.J).norm(), 1e-12 * (1 + expected.J.norm())) << types;
    }
  }
}

TEST_P(Kernels, SayTheSamePosesInBatchWhateverTheNumber) {
  Random random{3};
  for (const std::string& types : kArms) {
    const RobotModel robot = random_arm(types, random);
    const ArmKernel arm{robot, code()};
    for (const int count : {1, 7, 8, 9, 37}) {
      Eigen::ArrayXXd q(count, robot.joint_count());
      for (int k = 0; k < count; ++k) q.row(k) = random_joints(robot, random).transpose();
      PoseColumns poses(count, 12);
      arm.forward(q, poses);
      for (int k = 0; k < count; ++k) {
        const Eigen::Isometry3d expected = forward_kinematics(robot, q.row(k).transpose().matrix());
        const Eigen::Matrix<double, 3, 4> actual = Eigen::Map<const Eigen::Matrix<double, 3, 4>>(
            Eigen::Array<double, 12, 1>(poses.row(k).transpose()).data());
        EXPECT_LT((actual - expected.matrix().topRows<3>()).norm(),
                  1e-12 * (1 + expected.translation().norm()));
      }
    }
  }
}

TEST_P(Kernels, InvertTheCalibratedArmAtEveryTarget) {
  constexpr int kTargets = TRUEPOSE_SANITIZED ? 1000 : 10000;
  const RobotModel robot = kr210(true);
  const ArmKernel arm{robot, code()};
  Random random{4};
  int descended = 0;
  for (int k = 0; k < kTargets; ++k) {
    const JointVector q = random_joints(robot, random);
    JointVector seed = q;
    for (double& joint : seed) joint += random.uniform(-5, 5) * kRadPerDeg;
    const Eigen::Isometry3d X = forward_kinematics(robot, q);
    descended += arm.inverse_near(X, seed).has_value();
    const auto solution = arm.inverse_near(X, seed, {.leaps = 8});
    ASSERT_TRUE(solution.has_value()) << k;
    const Eigen::Isometry3d reached = forward_kinematics(robot, solution->q);
    EXPECT_LT((reached.translation() - X.translation()).norm(), 1e-8);
    EXPECT_LT(angle_between(reached.linear(), X.linear()), 1e-10);
    EXPECT_LE(solution->residual_mm, 1e-9);
    EXPECT_LE(solution->residual_rad, 1e-12);
  }
  // Singularities lie between the rest and their seeds.
  EXPECT_GE(descended, 0.999 * kTargets);
}

TEST_P(Kernels, InvertArmsWithMoreThanSixJointsByTheSmallestStep) {
  Random random{5};
  for (const std::string types : {"RRRRRRR", "PRRRRRR", "RRRRRRRRRRR"}) {
    for (int trial = 0; trial < 50; ++trial) {
      const RobotModel robot = random_arm(types, random);
      const JointVector q = random_joints(robot, random);
      const Eigen::Isometry3d X = forward_kinematics(robot, q);
      JointVector seed = q;
      for (double& joint : seed) joint += random.uniform(-1e-3, 1e-3);
      const auto solution = ArmKernel{robot, code()}.inverse_near(X, seed);
      ASSERT_TRUE(solution.has_value()) << types;
      EXPECT_LT((forward_kinematics(robot, solution->q).translation() - X.translation()).norm(), 1e-8);

      // To first order the way gone has no part in the Jacobian's null space.
      PoseAndJacobian at = forward_with_jacobian(robot, seed);
      for (Eigen::Index i = 0; i < q.size(); ++i)
        if (robot.joints[static_cast<std::size_t>(i)].type == JointType::Prismatic) at.J.col(i) *= 1000;
      JointVector way = solution->q - seed;
      for (Eigen::Index i = 0; i < q.size(); ++i)
        if (robot.joints[static_cast<std::size_t>(i)].type == JointType::Prismatic) way[i] /= 1000;
      const Eigen::MatrixXd J = at.J;
      const Eigen::VectorXd smallest = smallest_solution(J, J * way, 0);
      EXPECT_LT((way - smallest).norm(), 0.05 * way.norm()) << types;
    }
  }
}

TEST_P(Kernels, InvertArmsWithFewerThanSixJointsWhereThePoseCanBeReached) {
  Random random{14};
  for (const std::string types : {"R", "P", "RPR", "RRRRR"}) {
    for (int trial = 0; trial < 50; ++trial) {
      const RobotModel robot = random_arm(types, random);
      const JointVector q = random_joints(robot, random);
      const Eigen::Isometry3d X = forward_kinematics(robot, q);
      const auto solution = ArmKernel{robot, code()}.inverse_near(X, q.array() + 0.01);
      ASSERT_TRUE(solution.has_value()) << types;
      EXPECT_LT((forward_kinematics(robot, solution->q).translation() - X.translation()).norm(), 1e-8);
    }
  }
}

/// 3 x 3 matrices of candidates as the kernels keep them.
struct Candidates3 {
  explicit Candidates3(std::size_t count, std::size_t entries)
      : lines(count / kernels::kMostLanes * entries) {}
  double* data() { return lines.front().value; }
  double& at(std::size_t candidate, std::size_t entry, std::size_t entries) {
    return lines[candidate / kernels::kMostLanes * entries + entry].value[candidate % kernels::kMostLanes];
  }
  std::vector<kernels::Line> lines;
};

TEST_P(Kernels, JudgeCandidatePosesAsEigenDoes) {
  constexpr std::size_t kCandidates = 24, kColumns = 38;
  constexpr int kBlocks = kCandidates / kernels::kMostLanes;
  Random random{21};
  Candidates3 rows{kCandidates, 3 * kColumns}, V{kCandidates, 6}, W{kCandidates, 6}, gain{kCandidates, 1};
  for (kernels::Line& line : rows.lines)
    for (double& value : line.value) value = random.normal();
  using Square = Eigen::Matrix<double, kColumns, kColumns>;
  const Square B = Square::NullaryExpr([&] { return random.normal(); }), M = B * B.transpose() / kColumns;
  Eigen::Matrix<double, kColumns, 6, Eigen::RowMajor> UP;
  for (double& value : UP.reshaped()) value = random.normal();
  Eigen::Matrix<double, kColumns, 3, Eigen::RowMajor> U = UP.leftCols<3>();
  const auto P = UP.rightCols<3>();
  const auto A = [&](std::size_t k) {
    Eigen::Matrix<double, 3, kColumns> out;
    for (std::size_t i = 0; i < 3 * kColumns; ++i)
      out(static_cast<Eigen::Index>(i / kColumns), static_cast<Eigen::Index>(i % kColumns)) =
          rows.at(k, i, 3 * kColumns);
    return out;
  };
  constexpr int kThrees = (kColumns + 2) / 3;
  std::vector<double> by_three(kThrees * kColumns * 3);
  for (std::size_t c = 0; c < kColumns; ++c) {
    for (std::size_t r = 0; r < kColumns; ++r)
      by_three[(c / 3 * kColumns + r) * 3 + c % 3] =
          M(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
  }
  const auto near = [](double value, double expected) {
    return std::abs(value - expected) <= 1e-11 * (1 + std::abs(expected));
  };
  constexpr int columns = kColumns;

  code().congruences(rows.data(), kBlocks, columns, by_three.data(), V.data());
  code().add_squares(rows.data(), kBlocks, columns, U.data(), 0.5, V.data());
  code().volume_gains(V.data(), kBlocks, gain.data());
  for (std::size_t k = 0; k < kCandidates; ++k) {
    const Eigen::Matrix3d AU = A(k) * U;
    const Eigen::Matrix3d S =
        Eigen::Matrix3d::Identity() + A(k) * M * A(k).transpose() + 0.5 * AU * AU.transpose();
    EXPECT_PRED2(near, gain.at(k, 0, 1), S.determinant());
  }
  code().congruences(rows.data(), kBlocks, columns, by_three.data(), W.data());
  code().add_products(rows.data(), kBlocks, columns, UP.data(), 2, V.data(), W.data());
  code().variance_gains(V.data(), W.data(), kBlocks, gain.data());
  for (std::size_t k = 0; k < kCandidates; ++k) {
    const Eigen::Matrix3d AU = A(k) * U, AP = A(k) * P, AMA = A(k) * M * A(k).transpose();
    const Eigen::Matrix3d S = Eigen::Matrix3d::Identity() + AMA + 2.5 * AU * AU.transpose();
    const Eigen::Matrix3d sum = AMA + 2 * (AU * AP.transpose() + AP * AU.transpose());
    EXPECT_PRED2(near, gain.at(k, 0, 1), (S.inverse() * sum).trace());
  }
}

TEST_P(Kernels, InvertByTheShorterWayRound) {
  const RobotModel robot = kr210(true);
  const JointVector q = (JointVector(6) << 0.2, -1.4, 1.5, 0.3, 0.8, 0.1).finished();
  const Eigen::Isometry3d X = forward_kinematics(robot, q);
  for (int degrees = -170; degrees <= 170; degrees += 10) {
    JointVector seed = q;
    seed[5] += degrees * kRadPerDeg;
    const auto solution = ArmKernel{robot, code()}.inverse_near(X, seed);
    ASSERT_TRUE(solution.has_value()) << degrees;
    EXPECT_LT((solution->q - q).norm(), 1e-8) << degrees;
  }
}

TEST_P(Kernels, RefuseATargetOutOfReachAndOneThatIsNotFinite) {
  const RobotModel robot = kr210(true);
  const ArmKernel arm{robot, code()};
  const JointVector q = (JointVector(6) << 0.2, -1.4, 1.5, 0.3, 0.8, 0.1).finished();
  Eigen::Isometry3d X = forward_kinematics(robot, q);
  X.translation() *= 10;
  EXPECT_EQ(arm.inverse_near(X, q).error(), PoseInverseFault::DidNotConverge);
  X.translation().x() = NAN;
  EXPECT_EQ(arm.inverse_near(X, q).error(), PoseInverseFault::NotFinite);
  EXPECT_EQ(arm.inverse_near(forward_kinematics(robot, q), JointVector::Constant(6, INFINITY)).error(),
            PoseInverseFault::NotFinite);
}

TEST_P(Kernels, InvertFromASingularSeed) {
  const RobotModel robot = kr210(false);
  const JointVector singular = (JointVector(6) << 0.2, -1.4, 1.5, 0.3, 0, 0.1).finished();
  const JointVector q = (JointVector(6) << 0.25, -1.3, 1.4, 0.3, 0.4, 0.2).finished();
  const Eigen::Isometry3d X = forward_kinematics(robot, q);
  const auto solution = ArmKernel{robot, code()}.inverse_near(X, singular);
  ASSERT_TRUE(solution.has_value());
  EXPECT_LT((forward_kinematics(robot, solution->q).translation() - X.translation()).norm(), 1e-8);
}

/// Every instruction set is a test of its own above; here the choice.
TEST(BestKernels, AreThoseOfTheBestInstructionSetOfTheMachine) {
  for (const Isa isa : {Isa::Avx512, Isa::Avx2, Isa::Baseline}) {
    if (!kernels::available(isa)) continue;
    EXPECT_EQ(&kernels::best(), &kernels::kernels_for(isa));
    break;
  }
  EXPECT_TRUE(kernels::available(Isa::Baseline));
}

TEST_P(Kernels, LeaveTheTriangularFactorOfATallMatrix) {
  Random random{19};
  for (const auto& [rows, columns] : {std::pair{8, 1}, {16, 7}, {96, 27}, {640, 36}, {48, 48}}) {
    Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
    if (columns > 10) A.col(3) = A.col(7);  // dependent
    if (columns > 20) A.col(5).setZero();
    A.bottomRows(3).setZero();
    Eigen::MatrixXd work = A;
    Eigen::VectorXd room(rows + 2 * columns);
    code().triangulate(work.data(), rows, rows, columns, room.data(), nullptr);
    const Eigen::MatrixXd R = work.topRows(columns).triangularView<Eigen::Upper>();
    const Eigen::MatrixXd expected = A.transpose() * A;
    EXPECT_LT((R.transpose() * R - expected).cwiseAbs().maxCoeff(), 1e-13 * (1 + expected.norm()));
    // And not from the products: what depends is zero to rounding, not to its root.
    EXPECT_LT((R.col(7 % columns) - R.col((columns > 10 ? 3 : 7) % columns)).norm(), 1e-13 * R.norm());
  }
}

TEST_P(Kernels, EvaluateAndInvertAnArmWithoutAllocating) {
  Random random{13};
  const RobotModel robot = kr210(true);
  const JointVector q = random_joints(robot, random), seed = q.array() + 0.01;
  PoseAndJacobian at;
  const std::size_t before = allocations().value_or(0);
  const ArmKernel arm{robot, code()};
  arm.forward_with_jacobian(q, at);
  EXPECT_TRUE(arm.inverse_near(arm.forward(q), seed).has_value());
  EXPECT_EQ(allocations().value_or(0), before);
}

}  // namespace
}  // namespace truepose
