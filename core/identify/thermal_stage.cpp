#include "core/identify/thermal_stage.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <utility>

#include "core/identify/identification.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/identify/screening.hpp"
#include "core/identify/thermal_response.hpp"
#include "core/identify/uncertainty.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr int kThermalRounds = 2;
constexpr double kBeyondChance = 2;  // standard errors of what the response takes from points left out

/// RFC 3339, as seconds since some moment.
std::optional<double> seconds_of(const std::string& time) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, east_h = 0, east_min = 0, read = 0;
  double second = 0;
  if (std::sscanf(time.c_str(), "%d-%d-%d%*1[Tt ]%d:%d:%lf%n", &year, &month, &day, &hour, &minute, &second,
                  &read) != 6)
    return std::nullopt;
  std::sscanf(time.c_str() + read, "%d:%d", &east_h, &east_min);
  if (east_h < 0) east_min = -east_min;
  const std::chrono::sys_days date{std::chrono::year{year} / month / day};
  return static_cast<double>(date.time_since_epoch().count()) * 86400 +
         60 * (60 * (hour - east_h) + minute - east_min) + second;
}

/// What one linear fit beside the parameters says of the response.
struct Fit {
  Eigen::VectorXd step;        ///< to be added to per_kelvin
  Eigen::MatrixXd covariance;  ///< as ThermalResponse's
  Eigen::MatrixXd inflation;   ///< of the parameters' covariance, as the response is not known exactly
  std::vector<double> left_out2, left_out2_without;  ///< of each point as the others predict it, whitened
};

/// What the points to identify say, whitened.
struct System {
  Eigen::MatrixXd J, T;  ///< derivatives to the parameters and to the response
  Eigen::VectorXd r;     ///< measured less predicted
};

System system_of(const Calibration& made, const MeasurementData& data, const ThermalResponse& response,
                 const std::optional<MeasurementNoise>& noise) {
  const std::vector<Measurement> points = points_of(without(made.rejected, data), PoseSet::Identify);
  System system;
  Eigen::VectorXd f;
  residuals_with_jacobian(made.cell, points, f, system.J);
  system.r = -f;
  const Whitening whitening = whitening_of(points, noise);
  system.T = Eigen::MatrixXd::Zero(f.size(), response.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    if (!whitening.W.empty()) {
      system.J.middleRows<3>(row) = whitening.W[i] * system.J.middleRows<3>(row).eval();
      system.r.segment<3>(row) = whitening.W[i] * system.r.segment<3>(row).eval();
    }
    if (points[i].temperature_c.empty()) continue;
    system.T.middleRows<3>(row) =
        system.J.middleRows<3>(row) * thermal_directions(made.cell, response, points[i].temperature_c);
  }
  return system;
}

/// Squared errors of the points, each as a linear fit to all others predicts it.
///
/// @param H  how a point's own reading draws its prediction, by its first row
std::vector<double> left_out(const Eigen::VectorXd& residuals,
                             const std::function<Eigen::Matrix3d(Eigen::Index)>& H) {
  std::vector<double> squared;
  for (Eigen::Index row = 0; row < residuals.size(); row += 3) {
    const Eigen::Matrix3d left = Eigen::Matrix3d::Identity() - H(row);
    squared.push_back((left.inverse() * residuals.segment<3>(row)).squaredNorm());
  }
  return squared;
}

Fit fitted(const Calibration& made, const MeasurementData& data, const ThermalResponse& response,
           const std::optional<MeasurementNoise>& noise) {
  const System system = system_of(made, data, response, noise);
  const double variance = made.sigma0_mm * made.sigma0_mm;
  const Eigen::MatrixXd C = made.covariance / variance;
  // How the parameters follow the response, and what of it they cannot take up.
  const Eigen::MatrixXd K = times(C, transposed_times(system.J, system.T));
  const Eigen::MatrixXd T = system.T - times(system.J, K);
  const Eigen::MatrixXd own = inverse_gram(T, 1e-9).value;
  Fit fit{.step = times(own, transposed_times(T, system.r))};
  fit.covariance.resize(own.rows(), C.rows() + own.cols());
  fit.covariance << -variance * times_transposed(own, K), variance * own;
  fit.inflation = variance * congruence(K, own);
  const auto share = [&](const Eigen::MatrixXd& A, const Eigen::MatrixXd& S, Eigen::Index row) {
    return Eigen::Matrix3d{congruence(A.middleRows(row, 3), S)};
  };
  fit.left_out2_without = left_out(system.r, [&](Eigen::Index row) { return share(system.J, C, row); });
  fit.left_out2 = left_out(system.r - times(T, fit.step), [&](Eigen::Index row) {
    return Eigen::Matrix3d{share(system.J, C, row) + share(T, own, row)};
  });
  return fit;
}

double rms(const std::vector<double>& squared) {
  double sum = 0;
  for (const double each : squared) sum += each;
  return std::sqrt(sum / static_cast<double>(squared.size()));
}

