#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/math/statistics.hpp"
#include "core/simulate/measurement_campaign.hpp"

namespace truepose {

/// How far off a method that needs a first guess of base and reflector starts: each coordinate uniform within
/// plus and minus these.
struct GuessError {
  double base_mm = 1000;
  double base_rad = 1.0;
  double smr_mm = 300;
};

struct ExperimentOptions {
  std::uint64_t seed = 0;
  int trials = 200;  ///< each with a placement, poses and noise of its own
  int identify_poses = 30;
  int validate_poses = 30;
  double tracker_noise_mm = kTrackerNoise_mm;
  double repeatability_mm = kRepeatability_mm;
  GrossErrors gross{.fraction = 0.05};
  GuessError guess;
  int design_candidates = 2000;
  int layer_trials = 10;  ///< arms with non-geometric errors, each with gears of its own; at most a quarter
                          ///< of the trials, but one
  int layer_targets = 200;
  std::vector<int> layer_poses{30, 60, 100};
  std::vector<double> backlash_deg{0, 0.002};
};

/// What the readings of a method's trials suffer from.
enum class TrialData { NoiseFree, Noisy, GrossErrors };

/// One method over all trials. Errors are against the true positions at validation poses, pooled over all
/// trials with a fit, whether it converged or not.
struct MethodResult {
  std::string method;
  TrialData data = TrialData::Noisy;
  std::optional<ErrorStatistics> validation;  ///< where any trial had a fit
  /// A quarter, half and three quarters of the same errors are smaller.
  std::optional<std::array<double, 3>> quartiles_mm;
  double rmse_over_bound = 0;             ///< of the Cramer-Rao bound of the same trials; 0 without noise
  double converged = 0;                   ///< share of the trials
  double iterations = 0;                  ///< mean
  double time_s = 0;                      ///< median of one fit
  double within_2_percent_of_oracle = 0;  ///< share of the trials; with outliers alone, else 0
  /// RMS of the points to identify before each iteration of the first trial, coarse stage and then fine one.
  std::vector<double> convergence_mm;
  std::vector<double> errors_mm;  ///< of the first trial, at each validation pose
};

/// One way to choose the poses, all fitted by the two-stage method.
struct DesignResult {
  std::string design;  ///< "random", "d-optimal", "i-optimal"
  int poses = 0;
  double rms_mm = 0;  ///< over the poses of a task and the trials
  double max_mm = 0;  ///< of the task's worst pose, mean over the trials
};

/// One layer of the model (or of the compensation), on an arm with non-geometric errors or without.
struct LayerResult {
  std::string layer;
  bool rigid = false;  ///< purely geometric arm
  int poses = 0;       ///< that identified
  double backlash_deg = 0;
  ErrorStatistics validation;  ///< against where the arm stood at fresh targets, its repeatability included
  double model_rms_mm = 0;     ///< against where it stands on average
};

/// A figure of the paper, with its counterpart here.
struct PublishedComparison {
  std::string figure;  ///< what was measured
  std::string source;  ///< where the paper prints it
  double published_mean_mm = 0;
  std::string explanation;  ///< how our own figure came about, one sentence
  double mean_mm = 0;
};

struct ExperimentResult {
  double bound_rms_mm = 0;  ///< Cramer-Rao bound of the two-stage trials
  std::vector<MethodResult> methods;
  std::vector<DesignResult> designs;
  std::vector<LayerResult> layers;
  std::vector<PublishedComparison> published;
};

/// What the outside lends to a computation that knows neither clock nor terminal. Both functions may be
/// empty.
struct ExperimentHooks {
  std::function<double()> clock_s;  ///< seconds of the calling thread; without it all times are 0
  /// Share of it done, 0 to 1; called by one thread at a time.
  std::function<void(double share, std::string_view doing)> progress;
  int jobs = 1;  ///< threads that it may use
};

/// Compares all methods on the same seeded trials of the paper's simulated arm, random poses with optimal
/// ones, and the layers beyond geometry. The same options give the same result with any number of jobs, times
/// excepted.
///
/// @param nominal  the data sheet's arm: six revolute joints of a KR 210, whose true errors are the published
///                 ones
/// @return the tables, or one sentence on why the arm does not fit the experiment
std::expected<ExperimentResult, std::string> run_experiment(const RobotModel& nominal,
                                                            const ExperimentOptions& options,
                                                            const ExperimentHooks& hooks = {});

}  // namespace truepose
