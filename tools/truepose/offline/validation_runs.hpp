#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/calibrate/calibration.hpp"
#include "core/quality/splits_verdict.hpp"
#include "proto/record/calibration_document.hpp"

namespace truepose::tools {

/// A calibration and its document.
struct Outcome {
  Calibration calibration;
  record::CalibrationDocument document;
  MeasurementNoise noise;           ///< of a point about the model
  std::vector<double> distances2;   ///< validation_distances2()
  MeasurementData data;             ///< that it came from, as it was marked and fitted
  std::vector<JudgedSplit> splits;  ///< all of several, this one first
};

/// Calibrates from the points marked to identify, on so many threads; throws ConfigError. Called by several
/// threads at once.
using CalibrateOnce = std::function<Outcome(const MeasurementData&, int jobs)>;

/// The verdict on one calibration, by no tolerance. Called by several threads at once.
using Judge = std::function<CalibrationVerdict(const Outcome&)>;

/// Splits of the poses into those that identify and those that validate.
struct Splits {
  double fraction = 0;     ///< of the poses, that identify
  std::uint64_t seed = 0;  ///< of the first; each further one has the next
  int repeat = 1;
};

/// One calibration for each of the splits. The result is that of the
/// first; with several, `spread` holds the standard deviations and `splits` each one, and each is judged.
Outcome over_splits(const CalibrateOnce& calibrate_once, const Judge& judge, const MeasurementData& data,
                    const Splits& splits, int jobs);

/// K-fold cross-validation. The result is identified from all poses, but `validate` holds the errors of every
/// point as the fit predicts it that has not seen its pose, `fold_points` each of them (as `points`),
/// `spread` the standard deviations over the folds and `splits` each fold.
Outcome over_folds(const CalibrateOnce& calibrate_once, MeasurementData data, int folds, std::uint64_t seed,
                   int jobs);

}  // namespace truepose::tools
