#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <utility>

#include "core/calibrate/calibrate.hpp"
#include "core/fit/placement.hpp"
#include "core/quality/cramer_rao.hpp"
#include "tools/experiment/comparisons.hpp"
#include "tools/experiment/particle_swarm.hpp"
#include "tools/experiment/reference_methods.hpp"
#include "tools/experiment/trial.hpp"

namespace truepose {
namespace {

enum class Start { Unaided, FromGuess };

struct Method {
  std::string name;
  TrialData data;
  Start start = Start::Unaided;
  CalibrateOptions options = {};
  bool knows_gross_errors = false;  ///< the oracle: outliers are taken out before the fit
  /// How all is fitted from a guess of base and reflectors, where not by calibrate().
  std::function<ReferenceFit(const CalibratedCell&, const MeasurementData&)> fit = {};
};

/// All parameters in one stage.
LeastSquaresProblem whole_problem(const CalibratedCell& guess, const MeasurementData& data) {
  return {.points = data.points,
          .free = first_parameters(ParameterLayout::of(guess).size()),
          .W = {},
          .prior = {}};
}

ReferenceFit three_whole_steps(const CalibratedCell& guess, const MeasurementData& data) {
  return {.coarse = {}, .fine = gauss_newton_in_whole_steps(guess, whole_problem(guess, data), 3)};
}

ReferenceFit with_line_search(const CalibratedCell& guess, const MeasurementData& data) {
  return {.coarse = {}, .fine = *gauss_newton_by(StepSolver::Orthogonal, guess, whole_problem(guess, data))};
}

ReferenceFit by_particle_swarm(const CalibratedCell& guess, const MeasurementData& data) {
  const CalibratedCell start = particle_swarm_start(guess.robot, data.smr_names, data.points);
  return fit_by(ReferenceMethod::LeastSquares, start, data);
}

ReferenceFit by_ridge(const CalibratedCell& guess, const MeasurementData& data) {
  return fit_by(ReferenceMethod::Ridge, placement(guess.robot, data.smr_names, data.points), data);
}

std::vector<Method> all_methods() {
  using enum TrialData;
  const CalibrateOptions plain{.loss = Loss::Squared, .prior = PriorUse::Off, .check_model = false};
  const auto by = [](ReferenceMethod method) {
    return [method](const CalibratedCell& guess, const MeasurementData& data) {
      return fit_by(method, guess, data);
    };
  };
  const auto with = [&](Loss loss) {
    CalibrateOptions options = plain;
    options.loss = loss;
    return options;
  };
  CalibrateOptions with_prior = plain;
  with_prior.prior = PriorUse::On;
  return {
      {.name = "one stage, three whole steps", .data = Noisy, .fit = three_whole_steps},
      {.name = "one stage, with a line search", .data = Noisy, .fit = with_line_search},
      {.name = "least-squares", .data = Noisy, .fit = by(ReferenceMethod::LeastSquares)},
      {.name = "gauss-newton", .data = Noisy, .fit = by(ReferenceMethod::GaussNewton)},
      {.name = "levenberg-marquardt", .data = Noisy, .fit = by(ReferenceMethod::LevenbergMarquardt)},
      {"two-stage from the guess", Noisy, Start::FromGuess, plain},
      {.name = "particle-swarm", .data = Noisy, .fit = by_particle_swarm},
      {.name = "ridge", .data = Noisy, .fit = by_ridge},
      {"two-stage with prior", Noisy, Start::Unaided, with_prior},
      {"two-stage", Noisy, Start::Unaided, plain},
      {"two-stage", NoiseFree, Start::Unaided, plain},
      // The oracle comes first of those with outliers: the others are measured against it.
      {"oracle", GrossErrors, Start::Unaided, plain, true},
      {"two-stage", GrossErrors, Start::Unaided, plain},
      {"two-stage, screened", GrossErrors, Start::Unaided, with(Loss::OutlierRejection)},
      {"robust two-stage (huber)", GrossErrors, Start::Unaided, with(Loss::Huber)},
      {"robust two-stage (igg3)", GrossErrors, Start::Unaided, with(Loss::Igg3)},
      {"robust two-stage (tukey)", GrossErrors, Start::Unaided, with(Loss::Tukey)},
  };
}

/// What becomes of a method's trials.
struct MethodTally {
  std::vector<Eigen::Vector3d> errors;
  std::vector<double> times_s;
  std::vector<double> convergence_mm, first_errors_mm;  // of the first trial
  int converged = 0, fitted = 0;
  int iterations = 0;
  int near_oracle = 0;
};

MeasurementData points_to_fit(const SimulatedCampaign& campaign, bool without_gross) {
  MeasurementData data{.smr_names = campaign.data.smr_names};
  for (std::size_t i = 0; i < campaign.data.points.size(); ++i) {
    if (campaign.data.points[i].set != PoseSet::Identify || (without_gross && campaign.gross[i])) continue;
    data.points.push_back(campaign.data.points[i]);
  }
  return data;
}

std::vector<Eigen::Vector3d> errors_at_validation(const CalibratedCell& cell,
                                                  const SimulatedCampaign& campaign) {
  std::vector<Eigen::Vector3d> errors;
  for (std::size_t i = 0; i < campaign.data.points.size(); ++i) {
    const Measurement& point = campaign.data.points[i];
    if (point.set == PoseSet::Validate) errors.push_back(cell.predict(point.q, 0) - campaign.p_true_mm[i]);
  }
  return errors;
}

std::vector<double> lengths(const std::vector<Eigen::Vector3d>& errors) {
  std::vector<double> lengths_mm;
  for (const Eigen::Vector3d& error : errors) lengths_mm.push_back(error.norm());
  return lengths_mm;
}

/// One method in one trial.
struct MethodRun {
  double time_s = 0;
  bool converged = false;
  int iterations = 0;
  std::vector<double> convergence_mm;
  std::vector<Eigen::Vector3d> errors;  // empty where there is no fit

