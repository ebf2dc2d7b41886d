#include "core/quality/calibration_verdict.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/calibrate/outlier_rejection.hpp"
#include "core/change/drift_check.hpp"
#include "core/change/movement.hpp"
#include "core/change/reference_pose.hpp"
#include "core/change/time_evidence.hpp"
#include "core/data/clock_step.hpp"
#include "core/data/error_bounds.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/open_warmth.hpp"
#include "core/fit/regression_field.hpp"
#include "core/fit/thermal_response.hpp"
#include "core/formatted.hpp"
#include "core/frames/positioner.hpp"
#include "core/math/units.hpp"
#include "core/quality/joint_coverage.hpp"
#include "core/quality/model_noise.hpp"
#include "core/quality/movement_finding.hpp"
#include "core/quality/reflector_on_axis.hpp"

namespace truepose {
namespace {

/// So many times the stated noise is more than gears, bearings and loads leave of an arm: some tenths of a
/// millimetre, against some hundredths that tracker and repeatability make.
constexpr double kMostUnmodelled = 50;
/// So many times is a test that failed: what the model does not know is elsewhere as large as it pleases.
constexpr double kMuchUnmodelled = 10;
/// So many times is more than noise: the arm, or what measured it, does what the model does not know.
constexpr double kUnmodelled = 3;
constexpr double kHardlyBetter = 0.5;  // of the mean error of the data sheet
/// The noise that those are seen against where a tracker's alone is stated.
constexpr double kUsualRepeatability_mm = 0.02;
/// An arm that comes back to a pose tells it to some thousandths of a degree.
constexpr double kSamePose_rad = 0.02 * kRadPerDeg, kSamePose_mm = 0.02;
constexpr int kFewestValidated = 5;          // poses: fewer say little of all others
constexpr double kMostFar = 0.1;             // of the points to identify
constexpr std::size_t kMostPredicted = 200;  // validation points: their covariance grows with the square
constexpr double kStillWarming = 0.5;        // of the mean error: less is not worth a word
constexpr double kNearerThanNoise = 0.5;     // of the mean error that the stated noise alone makes
constexpr std::size_t kNamed = 4;            // points in one sentence
constexpr double kMatters = 0.1;             // of the errors: what far points change of them
constexpr double kMostBeyondStated = 1.25;   // times: what the statement of a noise may be off by
constexpr int kFewestRepeats = 6;            // coordinates that are known to scatter

std::vector<std::size_t> far_points(const Calibration& calibration) {
  std::vector<std::size_t> far;
  for (const auto* points : {&calibration.rejected, &calibration.validation_outliers})
    for (const RejectedPoint& point : *points) far.push_back(point.point);
  return far;
}

/// Errors of the points that judge: those that validate where there are any.
struct JudgingErrors {
  explicit JudgingErrors(const CalibrationEvidence& of)
      : predicted{of.calibration.validate ? *of.calibration.validate : of.calibration.identify},
        achieved{of.remeasured.value_or(predicted.after)} {}

  const StageErrors& predicted;
  /// As their poses were reached with compensated joints, where they were: how good it is. What moved or
  /// warmed up before that hides in it, and is asked of what was predicted.
  ErrorStatistics achieved;
};

/// Standard deviation of a coordinate of the readings of one reflector at one pose; 0 where too few poses
/// were measured more than once.
double scatter_of_repeats_mm(const MeasurementData& data) {
  double squares = 0;
  int degrees = 0;
  for (const std::vector<std::size_t>& pose : pose_groups(data.points)) {
    std::map<std::pair<int, int>, std::vector<Eigen::Vector3d>> readings_mm;
    for (const std::size_t i : pose)
      readings_mm[{data.points[i].station, data.points[i].smr}].push_back(data.points[i].p_WS_mm);
    for (const auto& [of, all_mm] : readings_mm) {
      Eigen::Vector3d mean_mm = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& reading : all_mm) mean_mm += reading / static_cast<double>(all_mm.size());
      for (const Eigen::Vector3d& reading : all_mm) squares += (reading - mean_mm).squaredNorm();
      degrees += 3 * (static_cast<int>(all_mm.size()) - 1);
    }
  }
  return degrees < kFewestRepeats ? 0 : std::sqrt(squares / degrees);
}

struct Case : CalibrationEvidence {
  explicit Case(const CalibrationEvidence& evidence)
      : CalibrationEvidence{evidence},
        whitening{whitening_of(points_of(without(calibration.rejected, data), PoseSet::Identify), stated)},
        repeated_mm{scatter_of_repeats_mm(data)},
        about{noise_about_model(calibration, data, stated)},
        judged{evidence},
        moved{movement(calibration.cell, data.points, stated, far_points(calibration))},
        rounded{rounded_joints(calibration.cell,
                               points_of(without(calibration.rejected, data), PoseSet::Identify))} {}

