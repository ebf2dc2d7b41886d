#include "core/calibration/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/calibration/gauss_newton.hpp"
#include "core/calibration/identifiability.hpp"
#include "core/calibration/levenberg_marquardt.hpp"
#include "core/calibration/linear_start.hpp"
#include "core/calibration/model_sanity.hpp"
#include "core/calibration/particle_swarm.hpp"
#include "core/calibration/ridge.hpp"
#include "core/calibration/robust_fit.hpp"
#include "core/compensation/regression_field.hpp"
#include "core/kernels/fast_gauss_newton.hpp"
#include "core/kinematics/angles.hpp"

namespace truepose {
namespace {

constexpr int kFewestPoses = 5;
/// The arm counts as not excited where the prediction elsewhere is so many times worse than one measurement.
constexpr double kPoorTransfer = 4;
constexpr int kTransferPoses = 200;
constexpr int kMaxReweightings = 20;

std::vector<int> first_parameters(int count) {
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

std::optional<CalibrationError> unusable(const RobotModel& arm, std::span<const std::string> smr_names,
                                         std::span<const Measurement> points) {
  for (const Measurement& point : points) {
    if (point.q.size() == arm.joint_count() && point.q.allFinite() && point.p_WS_mm.allFinite()) continue;
    return CalibrationError{CalibrationFault::NotFinite,
                            "row " + std::to_string(point.row) + " holds a number that is not finite"};
  }
  for (std::size_t k = 0; k < smr_names.size(); ++k) {
    if (std::ranges::any_of(points,
                            [k](const Measurement& m) { return static_cast<std::size_t>(m.smr) == k; }))
      continue;
    return CalibrationError{CalibrationFault::TooFewPoses,
                            "reflector '" + smr_names[k] + "' has no point to identify it from"};
  }
  const int poses = count_poses(points);
  if (poses >= kFewestPoses) return std::nullopt;
  return CalibrationError{CalibrationFault::TooFewPoses,
                          std::to_string(poses) + " poses to identify from; base and reflector alone need " +
                              std::to_string(kFewestPoses)};
}

std::optional<CalibrationError> not_separable(const CalibratedCell& cell,
                                              const LeastSquaresProblem& problem) {
  const Eigen::MatrixXd J = linearise(cell, problem).J;
  const std::vector<std::string> all = parameter_names(cell);
  const std::vector<std::string> names(all.begin(), all.begin() + J.cols());
  const NullSpace open = null_space(J, names, Eigen::VectorXd::Ones(J.cols()),
                                    Eigen::VectorXd::Constant(J.cols(), std::numeric_limits<double>::max()));
  if (open.rank == J.cols()) return std::nullopt;
  std::string sentences;
  for (const Combination& combination : open.unknown) {
    sentences += (sentences.empty() ? "" : "; ") + combination.sentence;
  }
  return CalibrationError{CalibrationFault::NotSeparable,
                          sentences + ": measure poses whose flange orientations differ about all axes"};
}

std::vector<Eigen::Matrix3d> scaled(std::vector<Eigen::Matrix3d> W, std::span<const double> weights) {
  W.resize(weights.size(), Eigen::Matrix3d::Identity());
  for (std::size_t i = 0; i < weights.size(); ++i) W[i] *= std::sqrt(weights[i]);
  return W;
}

/// One identification: the stages one after the other, each leaving what the next needs.
class Identification {
 public:
  Identification(const RobotModel& nominal, const MeasurementData& data, const CalibrateOptions& options)
      : nominal_{nominal},
        data_{data},
        options_{options},
        points_{points_of(data, PoseSet::Identify)},
        whitening_{whitening_of(points_, options.noise)},
        anisotropic_{std::ranges::any_of(
            whitening_.W,
            [](const Eigen::Matrix3d& W) { return W != Eigen::Matrix3d::Identity() * W(0, 0); })},
        weights_(points_.size(), 1.0) {
    result_.method = options.method;
  }

  std::expected<Calibration, CalibrationError> run() {
    if (auto error = unusable(nominal_, data_.smr_names, points_)) return std::unexpected(*error);
    if (auto error = fit_base_and_reflectors()) return std::unexpected(*error);
    if (options_.check_model) {
      if (auto suspicion = suspect(nominal_, data_)) {
        return std::unexpected(CalibrationError{CalibrationFault::WrongModel, suspicion->sentence});
      }
    }
    if (auto error = fit_geometry()) return std::unexpected(*error);
    if (options_.deviation) fit_deviations();
    if (!options_.residual.empty()) {
      if (auto error = fit_residual()) return std::unexpected(*error);
    }
    describe();
    return std::move(result_);
  }

  std::optional<CalibrationError> fit_base_and_reflectors() {
    const CalibratedCell start = coarse_start();
    LeastSquaresProblem problem = weighted(first_parameters(ParameterLayout::of(start).link(0)));
    if (options_.loss != Loss::Squared) {
      const double sigma = robust_fit(start, problem).sigma_mm;
      weights_ = point_weights(start, points_, whitening_.W, Loss::Tukey, sigma);
      problem = weighted(problem.free);
    }
    const FitResult fit = solve(start, problem, options_.max_coarse_iterations);
    if (auto error = not_separable(fit.cell, problem)) return error;
    result_.coarse = fit.cell;
    result_.coarse_iterations = fit.iterations;
    result_.coarse_rms_mm = fit.rms_mm;
    result_.converged = fit.converged;
    return std::nullopt;
  }

  const CalibratedCell& coarse() const { return result_.coarse; }

 private:
  LeastSquaresProblem weighted(std::vector<int> free) const {
    return {.points = points_, .free = std::move(free), .W = scaled(whitening_.W, weights_), .prior = {}};
  }

  CalibratedCell coarse_start() const {
    if (options_.start) return *options_.start;
    if (options_.method == CalibrationMethod::ParticleSwarm)
      return particle_swarm_start(nominal_, data_.smr_names, points_);
    if (options_.loss != Loss::Squared) return robust_start(nominal_, data_.smr_names, points_, whitening_.W);
    return linear_start(nominal_, data_.smr_names, points_);
  }

  FitResult solve(const CalibratedCell& start, const LeastSquaresProblem& problem, int max_iterations) const {
    if (options_.method == CalibrationMethod::LevenbergMarquardt)
      return levenberg_marquardt(start, problem, {.max_iterations = max_iterations});
    return gauss_newton(
        start, problem,
        {.max_iterations = max_iterations, .line_search = options_.method != CalibrationMethod::GaussNewton});
  }

  /// The kernels' fit, where the problem is one that they know: geometry alone, points that differ by a
  /// factor.
  std::optional<FitResult> fast_fit(const CalibratedCell& start, const LeastSquaresProblem& problem,
                                    int max_iterations) const {
    if (!start.robot.deviation.empty() || problem.prior.weight.size() > 0 || anisotropic_)
      return std::nullopt;
    Eigen::VectorXd factors(static_cast<Eigen::Index>(problem.W.size()));
    for (std::size_t i = 0; i < problem.W.size(); ++i) {
      factors[static_cast<Eigen::Index>(i)] = problem.W[i](0, 0);
    }
    const PreparedPoints prepared(start.robot, problem.points, static_cast<int>(start.reflectors.size()),
                                  factors);
    return fast_gauss_newton(start, prepared, problem.free, {.max_iterations = max_iterations});
  }

  /// Parameters that are fitted where nothing but the data is known of them.
  std::vector<int> free_of(const Identifiability& known, int size) const {
    const bool two_stage =
        options_.method == CalibrationMethod::TwoStage || options_.method == CalibrationMethod::GaussNewton;
    return two_stage ? known.kept : first_parameters(size);
  }

  int equations() const {
    return 3 * static_cast<int>(std::ranges::count_if(weights_, [](double w) { return w > 0; }));
  }

  std::optional<CalibrationError> fit_geometry() {
    const ParameterLayout layout = ParameterLayout::of(result_.coarse);
    problem_ = weighted(first_parameters(layout.size()));
    const Identifiability known =
        identifiability(linearise(result_.coarse, problem_).J, conventional_preference(layout));
    result_.rank = known.rank;
    result_.rank_gap = known.gap;
    result_.condition = known.condition;
    if (equations() <= known.rank) {
      return CalibrationError{CalibrationFault::TooFewPoses,
                              std::to_string(equations() / 3) + " points give " +
                                  std::to_string(equations()) +
                                  " equations for at least as many parameters: measure more poses"};
    }
    problem_.free = free_of(known, layout.size());
    identified_ = known.kept;
    if (options_.method == CalibrationMethod::Ridge) {
      problem_.prior = ridge_prior(result_.coarse, problem_, options_.prior_scale);
    }
    fit_ = options_.loss == Loss::Squared ? solve(result_.coarse, problem_, options_.max_fine_iterations)
                                          : reweighted_fit(result_.coarse);
    result_.fine_iterations = fit_.iterations;
    result_.fine_rms_mm = fit_.rms_mm;
    assess();
    if (options_.method != CalibrationMethod::Ridge && prior_wanted()) use_prior();
    result_.converged = result_.converged && fit_.converged;
    result_.geometric = fit_.cell;
    describe_known(layout);
    return std::nullopt;
  }

  /// What the poses show of the geometry, and what they leave open.
  void describe_known(const ParameterLayout& layout) {
    LeastSquaresProblem all = weighted(first_parameters(layout.size()));
    const Eigen::MatrixXd J = linearise(fit_.cell, all).J;
    NullSpace open = null_space(J / uncertainty_.sigma0_mm, parameter_names(fit_.cell),
                                conventional_preference(layout), usual_deviation(layout));
    result_.unknown = std::move(open.unknown);
    result_.weak = std::move(open.weak);
    const Eigen::MatrixXd kept = J(Eigen::all, identified_);
    result_.observability =
        observability(kept * column_norms(kept).cwiseInverse().asDiagonal(), count_poses(points_));
  }

  /// The robust chain from a cell: weights from a redescending fit, then the plain fit under these weights.
  FitResult reweighted_fit(const CalibratedCell& start) {
    LeastSquaresProblem unweighted = problem_;
    unweighted.W = whitening_.W;
    const RobustFit robust = robust_fit(start, unweighted);
    FitResult fit{.cell = robust.cell};
    for (int i = 0; i < kMaxReweightings; ++i) {
      const std::vector<double> weights =
          point_weights(fit.cell, points_, whitening_.W, options_.loss, robust.sigma_mm);
      const bool settled = i > 0 && std::ranges::equal(weights, weights_, [](double a, double b) {
                             return std::abs(a - b) < 1e-6;
                           });
      if (settled) break;
      weights_ = weights;
      problem_.W = scaled(whitening_.W, weights_);
      FitResult next = solve(fit.cell, problem_, options_.max_fine_iterations);
      next.iterations += fit.iterations;
      next.rms_mm.insert(next.rms_mm.begin(), fit.rms_mm.begin(), fit.rms_mm.end());
      fit = std::move(next);
    }
    sigma_mm_ = robust.sigma_mm;
    return fit;
  }

  void assess() {
    uncertainty_ = uncertainty_of(linearise(fit_.cell, problem_), problem_,
                                  ParameterLayout::of(fit_.cell).size(), equations());
    if (transfer_poses_.empty()) transfer_poses_ = poses_within_limits(nominal_, kTransferPoses, 0);
    result_.transfer = transfer_uncertainty(fit_.cell, uncertainty_.covariance, transfer_poses_);
  }

  bool prior_wanted() const {
    if (options_.prior != PriorUse::Auto) return options_.prior == PriorUse::On;
    return !(result_.transfer.rms_mm <= kPoorTransfer * std::sqrt(3.0) * uncertainty_.sigma0_mm);
  }

  /// Refits with the prior, its width and the noise estimated from what they leave (expectation and
  /// maximisation).
  void use_prior() {
    result_.prior_used = true;
    const ParameterLayout layout = ParameterLayout::of(fit_.cell);
    const CalibratedCell nominal{nominal_, fit_.cell.base, fit_.cell.reflectors};
    PriorScale scale = options_.prior_scale;
    problem_.free = first_parameters(layout.size());
    FitResult fit{.cell = result_.coarse};
    for (int i = 0; i < 4; ++i) {
      problem_.prior = prior_of(nominal, scale, uncertainty_.sigma0_mm);
      fit = solve(fit.cell, problem_, options_.max_fine_iterations);
      result_.fine_iterations += fit.iterations;
      fit_ = fit;
      assess();
      const double width = deviation_in_priors();
      scale.length_mm = std::max(options_.prior_scale.length_mm, scale.length_mm * width);
      scale.angle_rad = std::max(options_.prior_scale.angle_rad, scale.angle_rad * width);
    }
    result_.prior_scale = scale;
  }

  /// Root mean square of the link errors in standard deviations of the prior, their uncertainty included.
  double deviation_in_priors() const {
    const ParameterLayout layout = ParameterLayout::of(fit_.cell);
    const Eigen::VectorXd values = parameter_values(fit_.cell);
    double sum = 0;
    const int links = ParameterLayout::kLink * layout.joints;
    for (int k = layout.link(0); k < layout.link(0) + links; ++k) {
      const double per_unit = problem_.prior.weight[k] / uncertainty_.sigma0_mm;
      const double off = values[k] - problem_.prior.centre[k];
      sum += per_unit * per_unit * (off * off + uncertainty_.covariance(k, k));
    }
    return std::sqrt(sum / links);
  }

  void fit_deviations() {
    const std::vector<DeviationGroup> groups = deviation_groups(nominal_, points_, options_.harmonics);
    result_.deviation = choose_deviation(fit_.cell, problem_, groups);
    if (result_.deviation->terms.empty()) return;

    CalibratedCell start = fit_.cell;
    start.robot.deviation = result_.deviation->terms;
    start.robot.torque_joints = nominal_.joints;
    const ParameterLayout layout = ParameterLayout::of(start);
    for (int t = 0; t < layout.deviations; ++t) problem_.free.push_back(layout.deviation(t));
    widen_prior(layout);
    fit_ = options_.loss == Loss::Squared ? solve(start, problem_, options_.max_fine_iterations)
                                          : reweighted_fit(start);
    assess();
    widen_prior(layout);  // with the noise that is left once the deviations are in
    fit_ = solve(fit_.cell, problem_, options_.max_fine_iterations);
    assess();
    result_.converged = result_.converged && fit_.converged;
  }

  /// The prior of the deviation terms, beside that of the links where one is used.
  void widen_prior(const ParameterLayout& layout) {
    const double before = problem_.prior.weight.size() > 0 ? 1.0 : 0.0;
    Prior prior{Eigen::VectorXd::Zero(layout.size()), Eigen::VectorXd::Zero(layout.size())};
    const int links = layout.link(layout.joints);
    if (before > 0) {
      prior.centre.head(links) = problem_.prior.centre.head(links);
      prior.weight.head(links) = problem_.prior.weight.head(links);
    }
    prior.weight.tail(layout.deviations).setConstant(uncertainty_.sigma0_mm / result_.deviation->scale);
    problem_.prior = std::move(prior);
  }

  std::optional<CalibrationError> fit_residual() {
    std::vector<Measurement> trusted;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (weights_[i] > 0) trusted.push_back(points_[i]);
    }
    const FieldData data = field_data(fit_.cell, trusted);
    auto selection = select_regressor(data.regression, options_.residual);
    if (!selection)
      return CalibrationError{CalibrationFault::TooFewPoses, "residual field: " + selection.error()};
    if (options_.residual.size() == 1 && !selection->regressor) {
      auto asked = fit_regressor(options_.residual.front(), data.regression);
      if (!asked) return CalibrationError{CalibrationFault::TooFewPoses, "residual field: " + asked.error()};
      selection->kind = options_.residual.front();
      selection->regressor = *asked;
    }
    if (selection->regressor) {
      fit_.cell.robot.field =
          std::make_shared<RegressionField>(fit_.cell.robot, selection->regressor, data.p_F_mm);
    }
    result_.residual = std::move(*selection);
    return std::nullopt;
  }

  void describe() {
    result_.cell = fit_.cell;
    result_.sigma0_mm = uncertainty_.sigma0_mm;
    result_.covariance = uncertainty_.covariance;
    describe_parameters();
    describe_rejected();
    for (const Measurement& m : data_.points) {
      const auto error = [&](const CalibratedCell& cell) -> Eigen::Vector3d {
        return cell.predict(m.q, m.smr, m.direction) - m.p_WS_mm;
      };
      result_.points.push_back({error(result_.coarse), error(result_.geometric), error(result_.cell)});
    }
    result_.identify = stage_errors(PoseSet::Identify);
    if (points_.size() < data_.points.size()) result_.validate = stage_errors(PoseSet::Validate);
  }

  /// The fit turns the base about the tracker's axes; what is printed are its Euler angles.
  Eigen::MatrixXd printed_covariance() const {
    Eigen::MatrixXd printed = uncertainty_.covariance;
    const Eigen::Matrix3d rates = angle_rates_zyx(fit_.cell.base.rxyz_rad).inverse();
    printed.middleRows<3>(3) = (rates * printed.middleRows<3>(3)).eval();
    printed.middleCols<3>(3) = (printed.middleCols<3>(3) * rates.transpose()).eval();
    return printed;
  }

  void describe_parameters() {
    const Eigen::MatrixXd printed = printed_covariance();
    const ParameterLayout layout = ParameterLayout::of(fit_.cell);
    const auto names = parameter_names(fit_.cell);
    const Eigen::VectorXd before = parameter_values(result_.coarse), after = parameter_values(fit_.cell);
    const bool all = problem_.free.size() > identified_.size() &&
                     options_.method != CalibrationMethod::TwoStage &&
                     options_.method != CalibrationMethod::GaussNewton;
    for (int k = 0; k < layout.size(); ++k) {
      const bool is_link = k >= layout.link(0) && k < layout.link(layout.joints);
      const bool is_term = k >= layout.link(layout.joints);
      result_.parameters.push_back(
          {.name = names[static_cast<std::size_t>(k)],
           .nominal = is_link ? before[k] : 0.0,
           .value = after[k],
           .sigma = std::sqrt(printed(k, k)),
           .identified = all || is_term || std::ranges::binary_search(identified_, k),
           .data_share = uncertainty_.data_share[k]});
    }
  }

  void describe_rejected() {
    std::size_t i = 0;
    for (std::size_t k = 0; k < data_.points.size(); ++k) {
      const Measurement& m = data_.points[k];
      if (m.set != PoseSet::Identify) continue;
      if (weights_[i] == 0) {
        const Eigen::Vector3d error = fit_.cell.predict(m.q, m.smr, m.direction) - m.p_WS_mm;
        const double whitened = whitening_.W.empty() ? error.norm() : (whitening_.W[i] * error).norm();
        result_.rejected.push_back({k, error.norm(), whitened / sigma_mm_});
      }
      ++i;
    }
  }

  StageErrors stage_errors(PoseSet set) const {
    std::vector<Eigen::Vector3d> before, geometric, after;
    for (std::size_t i = 0; i < data_.points.size(); ++i) {
      if (data_.points[i].set != set) continue;
      before.push_back(result_.points[i].before);
      geometric.push_back(result_.points[i].geometric);
      after.push_back(result_.points[i].after);
    }
    return {.poses = count_poses(points_of(data_, set)),
            .points = static_cast<int>(before.size()),
            .before = error_statistics(before),
            .geometric = error_statistics(geometric),
            .after = error_statistics(after)};
  }

  const RobotModel& nominal_;
  const MeasurementData& data_;
  const CalibrateOptions& options_;
  std::vector<Measurement> points_;
  Whitening whitening_;
  bool anisotropic_;             // a point's noise differs by direction
  std::vector<double> weights_;  // of each point, by the loss
  double sigma_mm_ = 1;          // by which the loss judged
  LeastSquaresProblem problem_;
  std::vector<int> identified_;  // independent parameters of the geometry
  FitResult fit_;
  ParameterUncertainty uncertainty_;
  std::vector<JointVector> transfer_poses_;
  Calibration result_;
};

}  // namespace

std::expected<CalibratedCell, CalibrationError> coarse_fit(const RobotModel& arm,
                                                           const MeasurementData& data) {
  MeasurementData all = data;
  for (Measurement& point : all.points) point.set = PoseSet::Identify;
  if (auto error = unusable(arm, all.smr_names, all.points)) return std::unexpected(*error);
  const CalibrateOptions options;
  Identification identification(arm, all, options);
  if (auto error = identification.fit_base_and_reflectors()) return std::unexpected(*error);
  return identification.coarse();
}

std::expected<Calibration, CalibrationError> calibrate(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options) {
  return Identification(nominal, data, options).run();
}

}  // namespace truepose
