#include "core/calibrate/thermal_stage.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/calibrate/outlier_rejection.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/open_warmth.hpp"
#include "core/fit/thermal_response.hpp"
#include "core/fit/uncertainty.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kOwnPart =
    1e-9;  // of a column's squares: what the parameters do not take up of it is rounding
constexpr int kFewestToWarm = 40;  // in which warm-up is sought without temperatures
// Standard errors of what the response takes from points left out: where it was asked for, and where not.
constexpr double kBeyondChance = 2, kBeyondDoubt = 3;
constexpr double kAsWell = 0.5;       // standard errors of what one time constant explains more than another
constexpr double kWarmThrough = 0.9;  // of the way: the rest may be extrapolated

/// Standard deviations of what arms do that are warm through: drives and castings of industrial arms rise by
/// some 30 K, zeros then turn by some hundredths of a degree, and steel grows by 11, aluminium by 23 ppm/K.
/// Without them a number that hardly any pose shows, as the last joint's zero under a reflector near its
/// axis, takes up whatever is left.
constexpr double kWarmZero_rad = 0.2e-3, kWarmZero_mm = 0.1, kWarmGrowth = 500e-6, kRise_K = 30;

/// Whitened equations of the points to identify, for the parameters and further columns.
struct System {
  std::vector<Measurement> points;
  Eigen::MatrixXd J;               ///< derivatives to the parameters
  Eigen::VectorXd r;               ///< measured less predicted
  Eigen::MatrixXd C;               ///< inverse of J' J, where it has one
  std::vector<Eigen::Matrix3d> H;  ///< how each point's own reading draws its prediction
  std::vector<double> left_out2;   ///< squared errors of the points, each as the others predict it
};

/// Squared errors of the points, each as a linear fit to all others predicts it.
std::vector<double> left_out(const Eigen::VectorXd& residuals, const std::vector<Eigen::Matrix3d>& H) {
  std::vector<double> squared;
  for (std::size_t i = 0; i < H.size(); ++i) {
    const Eigen::Matrix3d left = Eigen::Matrix3d::Identity() - H[i];
    const auto row = 3 * static_cast<Eigen::Index>(i);
    squared.push_back((left.inverse() * residuals.segment<3>(row)).squaredNorm());
  }
  return squared;
}

System system_of(const ThermalBasis& basis, const MeasurementData& data,
                 const std::optional<MeasurementNoise>& noise) {
  System system{.points = points_of(without(basis.rejected, data), PoseSet::Identify)};
  Eigen::VectorXd f;
  residuals_with_jacobian(basis.cell, system.points, f, system.J);
  system.r = -f;
  const Whitening whitening = whitening_of(system.points, noise);
  system.C = basis.covariance / (basis.sigma0_mm * basis.sigma0_mm);
  for (std::size_t i = 0; i < system.points.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    if (!whitening.W.empty()) {
      system.J.middleRows<3>(row) = whitening.W[i] * system.J.middleRows<3>(row).eval();
      system.r.segment<3>(row) = whitening.W[i] * system.r.segment<3>(row).eval();
    }
  }
  return system;
}

/// What each point's own reading does to its prediction.
void leave_out(System& system) {
  system.H = congruence_blocks(system.J, system.C);
  system.left_out2 = left_out(system.r, system.H);
}

/// Derivatives to the response.
///
/// @param points  those of the system, with their temperatures
Eigen::MatrixXd thermal_columns(const System& system, std::span<const Measurement> points,
                                const CalibratedCell& cell, const ThermalResponse& response) {
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(system.r.size(), response.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    if (points[i].temperature_c.empty()) continue;
    T.middleRows<3>(row) =
        system.J.middleRows<3>(row) * thermal_directions(cell, response, points[i].temperature_c);
  }
  return T;
}

/// Derivatives to a base that moves as the arm warms up.
Eigen::MatrixXd base_columns(const System& system, std::span<const Measurement> points,
                             const CalibratedCell& cell) {
  constexpr int kUnknowns = ParameterLayout::kBase;
  const ParameterLayout layout = ParameterLayout::of(cell);
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(system.r.size(), kUnknowns);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    if (points[i].temperature_c.empty()) continue;
    T.middleRows<3>(row) =
        points[i].temperature_c.front() * system.J.block<3, kUnknowns>(row, layout.base(points[i].station));
  }
  return T;
}