  bool noise_known() const { return whitening.finest_mm > 0; }
  /// Of a point about the model: few poses leave little by chance, but the stated noise is there all the
  /// same.
  MeasurementNoise noise() const {
    const bool by_chance = calibration.sigma0_mm < whitening.finest_mm;
    if (by_chance && stated) return *stated;
    return by_chance ? MeasurementNoise{.repeatability_mm = whitening.finest_mm} : about;
  }

  /// Of a coordinate: as stated, else as poses scatter that were measured more than once; 0 where neither
  /// says.
  double noise_mm() const { return noise_known() ? whitening.finest_mm : repeated_mm; }

  Whitening whitening;
  double repeated_mm;
  MeasurementNoise about;  ///< what the identification left
  JudgingErrors judged;
  std::optional<Movement> moved;   ///< while it was measured
  std::optional<Finding> rounded;  ///< joints that are given to too few decimals
};

using Finds = std::optional<Finding>;

using enum FindingKind;

Finds too_much_left(const Case& of) {
  const double usual_mm = std::max(of.noise_mm(), kUsualRepeatability_mm);
  const double times = of.calibration.sigma0_mm / usual_mm;
  if (of.noise_mm() <= 0 || times <= kUnmodelled) return std::nullopt;
  const double times_noise = of.calibration.sigma0_mm / of.noise_mm();
  const std::string left = formatted(
      "the model leaves %.2f mm in each coordinate, %.0f times the noise that %s", of.calibration.sigma0_mm,
      times_noise, of.noise_known() ? "is stated" : "poses show that were measured again");
  if (times > kMostUnmodelled) return finding(LeavesMuch, left);
  if (of.judged.achieved.mean > kHardlyBetter * of.judged.predicted.before.mean)
    return finding(HardlyBetter, left + ", and is hardly better than the data sheet");
  Finding some = finding(times_noise >= kMuchUnmodelled ? LeavesMore : LeavesSome, left);
  if (of.moved || of.rounded) some.what_to_do.clear();  // these have findings of their own
  return some;
}

/// Of a reading of a pose that is measured again and again. A statement of the noise counts as some
/// residuals, with those of the model. Where these show more, the noise is as much more, but not for all
/// that the model does not describe: this is the same each time that the pose is measured.
KnownNoise noise_of_reference(const Case& of) {
  double degrees = 3 * static_cast<double>(of.whitening.W.size());
  for (const IdentifiedParameter& parameter : of.calibration.parameters) degrees -= parameter.data_share;
  degrees = std::max(1.0, degrees);
  if (!of.stated || !of.noise_known()) return {of.about, degrees};
  const double times = of.calibration.sigma0_mm / of.whitening.finest_mm;
  const double mean_square = (kStatedCounts + degrees * times * times) / (kStatedCounts + degrees);
  const double as_found = std::min(std::sqrt(mean_square), kMostBeyondStated);
  KnownNoise known{*of.stated, kStatedCounts + degrees};
  double& repeatability_mm = known.noise.repeatability_mm;
  repeatability_mm =
      std::hypot(repeatability_mm, beyond_noise_mm(of.whitening, as_found * of.whitening.finest_mm));
  return known;
}

Finds reference_moved(const Case& of) {
  auto moved = moved_reference(of.reference_mm, noise_of_reference(of), of.judged.predicted.after.mean);
  if (!moved) return std::nullopt;
  return finding(ReferenceMoved, std::move(moved->sentence));
}

Finds moved_meanwhile(const Case& of) {
  if (!of.moved) return std::nullopt;
  return finding_of(*of.moved, of.calibration.cell, of.data, of.judged.achieved.mean);
}

/// The model is that of the arm as warm as it was at the last point: what it does as it goes on warming up is
/// not in its errors.
Finds still_warming_up(const Case& of) {
  const auto& thermal = of.calibration.thermal;
  if (!thermal || !thermal->clock || !thermal->response) return std::nullopt;
  const double reached = thermal->response->reference_c.front();
  if (reached >= 1) return std::nullopt;
  CalibratedCell warm = of.calibration.cell;
  warm.robot = at_temperatures(warm.robot, *thermal->response, std::vector(warm.robot.joints.size(), 1.0));
  const Eigen::VectorXd further =
      residuals(warm, of.data.points) - residuals(of.calibration.cell, of.data.points);
  const auto points = static_cast<double>(of.data.points.size());
  const double further_mm = further.reshaped(3, further.size() / 3).colwise().norm().sum() / points;
  if (further_mm < kStillWarming * of.judged.predicted.after.mean) return std::nullopt;
  return finding(
      StillWarming,
      formatted("the arm was still warming up when the last point was measured, %.0f %% of the way: the "
                "model is that of the arm then, and by about %.2f mm not that of a warm one",
                100 * reached, further_mm));
}

/// Those of the validation points that are not named one by one, spread evenly where they are very many.
std::vector<Measurement> points_to_predict(const Case& of) {
  const auto points = points_of(without(of.calibration.validation_outliers, of.data), PoseSet::Validate);
  const std::size_t count = std::min(points.size(), kMostPredicted);
  std::vector<Measurement> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(points[i * points.size() / count]);
  return some;
}

/// Whether the layers over the geometry bring points nearer that neither has seen.
bool better_by_its_layers(const StageErrors& errors) {
  return errors.after.mean < errors.geometric.mean && errors.after.rms < errors.geometric.rms;
}

Finds more_than_predicted(const Case& of) {
  DriftReference predicted{
      .cell = of.calibration.cell, .covariance = of.calibration.covariance, .noise = of.noise()};
  const double factor = of.noise_known() ? of.calibration.sigma0_mm / of.whitening.finest_mm : 1;
  if (factor < 1 && factor > 0) predicted.covariance /= factor * factor;
  const std::vector<Measurement> points = points_to_predict(of);
  const auto signs = drift_signs(predicted, points);
  if (!signs || !signs->significant() || !signs->large() || signs->mean_mm < kLeastError_mm)
    return std::nullopt;
  if (diagnose_drift(predicted, points).one_reading()) return std::nullopt;
  const std::string off =
      formatted("the validation points are off by %.3f mm on average, where the model predicts %.3f mm",
                signs->mean_mm, signs->reference_mm);
  if (better_by_its_layers(of.judged.predicted))
    return finding(LayersUnsure, off + ": its layers make it better, and less so than they are sure of");
  return finding(ValidationOff, off);
}

Finds beyond_tolerance(const Case& of) {
  const double largest_mm = of.judged.achieved.max;
  if (!of.tolerance_mm || largest_mm <= *of.tolerance_mm) return std::nullopt;
  return finding(Tolerance, formatted("the largest error is %.3f mm, beyond the tolerance of %.3f mm",
                                      largest_mm, *of.tolerance_mm));
}

Finds nearer_than_noise(const Case& of) {
  if (!of.noise_known()) return std::nullopt;
  const double noise_mm = kMeanOverRms * std::sqrt(3.0) * of.whitening.finest_mm;
  const double mean_mm = of.judged.predicted.after.mean;
  if (mean_mm >= kNearerThanNoise * noise_mm) return std::nullopt;
  return finding(
      BelowNoise,
      formatted("a mean error of %.4f mm is less than tracker and arm repeat to (%.4f mm by the stated "
                "noise): the model repeats its points, or the noise is less than stated",
                mean_mm, noise_mm));
}

/// "row 12 (4.20 mm, 85 sigma)"
std::string name_of_point(const MeasurementData& data, const RejectedPoint& far) {
  return place_of(data, far.point) + formatted(" (%.3g mm, %.3g sigma)", far.residual_mm, far.sigmas);
}

/// The worst of them, by name.
std::string names_of_points(const MeasurementData& data, std::vector<RejectedPoint> far) {
  std::ranges::stable_sort(far, std::ranges::greater{}, &RejectedPoint::sigmas);
  std::string names;
  for (std::size_t i = 0; i < std::min(far.size(), kNamed); ++i)
    names += (i == 0 ? "" : ", ") + name_of_point(data, far[i]);
  return names + (far.size() > kNamed ? formatted(" and %zu more", far.size() - kNamed) : "");
}

/// Movements and warmth are sought by the times: turned round, they hide both.
Finds clock_was_set(const Case& of) {
  const auto step = clock_step(of.data.points);
  if (!step) return std::nullopt;
  return finding(
      ClockSet,
      formatted("the times go back by %.0f min between %s and %s and run on from there, as those of a "
                "clock that was set: motion and warm-up in between are not detected",
                step->back_s / 60, place_of(of.data, step->before).c_str(),
                place_of(of.data, step->after).c_str()));
}

Finds rows_left_out(const Case& of) {
  const auto& rejected = of.calibration.rejected;
  if (rejected.empty()) return std::nullopt;
  const std::size_t all = points_of(of.data, PoseSet::Identify).size();
  const bool many = static_cast<double>(rejected.size()) > kMostFar * static_cast<double>(all);
  return finding(many ? ManyOutliers : Outliers,
                 formatted("%zu of the %zu points to identify contradict the others and were left out: ",
                           rejected.size(), all) +
                     names_of_points(of.data, rejected));
}

Finds far_validation(const Case& of) {
  const auto& far = of.calibration.validation_outliers;
  if (far.empty()) return std::nullopt;
  std::vector<Eigen::Vector3d> others_mm;
  for (std::size_t i = 0; i < of.data.points.size(); ++i) {
    if (of.data.points[i].set == PoseSet::Validate && !std::ranges::count(far, i, &RejectedPoint::point))
      others_mm.push_back(of.calibration.points[i].after);
  }
  const ErrorStatistics with = of.calibration.validate->after;
  const ErrorStatistics without_them = others_mm.empty() ? with : error_statistics(others_mm);
  const bool matters = with.mean - without_them.mean > kMatters * with.mean ||
                       with.max - without_them.max > kMatters * with.max;
  return finding(
      matters ? ValidationOutliersMatter : ValidationOutliers,
      formatted("%zu of the %d validation points are beyond six sigma; without them "
                "the errors are %.3f mm on average and %.3f mm at most, with them %.3f and %.3f mm: ",
                far.size(), with.count, without_them.mean, without_them.max, with.mean, with.max) +
          names_of_points(of.data, far));
}

/// Points that have the joints of an earlier pose and are elsewhere: their joints are stale.
Finds joints_stale(const Case& of) {
  std::vector<std::size_t> stale;
  for (const std::vector<std::size_t>& pose : pose_groups(of.data.points)) {
    for (std::size_t k = 1; k < pose.size(); ++k) {
      const Measurement& point = of.data.points[pose[k]];
      const auto is_there = [&](std::size_t i) {
        const Measurement& other = of.data.points[i];
        return other.smr == point.smr && other.station == point.station &&
               (other.p_WS_mm - point.p_WS_mm).norm() > kMaxArmError_mm;
      };
      if (std::any_of(pose.begin(), pose.begin() + static_cast<std::ptrdiff_t>(k), is_there))
        stale.push_back(pose[k]);
    }
  }
  if (stale.empty()) return std::nullopt;
  std::string places;
  for (std::size_t i = 0; i < std::min(stale.size(), kNamed); ++i)
    places += (i == 0 ? "" : ", ") + place_of(of.data, stale[i]);
  if (stale.size() > kNamed) places += formatted(" and %zu more", stale.size() - kNamed);
  const bool all_far = std::ranges::all_of(
      stale, [far = far_points(of.calibration)](std::size_t i) { return std::ranges::count(far, i) > 0; });
  return finding(
      all_far ? StaleJointsLeftOut : StaleJoints,
      formatted("the same joints are given for points far apart, at %s: joints that were read before "
                "the arm had moved",
                places.c_str()));
}

/// Of readings that are the same to the last digit, all but the first.
std::ptrdiff_t count_repeated_readings(std::span<const Measurement> points) {
  const auto reading = [](const Measurement& m) {
    std::vector<double> numbers(m.q.begin(), m.q.end());
    numbers.insert(numbers.end(), m.p_WS_mm.begin(), m.p_WS_mm.end());
    return numbers;
  };
  std::set<std::vector<double>> seen;
  return std::ranges::count_if(points, [&](const Measurement& m) { return !seen.insert(reading(m)).second; });
}

Finds repeated_readings(const Case& of) {
  const std::ptrdiff_t again = count_repeated_readings(of.data.points);
  if (!of.noise_known() || again == 0) return std::nullopt;
  return finding(
      Duplicates,
      formatted("%td points repeat the joints and the reading of others to the last digit: a reading that "
                "is given twice makes the model no surer",
                again));
}

Finds noise_not_stated(const Case& of) {
  if (of.noise_known()) return std::nullopt;
  const double noise_mm = of.repeated_mm > 0 ? of.repeated_mm : of.calibration.sigma0_mm;
  return finding(
      NoiseUnstated,
      formatted("no noise is stated: it is taken as the %.3f mm in each coordinate that %s", noise_mm,
                of.repeated_mm > 0 ? "poses scatter by that were measured again" : "the model leaves"));
}

Finds field_of_some(const Case& of) {
  if (!of.calibration.cell.robot.field) return std::nullopt;
  const int poses = count_poses(points_of(without(of.calibration.rejected, of.data), PoseSet::Identify));
  if (poses <= static_cast<int>(kMostFieldPoses)) return std::nullopt;
  return finding(FieldSubset,
                 formatted("the residual field is made of %zu of the %d poses, spread evenly over the rows",
                           kMostFieldPoses, poses));
}

Finds joints_rounded(const Case& of) { return of.rounded; }

Finds on_last_axis(const Case& of) {
  const auto points = points_of(without(of.calibration.rejected, of.data), PoseSet::Identify);
  return reflectors_on_last_axis(of.calibration.cell, points, of.calibration.sigma0_mm);
}

Finds poses_narrow(const Case& of) {
  if (of.task_stated || is_positioner(of.calibration.cell.robot)) return std::nullopt;
  return narrow_poses(of.calibration.cell.robot, points_of(of.data, PoseSet::Identify));
}

/// Of a file without times, what validates says nothing of when it was measured.
Finds warmth_of_validation_open(const Case& of) {
  const auto& thermal = of.calibration.thermal;
  if (!thermal || !thermal->clock || !thermal->response) return std::nullopt;
  const std::ptrdiff_t open = std::ranges::count_if(of.data.points, warmth_is_open);
  if (open == 0) return std::nullopt;
  return finding(
      WarmthOpen,
      formatted("how warm the arm was at %td validation points is taken from their own readings, as "
                "nothing says when they were measured",
                open));
}

// What figures alone tell

/// What a calibration came to in figures.
struct CalibrationFigures {
  bool converged = false;
  ErrorStatistics before, after;  ///< of the points that judge: those that validate where there are any
  int unseen_poses = 0;           ///< that validate
  bool worse_elsewhere = false;   ///< some pose is known less well than the data sheet knows those measured
  bool is_positioner = false;     ///< its links may be as drawn
};

Finds not_converged(const CalibrationFigures& of) {
  if (of.converged) return std::nullopt;
  return finding(NotConverged, "the identification did not converge");
}

Finds no_better(const CalibrationFigures& of) {
  if (of.is_positioner || improves(of.before, of.after)) return std::nullopt;
  return finding(NoBetter, "the calibrated arm is no better than the nominal one");
}

Finds too_few_validated(const CalibrationFigures& of) {
  if (of.unseen_poses >= kFewestValidated) return std::nullopt;
  if (of.unseen_poses == 0)
    return finding(NotValidated, "nothing but the points that it was fitted to shows how good it is");
  return finding(FewValidated, formatted("%d validation %s of all others", of.unseen_poses,
                                         of.unseen_poses == 1 ? "pose says little" : "poses say little"));
}

Finds unknown_elsewhere(const CalibrationFigures& of) {
  if (!of.worse_elsewhere) return std::nullopt;
  return finding(UnknownElsewhere, "elsewhere than at measured poses it may be worse than the data sheet");
}

/// Whether an arm that came back to a pose may tell it as the other.
bool came_back(const JointVector& a, const JointVector& b, const RobotModel& robot) {
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const bool turns = robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
    if (std::abs(a[i] - b[i]) > (turns ? kSamePose_rad : kSamePose_mm)) return false;
  }
  return true;
}

