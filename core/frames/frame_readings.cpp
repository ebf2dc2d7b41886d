#include "core/frames/frame_readings.hpp"

#include <cmath>
#include <string>

#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr double kTouch_mm = 0.01;       // no point is touched finer, per axis
constexpr double kParameterStep = 1e-5;  // mm or rad, of the derivative to a parameter
// Readings that belong together scatter by tens of times their noise where the arm is no longer what its
// model has it to be.
constexpr double kContradictory = 100, kContradictory_mm = 1;
constexpr double kBeyondNoise = 3;  // times: misfits of points whose coordinates are right are less

/// Standard deviation of what stated coordinates are wrong by, where the readings do not explain the misfits.
double coordinates_off(std::span<const double> misfit_mm, double variance_of_readings) {
  double squares = 0;
  for (const double misfit : misfit_mm) squares += misfit * misfit;
  const double spare = 3 * static_cast<double>(misfit_mm.size()) - 6;
  const double variance = spare > 0 ? squares / spare : 0;
  const bool beyond = variance > kBeyondNoise * kBeyondNoise * variance_of_readings;
  return beyond ? std::sqrt(variance - variance_of_readings) : 0;
}

}  // namespace

double BaseShift::unseen_mm() const { return kDoubtful * std::sqrt(eigenvalues(covariance).maxCoeff()); }
bool BaseShift::is_real() const { return p_B_mm.dot(covariance.inverse() * p_B_mm) > kDoubtful * kDoubtful; }

double MeasuredFrame::sigma_mm() const { return std::sqrt(covariance.topLeftCorner<3, 3>().trace()); }
double MeasuredFrame::sigma_rad() const { return std::sqrt(covariance.bottomRightCorner<3, 3>().trace()); }

bool contradict(std::span<const double> error_mm, const std::optional<double>& sigma0) {
  double squares = 0;
  for (const double error : error_mm) squares += error * error;
  const double rms_mm = std::sqrt(squares / static_cast<double>(error_mm.size()));
  return sigma0.value_or(0) > kContradictory && rms_mm > kContradictory_mm;
}

Eigen::MatrixXd derivative_to_steps(const EquationsOf& equations_of, const Eigen::MatrixXd& covariance) {
  const Eigen::Index steps = covariance.cols();
  const auto at = [&](const Eigen::VectorXd& step) { return solve_points(equations_of(step)); };
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(at(Eigen::VectorXd::Zero(steps)).size(), steps);
  for (Eigen::Index k = 0; k < steps; ++k) {
    if (!(covariance(k, k) > 0)) continue;
    const Eigen::VectorXd step = kParameterStep * Eigen::VectorXd::Unit(steps, k);
    D.col(k) = (at(step) - at(-step)) / (2 * kParameterStep);
  }
  return D;
}

std::expected<MeasuredFrame, std::string> measured_frame(const FrameReadings& data,
                                                         const EquationsOf& equations_of,
                                                         const Eigen::MatrixXd& covariance,
                                                         const std::optional<Eigen::Matrix3d>& R_else) {
  const auto points = static_cast<Eigen::Index>(data.points.size());
  const PointFit fit = fit_points(equations_of(Eigen::VectorXd::Zero(covariance.cols())));
  std::vector<Eigen::Vector3d> p_mm;
  for (Eigen::Index i = 0; i < points; ++i) p_mm.push_back(fit.u.segment<3>(3 * i));
  const auto frame = frame_of_points(data.points, p_mm, R_else);
  if (!frame) return std::unexpected(frame.error());

  MeasuredFrame result{.X = frame->X, .is_orientation_known = frame->is_orientation_known};
  const Eigen::MatrixXd to_frame = frame->by_points;
  const Eigen::MatrixXd of_points = fit.covariance.topLeftCorner(3 * points, 3 * points);
  result.coordinates_off_mm =
      coordinates_off(frame->misfit_mm, of_points.trace() / (3 * static_cast<double>(points)));
  result.by_readings = congruence(to_frame, of_points) + result.coordinates_off_mm *
                                                             result.coordinates_off_mm *
                                                             times_transposed(to_frame, to_frame);
  result.by_parameters = times(to_frame, derivative_to_steps(equations_of, covariance).topRows(3 * points));
  result.covariance = result.by_readings + congruence(result.by_parameters, covariance);
  result.error_mm = fit.error_mm;
  result.misfit_mm = frame->misfit_mm;
  result.sigma0 = fit.sigma0;
  for (std::size_t i = 0; i < fit.sigmas.size(); ++i) {
    if (fit.sigmas[i] > kDoubtful) result.doubtful.push_back(i);
  }
  return result;
}

Eigen::Matrix3d covariance_in_base(const FrameReading& reading, const MeasuringCell& by) {
  const double repeatability_mm = by.noise.repeatability_mm;
  if (!reading.p_WS_mm)
    return (repeatability_mm * repeatability_mm + kTouch_mm * kTouch_mm) * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d R_WB = by.cell.base.isometry().linear();
  return R_WB.transpose() * reading_covariance(*reading.p_WS_mm, by.noise) * R_WB;
}

}  // namespace truepose
