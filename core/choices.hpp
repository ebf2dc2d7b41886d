#pragma once

/// What a user chooses of a calibration.
namespace truepose {

/// How much a large residual counts.
enum class Loss {
  OutlierRejection,  ///< as it stands, once the outliers that find_outliers() returns are removed
  Squared,           ///< as it stands: right where there are no outliers
  Huber,             ///< linearly beyond a few sigma: every point stays in
  Igg3,   ///< less and less, and not at all beyond 6 sigma (Yang's third scheme of the Institute of Geodesy)
  Tukey,  ///< not at all beyond a few sigma, nor its sway near there
};

/// Whether a Gaussian process over what the other layers leave is part of a model.
enum class FieldUse {
  None,
  Auto,    ///< where cross-validation shows that it helps
  Always,  ///< whether it helps or not
};

/// Whether deviations from the data sheet are taken as small before they are measured.
enum class PriorUse {
  Auto,  ///< where the poses do not excite the arm
  Off,
  On,
};

/// From what the temperature of the arm at each point is derived.
enum class ThermalUse {
  Off,
  Auto,          ///< the temperatures; where no point carries any the time, and without it the order
  Temperatures,  ///< of the drives, where points carry them
  Time,          ///< since the first point, measured with a cold arm
};

/// What a set of poses is chosen for.
enum class DesignCriterion {
  D,  ///< the smallest volume of the parameters' uncertainty
  A,  ///< the smallest mean variance of the parameters, in units of what is known of them before
  I,  ///< the smallest mean variance of the predicted positions of the task
};

}  // namespace truepose