/// What of further columns the parameters cannot take up, and how these follow them.
struct Projected {
  Eigen::MatrixXd K, T;
  Eigen::MatrixXd own;  ///< inverse of T' T
};

/// @param prior  weight of each column's zero, in the square of a residual's unit
Projected projected(const System& system, const Eigen::MatrixXd& columns, const Eigen::VectorXd& prior) {
  Projected p{.K = times(system.C, transposed_times(system.J, columns)), .T = {}, .own = {}};
  p.T = columns - times(system.J, p.K);
  Eigen::MatrixXd rows(p.T.rows() + prior.size(), p.T.cols());
  rows << p.T, Eigen::MatrixXd{prior.cwiseSqrt().asDiagonal()};
  p.own = inverse_gram(rows, 1e-9).value;
  return p;
}

/// Result of one linear fit of further columns together with the parameters.
struct Fit {
  Eigen::VectorXd step;
  Eigen::MatrixXd covariance;  ///< as ThermalResponse's
  Eigen::MatrixXd inflation;   ///< of the parameters' covariance, as the step is not known exactly
  std::vector<double> left_out2;
};

/// @param weights  of the prior, per variance of a residual
/// @param at       of the columns' numbers, where the system was linearised
Fit fitted(const System& system, const Eigen::MatrixXd& columns, double sigma0_mm,
           const Eigen::VectorXd& weights, const Eigen::VectorXd& at) {
  const double variance = sigma0_mm * sigma0_mm;
  const Eigen::VectorXd prior = variance * weights;
  const auto [K, T, own] = projected(system, columns, prior);
  Fit fit{.step = times(own, Eigen::VectorXd{transposed_times(T, system.r) - prior.cwiseProduct(at)})};
  fit.covariance.resize(own.rows(), system.C.rows() + own.cols());
  fit.covariance << -variance * times_transposed(own, K), variance * own;
  fit.inflation = variance * congruence(K, own);
  std::vector<Eigen::Matrix3d> H = system.H;
  const std::vector<Eigen::Matrix3d> shares = congruence_blocks(T, own);
  for (std::size_t i = 0; i < H.size(); ++i) H[i] += shares[i];
  fit.left_out2 = left_out(system.r - times(T, fit.step), H);
  return fit;
}

/// Of a response, as physics has it.
///
/// @param by_clock  its unit is an arm that is warm through, and not a kelvin
Eigen::VectorXd physical_weights(const RobotModel& robot, bool by_clock) {
  const Eigen::Index joints = robot.joint_count();
  Eigen::VectorXd sigmas(joints + 1);
  for (Eigen::Index i = 0; i < joints; ++i)
    sigmas[i] =
        robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute ? kWarmZero_rad : kWarmZero_mm;
  sigmas[joints] = kWarmGrowth;
  if (!by_clock) sigmas /= kRise_K;
  return sigmas.cwiseAbs2().cwiseInverse();
}

double rms(const std::vector<double>& squared) {
  double sum = 0;
  for (const double each : squared) sum += each;
  return std::sqrt(sum / static_cast<double>(squared.size()));
}

ThermalResponse no_response(const RobotModel& robot, std::vector<double> reference_c) {
  return {.reference_c = std::move(reference_c),
          .per_kelvin = Eigen::VectorXd::Zero(robot.joint_count() + 1),
          .covariance = {}};
}

std::vector<Measurement> taking_part(const MeasurementData& data, std::span<const RejectedPoint> rejected) {
  return points_of(without(rejected, data), PoseSet::Identify);
}

/// Points with temperatures, and a first fit to them.
struct Warmed {
  MeasurementData data;
  ThermalResponse response;
  std::optional<WarmUpClock> clock;
  Fit fit;
};

/// The next step of the response from the points as it leaves them.
///
/// @param by_clock  as of physical_weights()
Fit fitted(const System& system, std::span<const Measurement> points, const ThermalBasis& basis,
           const ThermalResponse& response, bool by_clock) {
  return fitted(system, thermal_columns(system, points, basis.cell, response), basis.sigma0_mm,
                physical_weights(basis.cell.robot, by_clock), response.per_kelvin);
}

