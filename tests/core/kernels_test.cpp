#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/arm/arm_kernel.hpp"
#include "core/identify/calibrated_cell.hpp"
#include "core/identify/identifiability.hpp"
#include "core/identify/least_squares_solver.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/identify/normal_equations.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/random.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/malloc_count.hpp"

namespace truepose {
namespace {

using example::random_joints;
using kernels::Isa;

/// An arm of `types` (R or P) with everything that could go wrong: betas, both signs, a turned flange.
RobotModel random_arm(const std::string& types, Random& random) {
  RobotModel robot;
  for (const char type : types) {
    const bool revolute = type == 'R';
    robot.joints.push_back({.type = revolute ? JointType::Revolute : JointType::Prismatic,
                            .a_mm = random.uniform(-500, 500),
                            .alpha_rad = random.uniform(-2, 2),
                            .d_mm = random.uniform(-500, 500),
                            .theta_rad = random.uniform(-3, 3),
                            .beta_rad = random.uniform(-0.2, 0.2),
                            .sign = random.uniform() < 0.5 ? -1. : 1.,
                            .min = revolute ? -2.5 : -800,
                            .max = revolute ? 2.5 : 800});
  }
  robot.X_flange = pose_from_kuka({random.uniform(-100, 100), random.uniform(-100, 100), 80}, {30, -50, 110});
  return robot;
}

const std::vector<std::string> kArms{"RRRRRR", "RRRRRRR",   "PRRRRRR", "RRRRRRRR",        "RPR",
                                     "P",      "RRPRRRPRR", "R",       "RRRRRRRRRRRRRRRR"};

/// The KR 210 R2700-2 and, in `calibrated`, the errors of the method's paper (table 2).
RobotModel kr210(bool calibrated) {
  const double rows[6][11] = {{0, 0, 645, 0, -1, 0.45, 0.003, 0.72, 0.0015, 0, 185},
                              {330, -90, 0, 0, 1, 0.63, 0.002, 0.43, 0.0032, 0, 70},
                              {1150, 0, 0, -90, 1, 0.55, 0.003, 0.21, 0.0026, 0.001, 120},
                              {115, -90, 1220, 0, -1, 0.32, 0.006, 0.32, 0.0018, 0, 350},
                              {0, 90, 0, 0, 1, 0.72, 0.004, 0.51, 0.0012, 0, 125},
                              {0, -90, 215, 180, -1, 0.23, 0.005, 0.62, 0.0022, 0, 350}};
  RobotModel robot;
  for (const auto& row : rows) {
    const double on = calibrated ? 1 : 0;
    robot.joints.push_back({.a_mm = row[0] + on * row[5],
                            .alpha_rad = row[1] * kRadPerDeg + on * row[6],
                            .d_mm = row[2] + on * row[7],
                            .theta_rad = row[3] * kRadPerDeg + on * row[8],
                            .beta_rad = on * row[9],
                            .sign = row[4],
                            .min = -row[10] * kRadPerDeg,
                            .max = row[10] * kRadPerDeg});
  }
  robot.joints[1].min = -140 * kRadPerDeg;
  robot.joints[1].max = -5 * kRadPerDeg;
  return robot;
}

/// What every instruction set of this machine must say alike.
class Kernels : public testing::TestWithParam<Isa> {
 protected:
  void SetUp() override {
    if (!kernels::available(GetParam())) GTEST_SKIP() << "this machine or build has no such instruction set";
  }
  const kernels::Kernels& code() const { return kernels::kernels_for(GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(EveryIsa, Kernels, testing::Values(Isa::Baseline, Isa::Avx2, Isa::Avx512),
                         [](const auto& isa) {
                           return isa.param == Isa::Baseline ? "Baseline"
                                  : isa.param == Isa::Avx2   ? "Avx2"
                                                             : "Avx512";
                         });

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
#ifdef __SANITIZE_ADDRESS__
  constexpr int kTargets = 1000;
#else
  constexpr int kTargets = 10000;
#endif
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

TEST_P(Kernels, ProjectAndJudgeCandidatePosesAsEigenDoes) {
  constexpr std::size_t kCandidates = 24, kColumns = 39;
  constexpr int kBlocks = kCandidates / kernels::kMostLanes;
  Random random{21};
  Candidates3 rows{kCandidates, 3 * kColumns}, X{kCandidates, 9}, Y{kCandidates, 9}, V{kCandidates, 6},
      W{kCandidates, 6}, gain{kCandidates, 1};
  for (kernels::Line& line : rows.lines)
    for (double& value : line.value) value = random.normal();
  using Columns = Eigen::Matrix<double, kColumns, 3, Eigen::RowMajor>;
  const Columns U = Columns::NullaryExpr([&] { return random.normal(); });
  const Columns P = Columns::NullaryExpr([&] { return random.normal(); });
  const auto A = [&](std::size_t k) {
    Eigen::Matrix<double, 3, kColumns> out;
    for (std::size_t i = 0; i < 3 * kColumns; ++i)
      out(static_cast<Eigen::Index>(i / kColumns), static_cast<Eigen::Index>(i % kColumns)) =
          rows.at(k, i, 3 * kColumns);
    return out;
  };
  code().project(rows.data(), kBlocks, kColumns, U.data(), X.data());
  code().project(rows.data(), kBlocks, kColumns, P.data(), Y.data());
  code().add_products(X.data(), X.data(), 0.5, kBlocks, V.data());
  code().add_products(X.data(), Y.data(), 2.0, kBlocks, W.data());
  const auto near = [](double value, double expected) {
    return std::abs(value - expected) <= 1e-11 * (1 + std::abs(expected));
  };

  code().volume_gains(V.data(), kBlocks, gain.data());
  for (std::size_t k = 0; k < kCandidates; ++k) {
    const Eigen::Matrix3d AU = A(k) * U;
    for (std::size_t i = 0; i < 9; ++i)
      EXPECT_PRED2(near, X.at(k, i, 9),
                   AU(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)));
    const Eigen::Matrix3d S = Eigen::Matrix3d::Identity() + AU * AU.transpose();
    EXPECT_PRED2(near, gain.at(k, 0, 1), S.determinant());
  }
  code().variance_gains(V.data(), W.data(), kBlocks, gain.data());
  for (std::size_t k = 0; k < kCandidates; ++k) {
    const Eigen::Matrix3d AU = A(k) * U, AP = A(k) * P;
    const Eigen::Matrix3d S = Eigen::Matrix3d::Identity() + AU * AU.transpose();
    const Eigen::Matrix3d sum = 2 * (AU * AP.transpose() + AP * AU.transpose());
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

/// How much the points of a problem count.
enum class Weighed { Alike, ByNumber, ByMatrix };

/// A cell with points of every reflector in turn, off by `noise_mm` from what a cell moved a little would
/// show.
struct Problem {
  CalibratedCell start;
  std::vector<Measurement> points;
  Prior prior{};

  LeastSquaresProblem of(std::vector<int> free, Weighed weighed, std::uint64_t seed = 1) const {
    LeastSquaresProblem out{.points = points, .free = std::move(free), .W = {}, .prior = prior};
    Random random{seed};
    while (weighed != Weighed::Alike && out.W.size() < points.size()) {
      Eigen::Matrix3d W = random.uniform(0.2, 1) * Eigen::Matrix3d::Identity();
      if (weighed == Weighed::ByMatrix)
        W += Eigen::Matrix3d::NullaryExpr([&](auto, auto) { return random.uniform(-0.1, 0.1); });
      if (random.next() % 10 == 0) W.setZero();  // a gross error
      out.W.push_back(W);
    }
    return out;
  }
};

Problem problem(const RobotModel& robot, int reflectors, int count, double noise_mm, Random& random) {
  Problem out;
  out.start.robot = robot;
  out.start.base = BasePose::of(pose_from_kuka({3000, -1500, -200}, {130, 4, -3}));
  for (int k = 0; k < reflectors; ++k)
    out.start.reflectors.push_back({std::to_string(k), {40. + 70 * k, -30. + 90 * (k % 2), 60}});
  Eigen::VectorXd step(ParameterLayout::of(out.start).size());
  for (Eigen::Index i = 0; i < step.size(); ++i) step[i] = 1e-3 * random.normal();
  for (const int i : {0, 1, 2, 6, 7, 8}) step[i] *= 1000;
  const CalibratedCell truth = moved(out.start, step);
  for (int n = 0; n < count; ++n) {
    Measurement point{.q = random_joints(robot, random),
                      .smr = static_cast<int>(random.next() % static_cast<std::uint64_t>(reflectors))};
    point.p_WS_mm = truth.predict(point.q, point.smr);
    for (double& x : point.p_WS_mm) x += noise_mm * random.normal();
    out.points.push_back(point);
  }
  return out;
}

std::vector<int> all_parameters(const CalibratedCell& cell) {
  std::vector<int> free(static_cast<std::size_t>(ParameterLayout::of(cell).size()));
  std::iota(free.begin(), free.end(), 0);
  return free;
}

constexpr Weighed kWeighed[] = {Weighed::Alike, Weighed::ByNumber, Weighed::ByMatrix};

/// Every joint of `robot` deviates, in all the ways there are.
void add_deviations(Problem& at, Random& random) {
  RobotModel& robot = at.start.robot;
  robot.torque_joints = robot.joints;
  for (int i = 0; i < robot.joint_count(); ++i) {
    const bool turns = robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
    robot.deviation.push_back({i, turns ? DeviationBasis::Sine : DeviationBasis::Scale, 1, 0});
    robot.deviation.push_back({i, DeviationBasis::Approach, 1, 0});
    if (turns) robot.deviation.push_back({i, DeviationBasis::Weight, robot.joint_count() + 1, 0});
  }
  for (DeviationTerm& term : robot.deviation) term.coefficient = 1e-3 * random.normal();
  for (Measurement& point : at.points) {
    for (int i = 0; i < robot.joint_count(); ++i) point.direction.push_back(random.uniform() < 0.5 ? -1 : 1);
  }
}

/// Something is known of every second parameter.
void add_prior(Problem& at, Random& random) {
  const int size = ParameterLayout::of(at.start).size();
  at.prior.centre =
      parameter_values(at.start) + Eigen::VectorXd::NullaryExpr(size, [&] { return 0.01 * random.normal(); });
  at.prior.weight =
      Eigen::VectorXd::NullaryExpr(size, [&](Eigen::Index k) { return k % 2 == 0 ? 0.5 : 0.0; });
}

/// linearise() point by point, by the plain kinematics.
LinearSystem reference(const CalibratedCell& cell, const LeastSquaresProblem& problem) {
  const auto points = static_cast<Eigen::Index>(problem.points.size());
  std::vector<int> known;
  for (const int k : problem.free)
    if (problem.prior.weight.size() > 0 && problem.prior.weight[k] > 0) known.push_back(k);
  const auto rows = 3 * points + static_cast<Eigen::Index>(known.size());
  LinearSystem out{Eigen::VectorXd::Zero(rows),
                   Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(problem.free.size()))};
  PointJacobian J;
  for (Eigen::Index n = 0; n < points; ++n) {
    const auto i = static_cast<std::size_t>(n);
    const Measurement& point = problem.points[i];
    const Eigen::Matrix3d W = problem.W.empty() ? Eigen::Matrix3d::Identity() : problem.W[i];
    out.f.segment<3>(3 * n) =
        W * (predict_with_jacobian(cell, point.q, point.smr, J, point.direction) - point.p_WS_mm);
    out.J.middleRows<3>(3 * n) = W * J(Eigen::all, problem.free);
  }
  const Eigen::VectorXd values = parameter_values(cell);
  for (std::size_t i = 0; i < known.size(); ++i) {
    const Eigen::Index row = 3 * points + static_cast<Eigen::Index>(i);
    const double weight = problem.prior.weight[known[i]];
    out.f[row] = weight * (values[known[i]] - problem.prior.centre[known[i]]);
    out.J(row, std::ranges::find(problem.free, known[i]) - problem.free.begin()) = weight;
  }
  return out;
}

void expect_normal_equations(const CalibratedCell& cell, const LeastSquaresProblem& wanted,
                             PreparedPoints& points) {
  const LinearSystem expected = reference(cell, wanted);
  NormalEquations equations(cell, points, wanted.free, wanted.prior);
  equations.evaluate(cell);
  const Eigen::VectorXd norm = column_norms(expected.J).cwiseInverse();
  const Eigen::MatrixXd difference = equations.matrix() - expected.J.transpose() * expected.J;
  EXPECT_LT((norm.asDiagonal() * difference * norm.asDiagonal()).cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::VectorXd of_gradient = equations.gradient() - expected.J.transpose() * expected.f;
  EXPECT_LT(norm.cwiseProduct(of_gradient).cwiseAbs().maxCoeff(), 1e-12 * expected.f.norm());
  EXPECT_NEAR(equations.cost(), expected.f.squaredNorm(), 1e-12 * expected.f.squaredNorm());
}

void expect_normal_equations(const Problem& at, const std::vector<int>& free, const kernels::Kernels& code) {
  for (const Weighed weighed : kWeighed) {
    const LeastSquaresProblem wanted = at.of(free, weighed);
    PreparedPoints points(at.start.robot, at.points, static_cast<int>(at.start.reflectors.size()), wanted.W,
                          code);
    expect_normal_equations(at.start, wanted, points);
  }
}

TEST_P(Kernels, LeaveTheTriangularFactorOfATallMatrix) {
  Random random{19};
  for (const auto& [rows, columns] : {std::pair{8, 1}, {16, 7}, {96, 27}, {640, 36}, {48, 48}}) {
    Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
    if (columns > 10) A.col(3) = A.col(7);  // dependent
    if (columns > 20) A.col(5).setZero();
    A.bottomRows(3).setZero();
    Eigen::MatrixXd work = A;
    Eigen::VectorXd room(rows);
    code().triangulate(work.data(), rows, rows, columns, room.data());
    const Eigen::MatrixXd R = work.topRows(columns).triangularView<Eigen::Upper>();
    const Eigen::MatrixXd expected = A.transpose() * A;
    EXPECT_LT((R.transpose() * R - expected).cwiseAbs().maxCoeff(), 1e-13 * (1 + expected.norm()));
    // And not from the products: what depends is zero to rounding, not to its root.
    EXPECT_LT((R.col(7 % columns) - R.col((columns > 10 ? 3 : 7) % columns)).norm(), 1e-13 * R.norm());
  }
}

TEST(Linearise, SaysWhatThePlainKinematicsSayOfEveryParameter) {
  Random random{18};
  for (const std::string& types : kArms) {
    for (const bool deviates : {false, true}) {
      SCOPED_TRACE(types + (deviates ? ", deviating" : ""));
      Problem at = problem(random_arm(types, random), 3, 70, 0.1, random);
      if (deviates) add_deviations(at, random);
      add_prior(at, random);
      const LeastSquaresProblem wanted = at.of(all_parameters(at.start), Weighed::ByMatrix);
      const LinearSystem expected = reference(at.start, wanted), actual = linearise(at.start, wanted);
      EXPECT_LT((actual.f - expected.f).cwiseAbs().maxCoeff(), 1e-10);
      const Eigen::VectorXd norm = column_norms(expected.J).cwiseInverse();
      EXPECT_LT(((actual.J - expected.J) * norm.asDiagonal()).cwiseAbs().maxCoeff(), 1e-13);
      const Eigen::VectorXd unweighed = residuals(at.start, at.points);
      const LinearSystem alike = reference(at.start, at.of(all_parameters(at.start), Weighed::Alike));
      EXPECT_LT((unweighed - alike.f.head(unweighed.size())).cwiseAbs().maxCoeff(), 1e-10);
    }
  }
}

TEST_P(Kernels, SumTheNormalEquationsOfTheReferenceForEveryParameter) {
  Random random{6};
  for (const std::string& types : kArms) {
    for (const int reflectors : {1, 3}) {
      for (const int count : {1, 8, 31, 33, 100}) {
        const Problem at = problem(random_arm(types, random), reflectors, count, 0.1, random);
        expect_normal_equations(at, all_parameters(at.start), code());
      }
    }
  }
}

TEST_P(Kernels, SumTheNormalEquationsOfAnySelectionOfParameters) {
  Random random{7};
  for (int trial = 0; trial < 50; ++trial) {
    Problem at = problem(random_arm("RRPRRR", random), 2, 40, 0.1, random);
    if (trial % 2 == 0) add_deviations(at, random);
    if (trial % 3 == 0) add_prior(at, random);
    std::vector<int> free;
    for (const int k : all_parameters(at.start))
      if (random.uniform() < 0.4) free.push_back(k);
    expect_normal_equations(at, free, code());
  }
}

TEST_P(Kernels, TakeOtherWeightsAndDeviationsForPreparedPoints) {
  Random random{8};
  Problem at = problem(kr210(false), 2, 40, 0.1, random);
  add_deviations(at, random);
  PreparedPoints points(at.start.robot, at.points, 2, {}, code());
  for (const Weighed weighed : {Weighed::ByMatrix, Weighed::ByNumber, Weighed::Alike}) {
    for (DeviationTerm& term : at.start.robot.deviation) term.coefficient = 1e-3 * random.normal();
    const LeastSquaresProblem wanted = at.of(all_parameters(at.start), weighed);
    points.reweight(wanted.W);
    expect_normal_equations(at.start, wanted, points);
  }
}

std::vector<int> kept_parameters(const Problem& at) {
  const ParameterLayout layout = ParameterLayout::of(at.start);
  std::vector<int> geometry(static_cast<std::size_t>(layout.deviation(0)));
  std::iota(geometry.begin(), geometry.end(), 0);
  return identifiability(linearise(at.start, at.of(geometry, Weighed::Alike)).J,
                         conventional_preference({layout.reflectors, layout.joints, 0}))
      .kept;
}

/// By both ways from the same start.
void expect_same_end(const Problem& at, const LeastSquaresProblem& wanted, const kernels::Kernels& code,
                     Random& random) {
  const FitResult expected = gauss_newton_by(StepSolver::Orthogonal, at.start, wanted).value();
  const auto actual = gauss_newton_by(StepSolver::NormalEquations, at.start, wanted, {}, code);
  ASSERT_TRUE(expected.converged);
  ASSERT_TRUE(actual.has_value());
  EXPECT_TRUE(actual->converged);
  for (int k = 0; k < 100; ++k) {
    const JointVector q = random_joints(at.start.robot, random);
    EXPECT_LT((actual->cell.predict(q, 0) - expected.cell.predict(q, 0)).norm(), 1e-9);
  }
}

TEST_P(Kernels, EndTheFitWhereTheLineSearchEndsIt) {
  Random random{9};
  for (const double noise_mm : {0., 0.05, 0.5}) {
    for (const int reflectors : {1, 3}) {
      for (const Weighed weighed : kWeighed) {
        SCOPED_TRACE(testing::Message() << noise_mm << " mm, " << reflectors << " reflectors, weighed "
                                        << static_cast<int>(weighed));
        const Problem at = problem(kr210(false), reflectors, 80, noise_mm, random);
        expect_same_end(at, at.of(kept_parameters(at), weighed), code(), random);
      }
    }
  }
}

TEST_P(Kernels, EndTheFitOfDeviationsUnderAPriorThereToo) {
  Random random{17};
  for (const Weighed weighed : kWeighed) {
    SCOPED_TRACE(static_cast<int>(weighed));
    Problem at = problem(kr210(false), 2, 120, 0.02, random);
    const std::vector<int> geometry = kept_parameters(at);
    add_deviations(at, random);
    add_prior(at, random);
    LeastSquaresProblem wanted = at.of(geometry, weighed);
    const ParameterLayout layout = ParameterLayout::of(at.start);
    for (int t = 0; t < layout.deviations; ++t) {
      wanted.free.push_back(layout.deviation(t));
      wanted.prior.weight[layout.deviation(t)] = 20;
    }
    expect_same_end(at, wanted, code(), random);
  }
}

TEST_P(Kernels, LeaveAFitThatDoesNotDescendToTheLineSearchAndEndOthersAtAMinimum) {
  Random random{15};
  int left = 0, ended = 0;
  for (int trial = 0; trial < 60; ++trial) {
    Problem at = problem(kr210(false), 1, 40, 0.05, random);
    const LeastSquaresProblem wanted = at.of(kept_parameters(at), Weighed::Alike);
    for (Joint& joint : at.start.robot.joints) joint.theta_rad += random.uniform(-1, 1);
    const auto fit = gauss_newton_by(StepSolver::NormalEquations, at.start, wanted, {}, code());
    left += !fit;
    if (!fit || !fit->converged) continue;
    ++ended;
    for (std::size_t k = 1; k < fit->rms_mm.size(); ++k)
      EXPECT_LE(fit->rms_mm[k], fit->rms_mm[k - 1] + 1e-9) << "step " << k;
    const LinearSystem end = linearise(fit->cell, wanted);
    const Eigen::VectorXd slope = end.J.transpose() * end.f;
    EXPECT_LT(column_norms(end.J).cwiseInverse().cwiseProduct(slope).norm(), 1e-4 * end.f.norm());
  }
  EXPECT_GT(left, 0);
  EXPECT_GT(ended, 0);
}

TEST_P(Kernels, FitWithoutAllocatingInAnIteration) {
  Random random{12};
  Problem at = problem(kr210(false), 2, 80, 0.05, random);
  add_deviations(at, random);
  const LeastSquaresProblem wanted = at.of(kept_parameters(at), Weighed::ByMatrix);
  const auto allocated = [&](int iterations) {
    const std::size_t before = malloc_count().value_or(0);
    const auto fit = gauss_newton_by(StepSolver::NormalEquations, at.start, wanted,
                                     {.max_iterations = iterations}, code());
    EXPECT_EQ(fit.value().iterations, iterations);
    return malloc_count().value_or(0) - before;
  };
  EXPECT_EQ(allocated(3), allocated(1));
}

TEST_P(Kernels, LeaveAFitWithDependentColumnsToTheLineSearch) {
  Random random{10};
  const Problem at = problem(kr210(false), 1, 80, 0.05, random);
  const LeastSquaresProblem wanted = at.of(all_parameters(at.start), Weighed::Alike);
  EXPECT_FALSE(gauss_newton_by(StepSolver::NormalEquations, at.start, wanted, {}, code()));
  EXPECT_EQ(gauss_newton(at.start, wanted).solver, StepSolver::Orthogonal);
}

TEST_P(Kernels, EvaluateAndInvertAnArmWithoutAllocating) {
  Random random{13};
  const RobotModel robot = kr210(true);
  const JointVector q = random_joints(robot, random), seed = q.array() + 0.01;
  PoseAndJacobian at;
  const std::size_t before = malloc_count().value_or(0);
  const ArmKernel arm{robot, code()};
  arm.forward_with_jacobian(q, at);
  EXPECT_TRUE(arm.inverse_near(arm.forward(q), seed).has_value());
  EXPECT_EQ(malloc_count().value_or(0), before);
}

}  // namespace
}  // namespace truepose