/// By how many of its standard errors the mean of the squares falls.
double gain(const Fit& fit) {
  const auto n = static_cast<double>(fit.left_out2.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < fit.left_out2.size(); ++i) {
    const double d = fit.left_out2_without[i] - fit.left_out2[i];
    sum += d;
    squares += d * d;
  }
  return sum / std::sqrt(std::max(squares - sum * sum / n, std::numeric_limits<double>::min()));
}

/// Points with temperatures, and a first fit to them.
struct Warmed {
  MeasurementData data;
  ThermalResponse response;
  double time_constant_s = 0;
  Fit fit;
};

ThermalResponse no_response(const RobotModel& robot, std::vector<double> reference_c) {
  return {.reference_c = std::move(reference_c),
          .per_kelvin = Eigen::VectorXd::Zero(robot.joint_count() + 1),
          .covariance = {}};
}

Warmed by_temperatures(const Calibration& made, const MeasurementData& data,
                       const CalibrateOptions& options) {
  const std::vector<Measurement> points = points_of(data, PoseSet::Identify);
  Warmed warmed{
      .data = data, .response = no_response(made.cell.robot, mean_temperatures_c(points)), .fit = {}};
  warmed.fit = fitted(made, data, warmed.response, options.noise);
  return warmed;
}

/// By the time constant that explains the points best.
Warmed by_time(const Calibration& made, const MeasurementData& data, const CalibrateOptions& options) {
  constexpr std::array kMinutes{5, 10, 15, 20, 30, 45, 60, 90, 120};
  const std::vector<double> warm(made.cell.robot.joints.size(), 1.0);
  Warmed best;
  for (const int minutes : kMinutes) {
    const double constant_s = 60.0 * minutes;
    Warmed next{.data = with_warmth_by_time(data, constant_s),
                .response = no_response(made.cell.robot, warm),
                .time_constant_s = constant_s,
                .fit = {}};
    next.fit = fitted(made, next.data, next.response, options.noise);
    if (best.data.points.empty() || rms(next.fit.left_out2) < rms(best.fit.left_out2)) best = std::move(next);
  }
  return best;
}

/// Adds what the response leaves open to what is known of the parameters.
void inflate(Calibration& made, const Eigen::MatrixXd& inflation) {
  for (std::size_t k = 0; k < made.parameters.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double before = made.covariance(i, i);
    if (before > 0) made.parameters[k].sigma *= std::sqrt(1 + inflation(i, i) / before);
  }
  made.covariance += inflation;
  made.transfer = transfer_uncertainty(made.cell, made.covariance,
                                       poses_within_limits(made.cell.robot, kTransferPoses, 0));
}

}  // namespace

bool tells_warmth(const MeasurementData& data, ThermalUse use) {
  if (use == ThermalUse::Off) return false;
  return std::ranges::any_of(data.points, [use](const Measurement& point) {
    return use == ThermalUse::Time ? seconds_of(point.time).has_value() : !point.temperature_c.empty();
  });
}

MeasurementData with_warmth_by_time(MeasurementData data, double time_constant_s) {
  std::map<int, double> start_s;
  for (const Measurement& point : data.points) {
    const auto time_s = seconds_of(point.time);
    if (!time_s) continue;
    const auto [start, is_new] = start_s.emplace(point.station, *time_s);
    start->second = std::min(start->second, *time_s);
  }
  for (Measurement& point : data.points) {
    point.temperature_c.clear();
    const auto time_s = seconds_of(point.time);
    if (!time_s) continue;
    const double warm = -std::expm1((start_s.at(point.station) - *time_s) / time_constant_s);
    point.temperature_c.assign(static_cast<std::size_t>(point.q.size()), warm);
  }
  return data;
}

std::expected<Calibration, CalibrationError> with_thermal_response(
    Calibration made, const MeasurementData& data, const CalibrateOptions& options,
    const std::function<std::expected<Calibration, CalibrationError>(const MeasurementData&)>& identify) {
  Warmed warmed = options.thermal == ThermalUse::Time ? by_time(made, data, options)
                                                      : by_temperatures(made, data, options);
  ThermalChoice choice{.response = {},
                       .time_constant_s = warmed.time_constant_s,
                       .without_rms_mm = rms(warmed.fit.left_out2_without),
                       .rms_mm = rms(warmed.fit.left_out2)};
  if (gain(warmed.fit) > kBeyondChance) {
    ThermalResponse& response = warmed.response;
    response.per_kelvin = warmed.fit.step;
    for (int round = 0; round < kThermalRounds; ++round) {
      const MeasurementData there = at_reference(warmed.data, made.cell, response);
      auto next = identify(there);
      if (!next) return next;
      made = *std::move(next);
      warmed.fit = fitted(made, there, response, options.noise);
      response.per_kelvin += warmed.fit.step;
    }
    response.covariance = warmed.fit.covariance;
    inflate(made, warmed.fit.inflation);
    choice.response = response;
    choice.rms_mm = rms(warmed.fit.left_out2);
  }
  made.thermal = std::move(choice);
  return made;
}

}  // namespace truepose
