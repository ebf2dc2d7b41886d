#include <benchmark/benchmark.h>

#include <Eigen/LU>
#include <limits>

#include "core/plan/optimal_design.hpp"
#include "tools/bench/jobs.hpp"

// Choosing 50 of 2000 poses, one by one, for the greatest determinant of the information of 39 parameters.

namespace truepose::bench {
namespace {

constexpr int kCandidates = 2000, kPoses = 50;

const DesignProblem& problem() {
  static const DesignProblem once = [] {
    const CalibratedCell cell = identification(30).start;
    const std::vector<JointVector> poses = joint_positions(kCandidates);
    return DesignProblem{cell, poses, std::vector{poses.front()}, {.repeatability_mm = 0.05}};
  }();
  return once;
}

using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;

const std::vector<Rows>& rows() {
  static const std::vector<Rows> once = [] {
    std::vector<Rows> all;
    for (std::size_t k = 0; k < kCandidates; ++k) all.push_back(problem().rows(k));
    return all;
  }();
  return once;
}

/// Takes the best candidate `kPoses` times.
/// @param gain  of a candidate, by its rows
/// @param take  gets the rows of the best one
template <typename Gain, typename Take>
std::vector<std::size_t> greedily(Gain gain, Take take) {
  std::vector<std::size_t> chosen;
  std::vector<bool> is_chosen(kCandidates);
  while (chosen.size() < kPoses) {
    std::size_t best = 0;
    double best_gain = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < kCandidates; ++k) {
      if (is_chosen[k]) continue;
      if (const double g = gain(rows()[k]); g > best_gain) {
        best = k;
        best_gain = g;
      }
    }
    is_chosen[best] = true;
    chosen.push_back(best);
    take(rows()[best]);
  }
  return chosen;
}

std::vector<std::size_t> naive() {
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(problem().parameters(), problem().parameters());
  Eigen::MatrixXd with;
  return greedily(
      [&](const Rows& A) {
        with = M;
        with.noalias() += A.transpose() * A;
        // The logarithm: the determinant itself leaves the range of a double.
        return with.partialPivLu().matrixLU().diagonal().array().abs().log().sum();
      },
      [&](const Rows& A) { M.noalias() += A.transpose() * A; });
}

std::vector<std::size_t> rank_three() {
  Eigen::MatrixXd C = Eigen::MatrixXd::Identity(problem().parameters(), problem().parameters());
  Rows AC;
  return greedily(
      [&](const Rows& A) {
        AC.noalias() = A * C;
        return (Eigen::Matrix3d::Identity() + AC * A.transpose()).determinant();
      },
      [&](const Rows& A) {
        const Eigen::MatrixXd CA = C * A.transpose();
        const Eigen::Matrix3d S = Eigen::Matrix3d::Identity() + A * CA;
        C -= CA * S.inverse() * CA.transpose();
      });
}

std::vector<std::size_t> ours() {
  Design design{problem(), DesignCriterion::D};
  add_greedily(design, kPoses);
  return design.chosen();
}

void choose(benchmark::State& state, std::vector<std::size_t> (*way)()) {
  if (way() != ours()) state.SkipWithError("chooses other poses");
  for (auto _ : state) benchmark::DoNotOptimize(way());
}

void design_naive(benchmark::State& state) { choose(state, naive); }
void design_rank_three(benchmark::State& state) { choose(state, rank_three); }
void design_truepose(benchmark::State& state) { choose(state, ours); }
BENCHMARK(design_naive)->Name("design/naive")->Iterations(1);
BENCHMARK(design_rank_three)->Name("design/rank_three");
BENCHMARK(design_truepose)->Name("design/truepose");

}  // namespace
}  // namespace truepose::bench
