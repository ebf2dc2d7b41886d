#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/math/statistics.hpp"
#include "core/quality/drive_lag.hpp"

namespace truepose {

/// Where the reflector was at one time of a production program, mm in the robot's base frame.
struct PathSample {
  double time_s = 0;
  bool at_point = false;    ///< the program stands at one of its points, settled
  double gain_percent = 0;  ///< of the correction that was in effect, 100 at most; below 0: none, and why
  Eigen::Vector3d wanted_mm{0, 0, 0};   ///< of the data sheet's arm at the set points
  Eigen::Vector3d with_mm{0, 0, 0};     ///< of the real arm as it went
  Eigen::Vector3d without_mm{0, 0, 0};  ///< of the real arm, had its axes stood at the set points
  /// Of the data sheet's arm at the set points with the drives' lag applied; none where the lag is not known.
  std::optional<Eigen::Vector3d> lagged_mm = {};

  bool corrected() const { return gain_percent >= 100; }  ///< by all of the correction
};

/// What a production program did, in the order of time.
struct ProductionPath {
  std::string program;
  std::vector<PathSample> samples;  ///< those of the path are a few hundredths of a second apart
  std::optional<DriveLag> lag;      ///< where the axes were recorded
};

/// Whether the arm continued from one sample to the next: no time is missing between them.
bool goes_on(const PathSample& from, const PathSample& to);

/// Where the reflector should have been, and how far it was from there, mm.
struct PathError {
  Eigen::Vector3d place_mm{0, 0, 0}, error_mm{0, 0, 0};
};
struct SampleErrors {
  PathError with, without;
  std::optional<PathError> with_lagged;  ///< from the wanted path with the drives' lag applied; not at points
};

/// The error of each sample: at a point from the wanted position, along the path from the nearest place on
/// the wanted path within half a second of motion. The time by which drives lag is no error then, but what
/// they cut off a curve is; from the wanted path with the same lag applied, that is none either.
std::vector<SampleErrors> sample_errors(std::span<const PathSample> samples);

/// The points that the program left before all of the correction was in effect; where it waited for that, it
/// is none.
std::vector<PathSample> partly_corrected_points(std::span<const PathSample> samples);

/// Lengths of errors, mm; p95: the smallest that 95 % of them do not exceed.
struct ErrorLengths {
  double mean = 0, p95 = 0, max = 0;
};
/// The same samples with the correction and without it.
struct ErrorComparison {
  int count = 0;
  ErrorLengths with, without;

  bool improved() const { return improves(without.mean, with.mean); }
};

/// What the correction did for a program, judged where all of it was in effect.
struct PathAccuracy {
  std::optional<ErrorComparison> points;  ///< where any was judged, as below
  int points_partly_corrected = 0;
  std::optional<ErrorComparison> path;
  std::optional<ErrorLengths>
      path_lagged;  ///< with the correction, from the wanted path with the lag applied

  /// Of a judged path with the correction, the drives' lag apart where it is known.
  const ErrorLengths& path_with() const { return path_lagged ? *path_lagged : path->with; }
  bool judged() const { return points || path; }
  /// Whether something was judged and the correction did not bring the reflector nearer: by the points, where
  /// the arm stood, and by the path where no point was judged.
  bool refuted() const;
};
PathAccuracy path_accuracy(std::span<const PathSample> samples);

}  // namespace truepose
