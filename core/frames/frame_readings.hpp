#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/fit/point_fit.hpp"
#include "core/frames/frame_of_points.hpp"

namespace truepose {

/// One reading of a point of a frame: seen by the tracker, or touched.
struct FrameReading {
  std::size_t point = 0;                             ///< index into FrameReadings::points
  JointVector q;                                     ///< of the arm, rad or mm; empty: it had no part
  std::optional<Eigen::Vector3d> p_WS_mm;            ///< in the tracker frame; none: touched
  std::optional<MeasuredOrientation> orientation{};  ///< of a 6-D target whose axes are the frame's
  int row = 0;                                       ///< of the file it came from, 1 = first; 0 = no file
};

/// From so many standard deviations on it is not chance: 65,000 readings have one of a sound one.
inline constexpr double kDoubtful = 5;

struct FrameReadings {
  std::vector<FramePoint> points;
  std::vector<FrameReading> readings;
};

/// The arm by which a frame is measured, and how well it is known.
struct MeasuringCell {
  CalibratedCell cell;
  Eigen::MatrixXd covariance;  ///< of its parameters, order of ParameterLayout; empty: not known
  MeasurementNoise noise;      ///< of a reading about what the cell predicts
};

/// How far the arm's base, or the tracker, stands from where the model has it, as the readings of a tool have
/// it.
struct BaseShift {
  Eigen::Vector3d p_B_mm{0, 0, 0};
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< by readings and model together

  /// How large it may be without showing.
  double unseen_mm() const;
  /// That it is more than chance.
  bool is_real() const;
};

/// Whether readings that are off by so much do not belong together at all, so that no single one stands out.
///
/// @param sigma0  their scatter in multiples of their noise
bool contradict(std::span<const double> error_mm, const std::optional<double>& sigma0);

/// A frame that was measured, tool or base.
struct MeasuredFrame {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  ///< in the flange, or in the robot base
  PoseCovariance covariance = PoseCovariance::Zero();   ///< by readings and model together
  bool is_orientation_known = true;  ///< false: the origin alone was measured, and another's taken
  PoseCovariance by_readings = PoseCovariance::Zero();     ///< by their noise alone
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_parameters;  ///< derivative to the cell's; empty where unknown
  std::vector<double> error_mm;                            ///< of each reading, from where all together say
  std::vector<double> turn_error_rad;  ///< the same of its orientation; empty where none was read
  std::vector<std::size_t> doubtful;   ///< readings that the others contradict
  std::vector<double> misfit_mm;       ///< of each point, where their coordinates are known
  /// Standard deviation of what those are wrong by, as the misfits show it, and part of the covariance; 0
  /// where the readings' noise explains them.
  double coordinates_off_mm = 0;
  /// How the readings scatter, in multiples of their noise; none where no reading is spare.
  std::optional<double> sigma0;
  std::optional<BaseShift> shift;  ///< of a tool; none where the readings do not tell

  bool is_contradictory() const { return contradict(error_mm, sigma0); }
  /// That neither a reading nor all of them speak against using it.
  bool is_sound() const { return doubtful.empty() && !is_contradictory() && !(shift && shift->is_real()); }
  /// Standard deviation of its origin (length of the vector, mm), and of its turn (rad).
  double sigma_mm() const;
  double sigma_rad() const;
};

/// What readings say of the coordinates of points where what they are measured by is off by `step`.
using EquationsOf = std::function<std::vector<PointEquation>(const Eigen::VectorXd& step)>;

/// Fits the points, and to them the frame.
/// @param covariance  of a step; empty: not known
/// @param R_else      see frame_of_points()
/// Errors: those of frame_of_points().
std::expected<MeasuredFrame, std::string> measured_frame(const FrameReadings& data,
                                                         const EquationsOf& equations_of,
                                                         const Eigen::MatrixXd& covariance,
                                                         const std::optional<Eigen::Matrix3d>& R_else = {});

/// Derivative of all that the equations tell to the steps that are uncertain.
Eigen::MatrixXd derivative_to_steps(const EquationsOf& equations_of, const Eigen::MatrixXd& covariance);

/// Covariance (mm^2, robot base frame) of a reading by its noise.
Eigen::Matrix3d covariance_in_base(const FrameReading& reading, const MeasuringCell& by);

}  // namespace truepose
