#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "core/calibrate/calibrate.hpp"
#include "core/fit/regression_field.hpp"
#include "core/math/angles.hpp"
#include "tools/experiment/comparisons.hpp"
#include "tools/experiment/regression_methods.hpp"
#include "tools/experiment/trial.hpp"

namespace truepose {
namespace {

/// An arm with its errors, measured: the poses to identify, then the fresh targets.
struct MeasuredArm {
  TrueArmSetup setup;
  SimulatedCampaign campaign;
  std::size_t identify = 0;  // poses of the campaign that identify
  std::uint64_t seed = 0;

  std::span<const Measurement> targets() const { return std::span{campaign.data.points}.subspan(identify); }
};

constexpr const char *kGeometric = "geometric", *kDeviationAuto = "non-geometric auto";

/// What a calibration may know of. An arm without weight has no terms of gravity, and points without
/// directions none of approach.
struct ModelLayer {
  std::string name;
  CalibrateOptions options;
  bool weight = false;
  bool directions = false;
  std::vector<const RegressionMethod*> fields;  ///< each on top of it, a layer of its own
};

std::vector<ModelLayer> model_layers() {
  const CalibrateOptions geometric{.check_model = false};
  const CalibrateOptions harmonics{.non_geometric = true, .check_model = false};
  const CalibrateOptions no_harmonics{.non_geometric = true, .harmonics = {}, .check_model = false};
  return {{.name = kGeometric,
           .options = geometric,
           .fields = {kRegressionMethods.begin(), kRegressionMethods.end()}},
          {.name = "compliance", .options = no_harmonics, .weight = true},
          {.name = "harmonics", .options = harmonics},
          {.name = "compliance and harmonics", .options = harmonics, .weight = true},
          {.name = kDeviationAuto,
           .options = harmonics,
           .weight = true,
           .directions = true,
           .fields = {&kGaussianProcess}}};
}

/// Errors of one layer over all arms.
struct LayerErrors {
  std::vector<Eigen::Vector3d> stood, model;
};

/// ErrorsByLayer by the layer's name, in the order in which the layers first came.
class ErrorsByLayer {
 public:
  LayerErrors& operator[](const std::string& name) {
    const auto known = std::ranges::find(tallies_, name, &Named::first);
    return known != tallies_.end() ? known->second : tallies_.emplace_back(name, LayerErrors{}).second;
  }

  /// Appends the errors of other arms.
  void add(const ErrorsByLayer& others) {
    for (const auto& [name, errors] : others.tallies_) {
      LayerErrors& mine = (*this)[name];
      mine.stood.insert(mine.stood.end(), errors.stood.begin(), errors.stood.end());
      mine.model.insert(mine.model.end(), errors.model.begin(), errors.model.end());
    }
  }

  void append_results(const LayerResult& common, std::vector<LayerResult>& results) const {
    for (const auto& [name, tally] : tallies_) {
      if (tally.stood.empty()) continue;
      LayerResult result = common;
      result.layer = name;
      result.validation = error_statistics(tally.stood);
      if (!tally.model.empty()) result.model_rms_mm = error_statistics(tally.model).rms;
      results.push_back(std::move(result));
    }
  }