  double rms_mm() const { return error_statistics(errors).rms; }
};

MethodRun run_of(const ReferenceFit& fit, double time_s, const SimulatedCampaign& campaign) {
  const bool one_stage = fit.coarse.iterations == 0;
  const FitResult whole = joined(fit.coarse, fit.fine);
  return {.time_s = time_s,
          .converged = fit.fine.converged && (one_stage || fit.coarse.converged),
          .iterations = whole.iterations,
          .convergence_mm = whole.rms_mm,
          .errors = errors_at_validation(whole.cell, campaign)};
}

MethodRun run_of(const Calibration& fit, double time_s, const SimulatedCampaign& campaign) {
  MethodRun run{.time_s = time_s,
                .converged = fit.converged,
                .iterations = fit.coarse_iterations + fit.fine_iterations,
                .convergence_mm = fit.coarse_rms_mm,
                .errors = errors_at_validation(fit.cell, campaign)};
  std::ranges::copy(fit.fine_rms_mm, std::back_inserter(run.convergence_mm));
  return run;
}

MethodRun run(const Method& method, const RobotModel& nominal, const Trial& trial,
              const SimulatedCampaign& campaign, const ExperimentHooks& hooks) {
  const MeasurementData data = points_to_fit(campaign, method.knows_gross_errors);
  const auto now_s = [&] { return hooks.clock_s ? hooks.clock_s() : 0; };
  const double begin_s = now_s();
  if (method.fit) {
    const ReferenceFit fit = method.fit(trial.guess, data);
    return run_of(fit, now_s() - begin_s, campaign);
  }
  CalibrateOptions options = method.options;
  if (method.start == Start::FromGuess) options.start = trial.guess;
  const auto fit = calibrate(nominal, data, options);
  const double time_s = now_s() - begin_s;
  return fit ? run_of(*fit, time_s, campaign) : MethodRun{.time_s = time_s};
}

/// Every method in one trial.
struct TrialRuns {
  double bound_mm = 0;
  std::vector<MethodRun> of_method;
};

TrialRuns run_all(const std::vector<Method>& methods, const RobotModel& nominal,
                  const ExperimentOptions& options, int index, const ExperimentHooks& hooks) {
  const Trial trial = draw_trial(nominal, options, index);
  std::map<TrialData, SimulatedCampaign> campaigns;
  for (const auto data : {TrialData::NoiseFree, TrialData::Noisy, TrialData::GrossErrors})
    campaigns.emplace(data, measure_trial(trial, options, data));
  TrialRuns runs{
      .bound_mm = cramer_rao_rms_mm(trial.truth, trial.identify, trial.validate, reading_sigma_mm(options))};
  for (const Method& method : methods)
    runs.of_method.push_back(run(method, nominal, trial, campaigns.at(method.data), hooks));
  return runs;
}

void add(const MethodRun& run, MethodTally& tally) {
  if (tally.times_s.empty()) {
    tally.convergence_mm = run.convergence_mm;
    tally.first_errors_mm = lengths(run.errors);
  }
  tally.times_s.push_back(run.time_s);
  if (run.errors.empty()) return;
  // A method that fails in half of the trials must not look best by the other half.
  tally.converged += run.converged;
  tally.fitted += 1;
  tally.iterations += run.iterations;
  tally.errors.insert(tally.errors.end(), run.errors.begin(), run.errors.end());
}

/// The value that a share of them lies below.
double quantile(std::vector<double>& values, double share) {
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, place);
  return *place;
}

std::array<double, 3> quartiles_mm(const std::vector<Eigen::Vector3d>& errors) {
  std::vector<double> lengths_mm = lengths(errors);
  return {quantile(lengths_mm, 0.25), quantile(lengths_mm, 0.5), quantile(lengths_mm, 0.75)};
}

MethodResult result_of(const Method& method, MethodTally& tally, int trials, double bound_rms_mm) {
  MethodResult result{.method = method.name,
                      .data = method.data,
                      .converged = static_cast<double>(tally.converged) / trials,
                      .time_s = quantile(tally.times_s, 0.5),
                      .convergence_mm = std::move(tally.convergence_mm),
                      .errors_mm = std::move(tally.first_errors_mm)};
  if (tally.fitted == 0) return result;
  result.validation = error_statistics(tally.errors);
  result.quartiles_mm = quartiles_mm(tally.errors);
  result.iterations = static_cast<double>(tally.iterations) / tally.fitted;
  if (method.data != TrialData::NoiseFree) result.rmse_over_bound = result.validation->rms / bound_rms_mm;
  if (method.data == TrialData::GrossErrors)
    result.within_2_percent_of_oracle = static_cast<double>(tally.near_oracle) / trials;
  return result;
}

}  // namespace

