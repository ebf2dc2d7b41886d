#include "core/judge/calibration_doubts.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/formatted.hpp"
#include "core/identify/calibrated_cell.hpp"
#include "core/identify/identifiability.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/judge/drift_causes.hpp"
#include "core/judge/drift_check.hpp"
#include "core/judge/model_noise.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr std::size_t kFewest = 3;  // points before and after a step: fewer are single readings
constexpr double kHalved = 0.5;     // of the standard deviation
constexpr int kUnknowns = ParameterLayout::kBase;

/// Orthonormal columns that span those of A.
Eigen::MatrixXd span_of(const Eigen::MatrixXd& A) {
  const Svd svd = thin_svd(A * column_norms(A).cwiseInverse().asDiagonal());
  return svd.U.leftCols((svd.s.array() > kRankTolerance * svd.s[0]).count());
}

/// What of a step's six columns, and of the residuals, is left beside the parameters.
struct Beside {
  const Eigen::MatrixXd& U;
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& A) const { return A - times(U, transposed_times(U, A)); }
};

}  // namespace

std::optional<StepInTime> step_in_time(const CalibratedCell& cell, std::span<const Measurement> points,
                                       const MeasurementNoise& stated) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, f, J);
  const Eigen::MatrixXd moves = J.leftCols<kUnknowns>();  // mm at each point
  const Whitening whitening = whitening_of(points, stated);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix3d W = whitening.W[i] / whitening.finest_mm;
    f.segment<3>(row) = W * f.segment<3>(row).eval();
    J.middleRows<3>(row) = W * J.middleRows<3>(row).eval();
  }
  const Eigen::MatrixXd U = span_of(J);
  const Beside beside{U};
  const Eigen::VectorXd r = beside(-f);
  const auto degrees = static_cast<int>(f.size() - U.cols());
  if (degrees <= kUnknowns || chi_square_tail(r.squaredNorm(), degrees) >= kSignificance) return std::nullopt;

  std::optional<StepInTime> found;
  double least = kHalved * kHalved * r.squaredNorm() / degrees * (degrees - kUnknowns);
  for (std::size_t first = kFewest; first + kFewest <= points.size(); ++first) {
    const auto rows = 3 * static_cast<Eigen::Index>(points.size() - first);
    Eigen::MatrixXd step = Eigen::MatrixXd::Zero(f.size(), kUnknowns);
    step.bottomRows(rows) = J.leftCols<kUnknowns>().bottomRows(rows);
    const Eigen::VectorXd scale = column_norms(step).cwiseInverse();
    const Eigen::MatrixXd A = beside(step) * scale.asDiagonal();
    const Eigen::VectorXd x = smallest_solution(A, r, kRankTolerance);
    const double left = (times(A, x) - r).squaredNorm();
    if (left >= least) continue;
    least = left;
    const Eigen::VectorXd moved = times(moves.bottomRows(rows), scale.cwiseProduct(x));
    found = StepInTime{.first = first, .moved_mm = moved.reshaped(3, rows / 3).colwise().norm().mean()};
  }
  return found;
}