/// Poses that validate and that the identification has not seen, nor come back to.
int unseen_poses(const CalibrationEvidence& of) {
  if (!of.calibration.validate) return 0;
  const auto to_validate = points_of(of.data, PoseSet::Validate);
  if (to_validate.empty()) return of.calibration.validate->poses;  // each by a fit without it
  const std::vector<Measurement> seen = points_of(of.data, PoseSet::Identify);
  std::vector<Measurement> unseen;
  for (const Measurement& point : to_validate) {
    const auto was_there = [&](const Measurement& m) {
      return came_back(m.q, point.q, of.calibration.cell.robot);
    };
    if (std::ranges::none_of(seen, was_there)) unseen.push_back(point);
  }
  return count_poses(unseen);
}

CalibrationFigures figures_of(const CalibrationEvidence& of) {
  const Calibration& calibration = of.calibration;
  const JudgingErrors judged{of};
  return {.converged = calibration.converged,
          .before = judged.predicted.before,
          .after = judged.achieved,
          .unseen_poses = unseen_poses(of),
          .worse_elsewhere = calibration.transfer.max_mm > calibration.identify.before.mean,
          .is_positioner = is_positioner(calibration.cell.robot)};
}

constexpr std::array kOfFigures{not_converged, no_better, too_few_validated, unknown_elsewhere};
constexpr std::array kOfEvidence{
    too_much_left,     reference_moved,   moved_meanwhile,          still_warming_up, more_than_predicted,
    beyond_tolerance,  nearer_than_noise, far_validation,           rows_left_out,    joints_stale,
    repeated_readings, clock_was_set,     noise_not_stated,         joints_rounded,   field_of_some,
    on_last_axis,      poses_narrow,      warmth_of_validation_open};

template <typename Questions, typename Of>
void ask(const Questions& questions, const Of& of, CalibrationVerdict& verdict) {
  for (const auto question : questions)
    if (Finds found = question(of)) verdict.findings.push_back(*std::move(found));
  std::ranges::stable_sort(verdict.findings, std::ranges::greater{}, &Finding::severity);
}

}  // namespace

VerdictColor CalibrationVerdict::color() const {
  if (findings.empty() || findings.front().severity == Severity::Note) return VerdictColor::Green;
  return findings.front().severity == Severity::Error ? VerdictColor::Red : VerdictColor::Amber;
}

bool CalibrationVerdict::failed() const {
  return !findings.empty() && findings.front().severity >= Severity::Warning;
}

CalibrationVerdict calibration_verdict(const CalibrationEvidence& evidence) {
  CalibrationVerdict verdict;
  ask(kOfFigures, figures_of(evidence), verdict);
  verdict.findings.insert(verdict.findings.end(), evidence.further_findings.begin(),
                          evidence.further_findings.end());
  ask(kOfEvidence, Case{evidence}, verdict);
  return verdict;
}

}  // namespace truepose
