#include "core/fit/normal_equations.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/arm/arm_kernel.hpp"
#include "core/arm/guide.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/fit/identifiability.hpp"
#include "core/fit/least_squares_solver.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/reweighted_steps.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/random.hpp"
#include "tests/allocations.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/on_every_isa.hpp"

namespace truepose {
namespace {

using example::kArms;
using example::kEveryIsa;
using example::kr210;
using example::OnEveryIsa;
using example::random_arm;
using example::random_joints;

class NormalEquationsByKernels : public OnEveryIsa {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, NormalEquationsByKernels, kEveryIsa, example::isa_name);

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
      if (random.next() % 10 == 0) W.setZero();  // an outlier
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
    if (turns) continue;
    for (const GuideMotion& motion : kGuideMotions) robot.deviation.push_back({i, motion.basis, 2, 0});
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
        W *
        (predict_with_jacobian(cell, point.q, point.smr, J, point.direction, point.station) - point.p_WS_mm);
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

TEST_P(NormalEquationsByKernels, AreThoseOfTheReferenceForEveryParameter) {
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

/// The points are seen from three stations in turn.
void add_stations(Problem& at, Random& random) {
  at.start.further_bases = {BasePose::of(pose_from_kuka({-900, 2500, 400}, {-70, 8, 12})),
                            BasePose::of(pose_from_kuka({1200, 4100, -300}, {20, -5, 160}))};
  for (std::size_t n = 0; n < at.points.size(); ++n) {
    Measurement& point = at.points[n];
    point.station = static_cast<int>(n % 3);
    point.p_WS_mm = inverse_of(at.start.station_pose(point.station)) * point.p_WS_mm;
  }
  add_deviations(at, random);
  add_prior(at, random);
}

TEST(Linearise, SaysOfSeveralStationsWhatThePlainKinematicsSay) {
  Random random{19};
  Problem at = problem(random_arm("RRRRRR", random), 2, 70, 0.1, random);
  add_stations(at, random);
  const LeastSquaresProblem wanted = at.of(all_parameters(at.start), Weighed::ByMatrix);
  const LinearSystem expected = reference(at.start, wanted), actual = linearise(at.start, wanted);
  EXPECT_LT((actual.f - expected.f).cwiseAbs().maxCoeff(), 1e-10);
  const Eigen::VectorXd norm = column_norms(expected.J).cwiseInverse();
  EXPECT_LT(((actual.J - expected.J) * norm.asDiagonal()).cwiseAbs().maxCoeff(), 1e-13);
}

TEST_P(NormalEquationsByKernels, AreThoseOfTheReferenceForSeveralStations) {
  Random random{20};
  for (const int reflectors : {1, 3}) {
    for (const int count : {8, 33, 100}) {
      Problem at = problem(random_arm("RRPRRR", random), reflectors, count, 0.1, random);
      add_stations(at, random);
      expect_normal_equations(at, all_parameters(at.start), code());
    }
  }
}

TEST_P(NormalEquationsByKernels, AreThoseOfTheReferenceForAnySelectionOfParameters) {
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

TEST_P(NormalEquationsByKernels, TakeOtherWeightsAndDeviationsForPreparedPoints) {
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

TEST_P(NormalEquationsByKernels, EndTheFitWhereTheLineSearchEndsIt) {
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

TEST_P(NormalEquationsByKernels, EndTheFitOfDeviationsUnderAPriorThereToo) {
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

TEST_P(NormalEquationsByKernels, LeaveAFitThatDoesNotDescendToTheLineSearchAndEndOthersAtAMinimum) {
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

TEST_P(NormalEquationsByKernels, FitWithoutAllocatingInAnIteration) {
  Random random{12};
  Problem at = problem(kr210(false), 2, 80, 0.05, random);
  add_deviations(at, random);
  const LeastSquaresProblem wanted = at.of(kept_parameters(at), Weighed::ByMatrix);
  const auto allocated = [&](int iterations) {
    const std::size_t before = allocations().value_or(0);
    const auto fit = gauss_newton_by(StepSolver::NormalEquations, at.start, wanted,
                                     {.max_iterations = iterations}, code());
    EXPECT_EQ(fit.value().iterations, iterations);
    return allocations().value_or(0) - before;
  };
  EXPECT_EQ(allocated(3), allocated(1));
}

TEST_P(NormalEquationsByKernels, LeaveAFitWithDependentColumnsToTheLineSearch) {
  Random random{10};
  const Problem at = problem(kr210(false), 1, 80, 0.05, random);
  const LeastSquaresProblem wanted = at.of(all_parameters(at.start), Weighed::Alike);
  EXPECT_FALSE(gauss_newton_by(StepSolver::NormalEquations, at.start, wanted, {}, code()));
  EXPECT_EQ(gauss_newton(at.start, wanted).solver, StepSolver::Orthogonal);
}

/// Some steps under weights that change. Which solver took each in a fit of its own.
std::vector<StepSolver> expect_steps_of_fits(const Problem& at, const LeastSquaresProblem& wanted,
                                             Random& random) {
  ReweightedSteps steps(at.start, wanted);
  std::vector<StepSolver> solvers;
  for (int step = 0; step < 3; ++step) {
    LeastSquaresProblem weighted = wanted;
    std::vector<double> weights(at.points.size());
    for (std::size_t i = 0; i < weights.size(); ++i) {
      weights[i] = random.next() % 5 == 0 ? 0 : random.uniform(0.1, 1);
      weighted.W[i] *= std::sqrt(weights[i]);
    }
    const FitResult expected = gauss_newton(steps.cell(), weighted, {.max_iterations = 1});
    steps.step(weights, wanted.prior);
    EXPECT_EQ(parameter_values(steps.cell()), parameter_values(expected.cell)) << "step " << step;
    const Eigen::VectorXd f = residuals(expected.cell, at.points);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const Eigen::Vector3d r = f.segment<3>(3 * static_cast<Eigen::Index>(i));
      EXPECT_EQ(steps.lengths_mm()[i], (wanted.W[i] * r).norm()) << "step " << step << ", point " << i;
    }
    solvers.push_back(expected.solver);
  }
  return solvers;
}

TEST(ReweightedSteps, GoWhereOneIterationOfAFitGoesWhetherOrNotWholeStepsDescend) {
  Random random{19};
  std::ptrdiff_t whole = 0, searched = 0;
  for (int trial = 0; trial < 30; ++trial) {
    SCOPED_TRACE(trial);
    Problem at = problem(kr210(false), 2, 40, 0.05, random);
    const std::vector<int> geometry = kept_parameters(at);
    if (trial % 2 == 0) add_deviations(at, random);
    // Torques that are computed by the links that move.
    if (trial % 4 == 0) at.start.robot.torque_joints.clear();
    if (trial % 3 == 0) add_prior(at, random);
    for (Joint& joint : at.start.robot.joints) joint.theta_rad += trial % 5 * 0.3 * random.uniform(-1, 1);
    const auto solvers = expect_steps_of_fits(at, at.of(geometry, Weighed::ByMatrix), random);
    whole += std::ranges::count(solvers, StepSolver::NormalEquations);
    searched += std::ranges::count(solvers, StepSolver::Orthogonal);
  }
  EXPECT_GT(whole, 0);
  EXPECT_GT(searched, 0);
}

TEST(ReweightedSteps, GoThereWithDependentColumnsToo) {
  Random random{20};
  const Problem at = problem(kr210(false), 1, 80, 0.05, random);
  expect_steps_of_fits(at, at.of(all_parameters(at.start), Weighed::ByNumber), random);
}

}  // namespace
}  // namespace truepose
