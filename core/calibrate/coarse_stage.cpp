#include <algorithm>
#include <cmath>

#include "core/calibrate/identification.hpp"
#include "core/calibrate/station_start.hpp"
#include "core/fit/placement.hpp"
#include "core/fit/robust_fit.hpp"
#include "core/fit/target_turns.hpp"
#include "core/fit/uncertainty.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// The base's rotation must be known to this (rad): an error found in the tracker's frame is corrected in the
/// base's, and a tenth of it would be left.
constexpr double kMostTurnSigma = 0.1;
constexpr double kFinestSigma_mm = 0.01;  // of a reading: points that fit better do so by chance
constexpr double kMostOfArmSigma_mm = 10;

/// Information of the points on the base's rotation about the tracker's axes, as the station sees it. All
/// other free parameters are eliminated: mm^2 per rad^2.
Eigen::Matrix3d rotation_information(const CalibratedCell& cell, const LinearSystem& system, int station) {
  const int first = ParameterLayout::of(cell).base(station) + 3;
  const std::vector<int> turn{first, first + 1, first + 2};
  std::vector<int> others;
  for (int k = 0; k < system.J.cols(); ++k)
    if (k < first || k > turn.back()) others.push_back(k);
  const Eigen::MatrixXd A = gram(system.J);
  const Eigen::MatrixXd mixed = A(others, turn);
  return A(turn, turn) - transposed_times(mixed, solve_symmetric(A(others, others), mixed));
}

/// Axes of the turns that poses anywhere would show, in columns: all three, except for a turntable: no pose
/// shows its rotation about its own axis, and it is not needed.
Eigen::MatrixXd observable_rotations(const CalibratedCell& cell, const LeastSquaresProblem& problem,
                                     int station) {
  constexpr int kPoses = 50;
  constexpr double kShows = 1e-8;  // of the information on the rotation that is observed best
  std::vector<Measurement> points;
  for (const JointVector& q : poses_within_limits(cell.robot, kPoses, 0)) {
    for (int smr = 0; smr < std::ssize(cell.reflectors); ++smr)
      points.push_back({.q = q, .smr = smr, .station = station});
  }
  const LeastSquaresProblem anywhere{.points = points, .free = problem.free, .W = {}, .prior = problem.prior};
  const Svd information = thin_svd(rotation_information(cell, linearise(cell, anywhere), station));
  const auto shown = (information.s.array() > kShows * information.s[0]).count();
  return information.U.leftCols(shown);
}

/// Standard deviation of a coordinate by the middle of the points, which a part of them that is wrong does
/// not move, and of no more than an arm is off by: what is left of a hopeless fit is not noise.
double sigma_of_middle_mm(const LinearSystem& system, std::size_t points) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < points; ++i)
    lengths.push_back(system.f.segment<3>(3 * static_cast<Eigen::Index>(i)).norm());
  return std::clamp(sigma_from_median(lengths), kFinestSigma_mm, kMostOfArmSigma_mm);
}

/// Whether the station's points show how the base is turned, with what the fit leaves as noise.
bool shows_turn(const CalibratedCell& cell, const LeastSquaresProblem& problem, int station) {
  const LinearSystem system = linearise(cell, problem);
  const double sigma_mm = sigma_of_middle_mm(system, problem.points.size());
  const double least = sigma_mm * sigma_mm / (kMostTurnSigma * kMostTurnSigma);
  const Eigen::Matrix3d information = rotation_information(cell, system, station);
  if (eigenvalues(information)[0] > least) return true;
  const Eigen::MatrixXd axes = observable_rotations(cell, problem, station);
  return axes.cols() == 2 && eigenvalues(congruence(axes.transpose(), information))[0] > least;
}

std::optional<CalibrationError> base_turn_open(const Identification& id, const CalibratedCell& cell,
                                               const LeastSquaresProblem& problem) {
  for (int s = 0; s < cell.station_count(); ++s) {
    if (shows_turn(cell, problem, s)) continue;
    return CalibrationError{CalibrationFault::NotSeparable,
                            station_prefix(id.data, s) +
                                "the poses do not show how the base is turned, as the reflector was led "
                                "along one line or circle: measure poses that lead it off that in all "
                                "directions, or that turn the flange"};
  }
  return std::nullopt;
}

std::optional<CalibrationError> turns_contradict(const Identification& id, const CalibratedCell& cell) {
  const std::vector<Measurement>& points = id.points.points();
  const std::vector<Eigen::Vector3d> turns = target_turns(cell, points, best_mountings(cell, points));
  std::vector<double> turn_rad;
  for (const std::size_t i : oriented_points(points)) turn_rad.push_back(turns[i].norm());
  const std::string why = reason_not_an_arm(turn_rad);
  if (why.empty()) return std::nullopt;
  return CalibrationError{CalibrationFault::WrongTurns, why};
}

CalibratedCell coarse_start(const Identification& id) {
  const CalibrateOptions& options = id.options;
  const std::vector<Measurement>& points = id.points.points();
  if (options.start) return *options.start;
  if (reweighs(options.loss))
    return robust_start(id.nominal, id.data.smr_names, points, id.points.whitening());
  return placement(id.nominal, id.data.smr_names, points);
}

std::expected<CalibratedCell, CalibrationError> start_of(const Identification& id) {
  if (id.data.station_count() > 1 && !id.options.start) return station_start(id, coarse_start);
  return coarse_start(id);
}

}  // namespace

std::optional<CalibrationError> fit_base_and_reflectors(Identification& id) {
  const auto found = start_of(id);
  if (!found) return found.error();
  const CalibratedCell& start = *found;
  const ParameterLayout layout = ParameterLayout::of(start);
  LeastSquaresProblem problem = id.points.problem(first_parameters(layout.link(0)));
  problem.turn_weight.clear();  // the nominal arm is turned by more than any target is read
  problem.prior = placement_prior(layout);
  if (reweighs(id.options.loss)) {
    // The arm held at nominal says who is far off, not by how much one of them should count.
    id.points.weigh(start, Loss::Tukey, robust_fit(start, problem).sigma_mm);
    problem.W = id.points.weighted_whitening();
  }
  FitResult fit = solve(start, problem, id.options.max_coarse_iterations);
  if (auto error = base_turn_open(id, fit.cell, problem)) return error;
  if (auto error = turns_contradict(id, fit.cell)) return error;
  id.result.coarse = fit.cell;
  id.result.coarse_iterations = fit.iterations;
  id.result.coarse_rms_mm = fit.rms_mm;
  id.result.converged = fit.converged;
  id.fit = std::move(fit);
  return std::nullopt;
}

}  // namespace truepose
