#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "core/change/change_hypothesis.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// So many times the stated noise contradicts it: what repeated readings may scatter by, or the tracker say
/// of one point.
inline constexpr double kMostScatter = 5;

/// The noise of a reading, and how well it is known.
struct KnownNoise {
  MeasurementNoise noise;
  double degrees = 0;  ///< of freedom of an estimate that is known as well
};

/// A reference pose that did not stay: its most likely step, mm in the tracker frame.
struct ReferenceMotion : ChangeFound {
  std::string sentence;
};

/// Whether one and the same pose, measured again and again, did not stay where it was: off by more than the
/// noise explains, and moved by more than matters to a model of this accuracy.
///
/// Two tests share kSignificance: whether the readings before a moment and those after it are too far apart,
/// and whether all scatter too much. The first shows a single step more clearly. Both are F tests, because
/// the noise is an estimate.
///
/// @param accuracy_mm  mean error of the model
/// @return nothing where it stayed, or was measured less than twice
std::optional<ReferenceMotion> moved_reference(std::span<const Eigen::Vector3d> readings_mm,
                                               const KnownNoise& noise, double accuracy_mm);

}  // namespace truepose