Warmed by_temperatures(const ThermalBasis& basis, const MeasurementData& data, const System& system) {
  Warmed warmed{
      .data = data,
      .response = no_response(basis.cell.robot, mean_temperatures_c(points_of(data, PoseSet::Identify))),
      .clock = {},
      .fit = {}};
  warmed.fit = fitted(system, system.points, basis, warmed.response, false);
  return warmed;
}

/// How warm the arm was at the last point; warm through where hardly anything was missing. No point was
/// measured at a warmer arm, and a time constant much longer than the campaign is not identifiable.
double warmest(const MeasurementData& data) {
  double most = 0;
  for (const Measurement& point : data.points)
    if (!point.temperature_c.empty()) most = std::max(most, point.temperature_c.front());
  return most < kWarmThrough ? most : 1;
}

/// By the shortest time constant that explains the points as well as any does but for chance: an arm
/// that is not yet warm through has to show it.
Warmed by_clock(const ThermalBasis& basis, const MeasurementData& data, const System& system) {
  std::vector<Warmed> all;
  for (const WarmUpClock& clock : warm_up_clocks(data)) {
    MeasurementData warm = with_warmth_by(clock, data);
    const std::vector<double> reference(basis.cell.robot.joints.size(), warmest(warm));
    Warmed next{.data = std::move(warm),
                .response = no_response(basis.cell.robot, reference),
                .clock = clock,
                .fit = {}};
    next.fit = fitted(system, taking_part(next.data, basis.rejected), basis, next.response, true);
    all.push_back(std::move(next));
  }
  const auto left = [](const Warmed& each) { return rms(each.fit.left_out2); };
  const auto best = std::ranges::min_element(all, {}, left);
  const auto as_well = std::ranges::find_if(all, [&](const Warmed& each) {
    return standard_errors_gained(each.fit.left_out2, best->fit.left_out2) < kAsWell;
  });
  return std::move(*as_well);
}

/// Whether warmth explains more of what is left than chance would, by one of the clocks: a quick look.
bool may_have_warmed_up(const ThermalBasis& basis, const MeasurementData& data, const System& system) {
  const std::vector<WarmUpClock> clocks = warm_up_clocks(data);
  const MeasurementData there = with_warmth_by(clocks[clocks.size() / 2], data);
  const std::vector<double> warm(basis.cell.robot.joints.size(), 1.0);
  const ThermalResponse none = no_response(basis.cell.robot, warm);
  const auto [K, T, own] =
      projected(system, thermal_columns(system, taking_part(there, basis.rejected), basis.cell, none),
                Eigen::VectorXd::Zero(none.size()));
  const Eigen::VectorXd b = transposed_times(T, system.r);
  const auto unknowns = static_cast<double>(T.cols());
  const double variance = system.r.squaredNorm() / static_cast<double>(system.r.size() - system.C.cols());
  const Eigen::VectorXd step = times(own, b);
  return b.dot(step) > variance * (unknowns + kBeyondDoubt * std::sqrt(2 * unknowns));
}

/// A joint whose zero changed at one moment, in place of a response: its column, for the points after it.
/// Of all joints and moments the one that explains the points best.
Eigen::MatrixXd zero_step_column(const System& system, const CalibratedCell& cell) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  const Eigen::VectorXd seen = transposed_times(system.J, system.r);
  Eigen::MatrixXd best = Eigen::MatrixXd::Zero(system.r.size(), 1);
  double most = 0;
  for (int joint = 0; joint < layout.joints; ++joint) {
    const Eigen::VectorXd column = system.J.col(zero_parameter(cell.robot, layout, joint));
    Eigen::VectorXd along = Eigen::VectorXd::Zero(system.J.cols());
    double b = 0, squares = 0;
    for (Eigen::Index row = column.size() - 3; row > 0; row -= 3) {
      const Eigen::Vector3d here = column.segment<3>(row);
      along += system.J.middleRows<3>(row).transpose() * here;
      b += here.dot(system.r.segment<3>(row));
      squares += here.squaredNorm();
      const Eigen::VectorXd taken = times(system.C, along);
      const double left = squares - along.dot(taken), gain = std::pow(b - taken.dot(seen), 2) / left;
      if (!(left > kOwnPart * squares) || gain <= most) continue;
      most = gain;
      best.topRows(row).setZero();
      best.bottomRows(column.size() - row) = column.tail(column.size() - row);
    }
  }
  return best;
}

