#include "core/calibrate/transfer_beyond.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/fit/left_out_sides.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/uncertainty.hpp"

namespace truepose {
namespace {

constexpr double kUsualNoise_mm = 0.03;  // of a coordinate: what trackers read by and arms come back by
constexpr double kLessKnown = 2;         // times the variance of those measured
constexpr int kPosesElsewhere = 200;
constexpr double kChance = 1;  // standard deviations that what is left may be more by chance

/// Trace of what the parameters and the residual field leave open of a position, mm^2.
double open_mm2(const Calibration& result, const JointVector& q, int smr, Approach approach = {}) {
  return position_covariance(result.cell, result.covariance, q, smr, approach).trace();
}

/// At poses that the parameters know less well than they know those measured, by so many times as points on
/// one side of a joint's range are farther off than the others predict them.
void add_extrapolation(TransferUncertainty& transfer, const Calibration& result, const Identification& id) {
  if (result.cell.robot.field) return;  // which knows itself how far it is from its points
  const TrustedProblem trusted = trusted_problem(id);
  const double times = left_out_sides_factor(trusted.problem, linearise(id.fit.cell, trusted.problem));
  double measured_mm2 = 0;
  for (const Measurement& m : trusted.points)
    measured_mm2 += open_mm2(result, m.q, m.smr, m.direction) / static_cast<double>(trusted.points.size());
  const std::vector<JointVector> poses = poses_within_limits(result.cell.robot, kPosesElsewhere, 0);
  const auto beyond = static_cast<double>(std::ranges::count_if(
      poses, [&](const JointVector& q) { return open_mm2(result, q, 0) > kLessKnown * measured_mm2; }));
  const double share = beyond / static_cast<double>(poses.size());
  transfer.rms_mm *= std::sqrt(1 - share + share * times * times);
  if (beyond > 0) transfer.max_mm *= times;
}

/// How many times farther the validation points are than the model predicts them, at least once.
///
/// @param data  as fitted
double beyond_prediction(const Calibration& result, const MeasurementData& data,
                         const CalibrateOptions& options) {
  double squares = 0, predicted = 0;
  const double usual_mm = std::min(result.sigma0_mm, kUsualNoise_mm);
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    const Measurement& m = data.points[i];
    const bool is_far = std::ranges::count(result.validation_outliers, i, &RejectedPoint::point) > 0;
    if (m.set != PoseSet::Validate || is_far) continue;
    squares += result.points[i].after.squaredNorm();
    predicted += result.position_covariance(m.q, m.smr, m.direction).trace();
    if (m.sigma_mm)
      predicted += 3 * *m.sigma_mm * *m.sigma_mm;
    else
      predicted += options.noise ? point_covariance(m, *options.noise).trace() : 3 * usual_mm * usual_mm;
  }
  return predicted > 0 ? std::sqrt(std::max(1.0, squares / predicted)) : 1;
}

}  // namespace

double misfit_mm(const Identification& id) {
  const double left_mm = id.uncertainty.sigma0_mm;
  const bool is_stated = id.points.stated_sigma_mm() > 0;
  const double noise_mm = is_stated ? id.points.stated_sigma_mm() : kUsualNoise_mm;
  const double degrees = std::max(1.0, id.points.equations() - id.uncertainty.determined);
  const double by_chance = noise_mm * noise_mm * kChance * std::sqrt(2 / degrees);
  const double beyond2 = left_mm * left_mm - by_chance;
  if (!is_stated) return std::sqrt(std::max(0.0, beyond2 - noise_mm * noise_mm));
  return beyond_noise_mm({id.points.whitening(), noise_mm}, std::sqrt(std::max(0.0, beyond2)));
}

TransferUncertainty transfer_beyond(const Calibration& result, const Identification& id,
                                    const MeasurementData& fitted) {
  TransferUncertainty transfer = transfer_of(result.cell, result.covariance);
  transfer.rms_mm = std::hypot(transfer.rms_mm, std::sqrt(3.0) * result.misfit_mm);
  transfer.max_mm = std::hypot(transfer.max_mm, std::sqrt(3.0) * result.misfit_mm);
  add_extrapolation(transfer, result, id);
  const double times = beyond_prediction(result, fitted, id.options);
  transfer.rms_mm *= times;
  transfer.max_mm *= times;
  return transfer;
}

}  // namespace truepose