MethodComparison compare_methods(const RobotModel& nominal, const ExperimentOptions& options,
                                 const ExperimentHooks& hooks) {
  const std::vector<Method> methods = all_methods();
  std::vector<TrialRuns> trials(static_cast<std::size_t>(options.trials));
  run_trials(options.trials, hooks, "methods", [&](int index) {
    trials[static_cast<std::size_t>(index)] = run_all(methods, nominal, options, index, hooks);
  });

  std::vector<MethodTally> tallies(methods.size());
  double bound_squares = 0;
  for (const TrialRuns& trial : trials) {
    bound_squares += trial.bound_mm * trial.bound_mm;
    double oracle_mm = 0;
    for (std::size_t k = 0; k < methods.size(); ++k) {
      const MethodRun& run = trial.of_method[k];
      add(run, tallies[k]);
      if (run.errors.empty()) continue;
      if (methods[k].knows_gross_errors) oracle_mm = run.rms_mm();
      tallies[k].near_oracle += methods[k].data == TrialData::GrossErrors && run.rms_mm() <= 1.02 * oracle_mm;
    }
  }

  MethodComparison comparison{.bound_rms_mm = std::sqrt(bound_squares / options.trials)};
  for (std::size_t k = 0; k < methods.size(); ++k)
    comparison.methods.push_back(result_of(methods[k], tallies[k], options.trials, comparison.bound_rms_mm));
  return comparison;
}

}  // namespace truepose