/// Whether a thermal response that was not requested is significant.
bool beyond_doubt(const Warmed& warmed, const ThermalBasis& basis, const System& system) {
  if (standard_errors_gained(system.left_out2, warmed.fit.left_out2) <= kBeyondDoubt) return false;
  const std::vector<Measurement> points = taking_part(warmed.data, basis.rejected);
  if (follows_the_joints(points)) return false;
  const auto explains_better = [&](const Eigen::MatrixXd& rival) {
    const Eigen::VectorXd free = Eigen::VectorXd::Zero(rival.cols());
    return rms(fitted(system, rival, basis.sigma0_mm, free, free).left_out2) <= rms(warmed.fit.left_out2);
  };
  return !explains_better(base_columns(system, points, basis.cell)) &&
         !explains_better(zero_step_column(system, basis.cell));
}

bool has_temperatures(const MeasurementData& data) {
  return std::ranges::any_of(data.points,
                             [](const Measurement& point) { return !point.temperature_c.empty(); });
}

/// Whether there is anything to look for.
bool is_sought(const ThermalBasis& basis, const MeasurementData& data, ThermalUse use) {
  switch (use) {
    case ThermalUse::Off:
      return false;
    case ThermalUse::Temperatures:
      return has_temperatures(data);
    case ThermalUse::Time:
      return has_times(data.points);
    case ThermalUse::Auto:
      return has_temperatures(data) || count_poses(taking_part(data, basis.rejected)) >= kFewestToWarm;
  }
  return false;
}

}  // namespace

std::optional<ThermalStage> thermal_stage(const ThermalBasis& basis, const MeasurementData& data,
                                          const CalibrateOptions& options) {
  if (!is_sought(basis, data, options.thermal)) return std::nullopt;
  const bool by_time =
      options.thermal == ThermalUse::Time || (options.thermal == ThermalUse::Auto && !has_temperatures(data));
  const bool unasked = by_time && options.thermal == ThermalUse::Auto;
  System system = system_of(basis, data, options.noise);
  if (unasked && !may_have_warmed_up(basis, data, system)) return std::nullopt;
  leave_out(system);
  Warmed warmed = by_time ? by_clock(basis, data, system) : by_temperatures(basis, data, system);
  if (unasked && !beyond_doubt(warmed, basis, system)) return std::nullopt;
  warmed.response.per_kelvin = warmed.fit.step;
  return ThermalStage{.pays = standard_errors_gained(system.left_out2, warmed.fit.left_out2) > kBeyondChance,
                      .data = std::move(warmed.data),
                      .response = std::move(warmed.response),
                      .clock = warmed.clock,
                      .inflation = {},
                      .without_rms_mm = rms(system.left_out2),
                      .rms_mm = rms(warmed.fit.left_out2)};
}

MeasurementData at_reference(const ThermalStage& stage, const ThermalBasis& basis) {
  MeasurementData there = at_reference(stage.data, basis.cell, stage.response);
  if (!stage.clock) return there;
  return with_open_warmth(std::move(there), basis.cell, stage.response, basis.sigma0_mm);
}

void refine(ThermalStage& stage, const ThermalBasis& basis, const MeasurementData& there,
            const CalibrateOptions& options) {
  System system = system_of(basis, there, options.noise);
  leave_out(system);
  Fit fit = fitted(system, system.points, basis, stage.response, stage.clock.has_value());
  stage.response.per_kelvin += fit.step;
  stage.response.covariance = std::move(fit.covariance);
  stage.inflation = std::move(fit.inflation);
  stage.rms_mm = rms(fit.left_out2);
}

void add_thermal_choice(const ThermalStage& stage, Calibration& made) {
  made.thermal = {
      .response = {}, .clock = stage.clock, .without_rms_mm = stage.without_rms_mm, .rms_mm = stage.rms_mm};
  if (!stage.pays) return;
  made.thermal->response = stage.response;
  for (std::size_t k = 0; k < made.parameters.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double before = made.covariance(i, i);
    if (before > 0) made.parameters[k].sigma *= std::sqrt(1 + stage.inflation(i, i) / before);
  }
  made.covariance += stage.inflation;
}

}  // namespace truepose
