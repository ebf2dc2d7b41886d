#include <benchmark/benchmark.h>

#include "core/identify/calibrate.hpp"
#include "core/identify/least_squares_solver.hpp"
#include "tools/bench/ceres_fit.hpp"
#include "tools/bench/jobs.hpp"

namespace truepose::bench {
namespace {

/// Runs the fit from the same start each time, problem building included, and checks where it ended.
template <typename Fit>
void identify(benchmark::State& state, Fit fit) {
  const Identification job = identification(static_cast<int>(state.range(0)));
  CalibratedCell cell;
  for (auto _ : state) cell = fit(job);
  if (!(rms_mm(cell, job.points) < kDone_mm)) state.SkipWithError("did not reach 1e-9 mm");
}

void identify_auto(benchmark::State& state) { identify(state, fit_ceres_auto); }
void identify_tuned(benchmark::State& state) { identify(state, fit_ceres_tuned); }
void identify_truepose(benchmark::State& state) {
  identify(state, [](const Identification& job) {
    const LeastSquaresProblem problem{.points = job.points, .free = job.free, .W = {}, .prior = {}};
    return gauss_newton(job.start, problem).cell;
  });
}

/// All that `truepose calibrate` asks for by default: the check of the model, both stages, what the poses
/// leave open, the uncertainty of parameters and predictions.
void calibrate_truepose(benchmark::State& state) {
  identify(state, [](const Identification& job) {
    const MeasurementData data{.smr_names = {job.start.reflectors.front().name}, .points = job.points};
    const auto calibration = calibrate(job.start.robot, data);
    return calibration ? calibration->cell : job.start;
  });
}

void points(benchmark::internal::Benchmark* job) { job->Arg(30)->Arg(100)->Arg(300)->Arg(1000); }
BENCHMARK(identify_auto)->Name("identify/ceres_auto")->Apply(points);
BENCHMARK(identify_tuned)->Name("identify/ceres_tuned")->Apply(points);
BENCHMARK(identify_truepose)->Name("identify/truepose")->Apply(points);
BENCHMARK(calibrate_truepose)->Name("calibrate/truepose")->Apply(points);

}  // namespace
}  // namespace truepose::bench
