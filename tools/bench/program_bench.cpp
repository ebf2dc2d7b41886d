#include <benchmark/benchmark.h>

#include <cstdio>
#include <string>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "proto/krl/program.hpp"
#include "proto/krl/rewrite.hpp"
#include "tools/bench/jobs.hpp"
#include "tools/truepose/program_compensation.hpp"

namespace truepose::bench {
namespace {

constexpr int kPoints = 100'000;

struct ProgramFiles {
  std::string src = "DEF BIG()\n";
  std::string dat = "DEFDAT BIG\n";
};

std::string declaration(int k, const Eigen::Isometry3d& X_BF, const StatusTurn& at) {
  const Eigen::Vector3d abc_deg = kuka_abc_deg(X_BF.linear());
  const Eigen::Vector3d p_mm = X_BF.translation();
  char line[240];
  std::snprintf(line, sizeof line,
                "DECL E6POS XP%d={X %.3f,Y %.3f,Z %.3f,A %.4f,B %.4f,C %.4f,S %d,T %d,"
                "E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}\n",
                k, p_mm.x(), p_mm.y(), p_mm.z(), abc_deg.x(), abc_deg.y(), abc_deg.z(), at.status, at.turn);
  return line;
}

/// A program as a controller saves it: its positions in the data list, a motion to each.
ProgramFiles make_program() {
  const RobotModel nominal = kr210(false);
  const auto inverse = StatusTurnInverse::of(nominal).value();
  ProgramFiles files;
  Random random{6};
  const std::vector<JointVector> joints = random_poses(nominal, kPoints, random);
  for (int k = 0; k < kPoints; ++k) {
    const JointVector& q = joints[static_cast<std::size_t>(k)];
    files.dat += declaration(k, forward_kinematics(nominal, q), inverse.of_joints(q));
    files.src += "PTP XP" + std::to_string(k) + "\n";
  }
  files.src += "END\n";
  files.dat += "ENDDAT\n";
  return files;
}

// Neither tool nor base.
const krl::StartFrames kAtFlange{Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()};

/// Texts in, texts out.
void program(benchmark::State& state) {
  static const ProgramFiles files = make_program();
  const RobotModel nominal = kr210(false), real = kr210(true);
  const auto inverse = StatusTurnInverse::of(nominal).value();
  double corrected = 0;
  for (auto _ : state) {
    const auto read = krl::read_program({files.src, files.dat, {}}, kAtFlange).value();
    const auto done = tools::compensate_program(read, nominal, inverse, real).value();
    benchmark::DoNotOptimize(krl::rewritten(files.src, done.src_edits));
    benchmark::DoNotOptimize(krl::rewritten(files.dat, done.dat_edits));
    corrected = static_cast<double>(done.changes.size());
  }
  state.counters["corrected"] = corrected;
}

BENCHMARK(program)->Name("program/truepose")->Iterations(1);

}  // namespace
}  // namespace truepose::bench