namespace {

/// So many times the stated noise is more than gears, bearings and loads leave of an arm: some tenths of a
/// millimetre, against some hundredths that tracker and repeatability make.
constexpr double kMostUnmodelled = 50;
/// A single reading of the reference, as against the mean of those before and after, is a step where it
/// leaves so little of their squares.
constexpr double kStepLeaves = 0.25;

using Doubt = std::optional<std::string>;

double sum_of_squares(std::span<const Eigen::Vector3d> readings_mm) {
  Eigen::Vector3d mean_mm(0, 0, 0);
  for (const Eigen::Vector3d& reading : readings_mm)
    mean_mm += reading / static_cast<double>(readings_mm.size());
  double sum = 0;
  for (const Eigen::Vector3d& reading : readings_mm) sum += (reading - mean_mm).squaredNorm();
  return sum;
}

double farthest_apart_mm(std::span<const Eigen::Vector3d> readings_mm) {
  double farthest_mm = 0;
  for (const Eigen::Vector3d& a : readings_mm)
    for (const Eigen::Vector3d& b : readings_mm) farthest_mm = std::max(farthest_mm, (a - b).norm());
  return farthest_mm;
}

/// "it moved between its measurements 2 and 3", where it stood still before and after.
std::string moment_of(std::span<const Eigen::Vector3d> readings_mm) {
  const double all = sum_of_squares(readings_mm);
  for (std::size_t k = 1; k < readings_mm.size(); ++k) {
    const double apart = sum_of_squares(readings_mm.first(k)) + sum_of_squares(readings_mm.subspan(k));
    if (readings_mm.size() > 2 && apart < kStepLeaves * all)
      return " (something moved between its measurements " + std::to_string(k) + " and " +
             std::to_string(k + 1) + ")";
  }
  return {};
}

Doubt moved_reference(const CalibrationEvidence& evidence) {
  const auto readings_mm = evidence.reference_mm;
  if (readings_mm.size() < 2) return std::nullopt;
  const Eigen::Matrix3d W = inverse_cholesky(reading_covariance(readings_mm.front(), evidence.stated));
  Eigen::Vector3d mean_mm(0, 0, 0);
  for (const Eigen::Vector3d& reading : readings_mm)
    mean_mm += reading / static_cast<double>(readings_mm.size());
  double distance2 = 0, off_mm = 0;
  for (const Eigen::Vector3d& reading : readings_mm) {
    distance2 += (W * (reading - mean_mm)).squaredNorm();
    off_mm += (reading - mean_mm).norm() / static_cast<double>(readings_mm.size());
  }
  const int degrees = 3 * (static_cast<int>(readings_mm.size()) - 1);
  const double apart_mm = farthest_apart_mm(readings_mm);
  const double accuracy_mm = evidence.calibration.validate->after.mean;
  const bool large = off_mm > kLargeFactor * accuracy_mm || distance2 > kMostScatter * kMostScatter * degrees;
  if (!large || chi_square_tail(distance2, degrees) >= kSignificance) return std::nullopt;
  return formatted(
      "the reference pose did not stay where it was: its %zu measurements are up to %.3f mm apart%s",
      readings_mm.size(), apart_mm, moment_of(readings_mm).c_str());
}

/// Of the noise that the identification left, in terms of the stated one.
double noise_factor(const CalibrationEvidence& evidence) {
  const Eigen::Vector3d p_WS_mm = evidence.data.points.front().p_WS_mm;
  const MeasurementNoise about = noise_about_model(evidence.calibration, evidence.data, evidence.stated);
  return std::sqrt(reading_covariance(p_WS_mm, about).trace() /
                   reading_covariance(p_WS_mm, evidence.stated).trace());
}

Doubt more_than_predicted(const CalibrationEvidence& evidence) {
  const std::vector<Measurement> points = points_of(evidence.data, PoseSet::Validate);
  const double factor = noise_factor(evidence);
  DriftReference predicted{.cell = evidence.calibration.cell,
                           .covariance = evidence.calibration.covariance,
                           .noise = noise_about_model(evidence.calibration, evidence.data, evidence.stated)};
  // Few poses leave little by chance: the stated noise is there all the same.
  if (factor < 1) predicted.noise = evidence.stated;
  if (factor < 1 && factor > 0) predicted.covariance /= factor * factor;
  const auto check = drift_check(predicted, points);
  if (!check || check->verdict != DriftVerdict::Failed) return std::nullopt;
  return formatted("the validation points are off by %.3f mm on average, where the model predicts %.3f mm",
                   check->mean_mm, check->reference_mm);
}

Doubt moved_meanwhile(const CalibrationEvidence& evidence) {
  const auto step = step_in_time(evidence.calibration.cell, evidence.data.points, evidence.stated);
  if (!step) return std::nullopt;
  return formatted(
      "the tracker or the base moved by about %.2f mm between the points %zu and %zu that were measured",
      step->moved_mm, step->first, step->first + 1);
}

Doubt too_much_left(const CalibrationEvidence& evidence) {
  const double factor = noise_factor(evidence);
  if (factor <= kMostUnmodelled) return std::nullopt;
  return formatted(
      "the model leaves %.0f times the noise that is configured (tracker.noise, robot.repeatability_mm)",
      factor);
}

}  // namespace

std::vector<std::string> calibration_doubts(const CalibrationEvidence& evidence) {
  std::vector<std::string> doubts;
  if (!evidence.calibration.validate) return {"it was not validated"};
  for (const auto ask : {moved_reference, moved_meanwhile, more_than_predicted, too_much_left}) {
    if (Doubt doubt = ask(evidence)) doubts.push_back(*std::move(doubt));
  }
  return doubts;
}

}  // namespace truepose