 private:
  using Named = std::pair<std::string, LayerErrors>;
  std::deque<Named> tallies_;  // references into it stay valid
};

MeasuredArm measured_arm(const Trial& trial, const ExperimentOptions& options, NonGeometricErrors errors) {
  MeasuredArm arm{
      .setup = true_arm(trial, options), .identify = trial.identify.size(), .seed = trial.noise_seed};
  arm.setup.non_geometric = std::move(errors);
  arm.campaign = measure_campaign(arm.setup, trial.identify, trial.validate,
                                  {.tracker_noise_mm = options.tracker_noise_mm, .seed = trial.noise_seed});
  return arm;
}

/// The first poses of the campaign, to identify from.
MeasurementData first_poses(const MeasuredArm& arm, int poses) {
  const auto& points = arm.campaign.data.points;
  return {arm.campaign.data.smr_names, {points.begin(), points.begin() + poses}};
}

MeasurementData without_directions(MeasurementData data) {
  for (Measurement& point : data.points) point.direction.clear();
  return data;
}

RobotModel weightless(RobotModel robot) {
  robot.gravity_B.setZero();
  return robot;
}

/// What the model predicts at the targets, against where the arm stood and where it stands on average.
void add_predictions(const CalibratedCell& cell, const MeasuredArm& arm, LayerErrors& tally) {
  for (std::size_t i = 0; i < arm.targets().size(); ++i) {
    const Measurement& target = arm.targets()[i];
    const Eigen::Vector3d predicted = cell.predict(target.q, 0, target.direction);
    tally.stood.push_back(predicted - arm.campaign.p_stood_mm[arm.identify + i]);
    tally.model.push_back(predicted - arm.campaign.p_true_mm[arm.identify + i]);
  }
}

/// The arm driven to the targets by the inverted model, and where that is asked for from there by the
/// tracker. A target is the point where the nominal arm would be.
void add_driven(const Calibration& fit, const MeasuredArm& measured, const ExperimentOptions& options,
                LayerErrors& inverted, LayerErrors* in_the_loop) {
  Random seeds{measured.seed};
  TrueArm arm{measured.setup, seeds.next()};
  Random noise{seeds.next()};
  for (const Measurement& target : measured.targets()) {
    const Eigen::Vector3d wanted = fit.coarse.predict(target.q, 0);
    const auto q = joints_for_reflector(fit.cell, wanted, target.q, target.direction);
    if (!q) continue;  // stretched out, the arm does not reach everything that the nominal one does
    arm.move_to(*q);
    inverted.stood.push_back(arm.p_WS_mm(*q) - wanted);
    if (!in_the_loop) continue;
    const Eigen::Vector3d stood =
        approach_with_tracker(arm, fit.cell, wanted, *q, {.noise_mm = options.tracker_noise_mm}, noise);
    in_the_loop->stood.push_back(stood - wanted);
  }
}

void add_repeatability(const MeasuredArm& arm, LayerErrors& tally) {
  for (std::size_t i = arm.identify; i < arm.campaign.p_true_mm.size(); ++i)
    tally.stood.push_back(arm.campaign.p_true_mm[i] - arm.campaign.p_stood_mm[i]);
}

/// A residual field over what the model leaves. It is kept whether or not it helps, so cross-validation is
/// spared.
void add_field(CalibratedCell cell, const RegressionMethod& method, const MeasurementData& data,
               const MeasuredArm& arm, LayerErrors& tally) {
  const FieldData left = field_data(cell, data.points);
  const auto regressor = fit_regressor(method, left.regression);
  if (!regressor) return;
  cell.robot.field = std::make_shared<RegressionField>(cell.robot, *regressor, left.p_F_mm);
  add_predictions(cell, arm, tally);
}

/// One arm through all layers, identified from its first poses.
void add_arm(const RobotModel& nominal, const MeasuredArm& arm, int poses, const ExperimentOptions& options,
             ErrorsByLayer& tallies) {
  const MeasurementData all = first_poses(arm, poses);
  for (const ModelLayer& layer : model_layers()) {
    const MeasurementData data = layer.directions ? all : without_directions(all);
    const auto fit = calibrate(layer.weight ? nominal : weightless(nominal), data, layer.options);
    if (!fit) continue;
    if (layer.name == kGeometric) {
      add_predictions(fit->coarse, arm, tallies["nominal"]);
      LayerErrors& inverted = tallies["inverted"];
      add_driven(*fit, arm, options, inverted, &tallies["tracker in the loop"]);
    }
    if (layer.name == kDeviationAuto)
      add_driven(*fit, arm, options, tallies["inverted, non-geometric auto"], nullptr);
    add_predictions(fit->cell, arm, tallies[layer.name]);
    for (const RegressionMethod* method : layer.fields) {
      LayerErrors& tally = tallies[layer.name + " and " + std::string(method->name)];
      add_field(fit->cell, *method, data, arm, tally);
    }
  }
  add_repeatability(arm, tallies["repeatability alone"]);
}

/// Poses enough for the largest campaign, and fresh targets.
ExperimentOptions with_layer_poses(ExperimentOptions options) {
  options.identify_poses = std::ranges::max(options.layer_poses);
  options.validate_poses = options.layer_targets;
  return options;
}

}  // namespace

std::vector<LayerResult> compare_layers(const RobotModel& nominal, const ExperimentOptions& options,
                                        const ExperimentHooks& hooks) {
  struct Case {
    bool rigid;
    double backlash_deg;
    int poses;
  };
  std::vector<Case> cases;
  for (const double backlash_deg : options.backlash_deg)
    for (const int poses : options.layer_poses) cases.push_back({false, backlash_deg, poses});
  cases.push_back({true, 0, std::ranges::min(options.layer_poses)});

  const ExperimentOptions set_up = with_layer_poses(options);
  const int trials = std::clamp(options.trials / 4, 1, options.layer_trials);
  std::vector<ErrorsByLayer> of_arms(cases.size() * static_cast<std::size_t>(trials));
  run_trials(static_cast<int>(of_arms.size()), hooks, "layers", [&](int arm) {
    const Case& c = cases[static_cast<std::size_t>(arm / trials)];
    const Trial trial = draw_trial(nominal, set_up, arm % trials);
    NonGeometricErrors errors;
    if (!c.rigid)
      errors = heavy_arm_errors({.backlash_rad = c.backlash_deg * kRadPerDeg, .seed = trial.noise_seed});
    add_arm(nominal, measured_arm(trial, set_up, std::move(errors)), c.poses, options,
            of_arms[static_cast<std::size_t>(arm)]);
  });
  std::vector<LayerResult> results;
  auto arm = of_arms.begin();
  for (const Case& c : cases) {
    ErrorsByLayer tallies;
    for (int index = 0; index < trials; ++index) tallies.add(*arm++);
    tallies.append_results({.rigid = c.rigid, .poses = c.poses, .backlash_deg = c.backlash_deg}, results);
  }
  return results;
}

}  // namespace truepose
