#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// What a measured pose is for. Validation poses never touch the identification.
enum class PoseSet { Identify, Validate };

/// How a 6-D target (T-Mac, STS, a camera's marker) was turned when it was read.
struct MeasuredOrientation {
  Eigen::Matrix3d R_WT = Eigen::Matrix3d::Identity();  ///< the target's axes in the tracker frame
  double sigma_rad = 0;                                ///< standard uncertainty of the turn about each axis
};

/// One reflector reading of a standing arm.
struct Measurement {
  JointVector q;                     ///< joint positions (rad, mm)
  Eigen::Vector3d p_WS_mm{0, 0, 0};  ///< reflector centre in the tracker frame
  int smr = 0;                       ///< index into MeasurementData::smr_names
  int station = 0;                   ///< index into MeasurementData::stations
  PoseSet set = PoseSet::Identify;
  /// Whether its place among the points says when it was measured. Points that were put aside to validate
  /// have lost it: what their file leaves of the order is not that of the campaign.
  bool in_order = true;
  std::optional<double> sigma_mm;      ///< standard uncertainty per axis, where known
  std::vector<std::int8_t> direction;  ///< side from which each joint arrived (-1, 0, 1); empty = unknown
  std::optional<LinkMass> payload;     ///< what the flange carried; nothing: what the arm does
  std::vector<double> temperature_c;   ///< of each joint's drive; empty = not measured
  std::string time;                    ///< as measured_time() reads it, or empty
  int row = 0;                         ///< row of the file it came from (1 = first data row), 0 = no file
  int pose = 0;                        ///< number that its campaign or file gave its pose, from 1; 0 = none
  /// Standard deviation per axis beyond that of the noise model, where it is known to be less steady.
  double excess_mm = 0;
  std::optional<MeasuredOrientation> orientation;  ///< of a 6-D target
};

/// An arm that carries at each point what it carried there.
class LoadedArm {
 public:
  explicit LoadedArm(const RobotModel& robot) : arm_{robot}, own_{robot.payload} {}
  /// Holds until the next call.
  const RobotModel& at(const Measurement& point) {
    arm_.payload = point.payload ? point.payload : own_;
    return arm_;
  }

 private:
  RobotModel arm_;
  std::optional<LinkMass> own_;
};

struct MeasurementData {
  std::vector<std::string> smr_names;  ///< in the order of first appearance
  std::vector<Measurement> points;
  /// What the places are called from which the tracker measured, each with a base pose of its own: it was
  /// moved, or set up again on another day. Empty: one place.
  std::vector<std::string> stations;

  int station_count() const { return stations.empty() ? 1 : static_cast<int>(stations.size()); }
};

/// How a message begins that concerns one of several stations: "station 'door': "; empty where there is one.
std::string station_prefix(const MeasurementData& data, int station);

/// What was measured from one station, as data of its own, with those reflectors alone that it saw.
MeasurementData of_station(const MeasurementData& data, int station);

/// Adds what was measured from another station. A reflector of the same name is the same.
void add_station(MeasurementData& data, MeasurementData station);

/// The number of each point's pose, from 0 in the order of first appearance. Points with the same joints are
/// of one pose.
std::vector<int> pose_numbers(std::span<const Measurement> points);

/// The number of each point's pose as it is displayed, from 1: its own where all points have one, else by the
/// order of first appearance.
std::vector<int> named_pose_numbers(std::span<const Measurement> points);

/// Indices of the points of each pose, poses in the same order.
std::vector<std::vector<std::size_t>> pose_groups(std::span<const Measurement> points);

int count_poses(std::span<const Measurement> points);

/// The points of one set, in their order.
std::vector<Measurement> points_of(const MeasurementData& data, PoseSet set);

/// Standard deviations of a tracker's reading along the beam and in each direction across it: a constant and
/// a part that grows with the distance.
///
/// Spherical, since a tracker knows distances better than directions: its cloud of errors is flat along the
/// beam.
struct TrackerNoiseModel {
  double range_mm = 0;
  double range_mm_per_m = 0;
  double transverse_mm = 0;
  double transverse_mm_per_m = 0;
};

/// What blurs one measured point: the tracker's reading, and the arm, which does not come back to the same
/// place.
struct MeasurementNoise {
  TrackerNoiseModel tracker;
  double repeatability_mm = 0;  ///< standard deviation per axis of the arm's position
};

/// Covariance (mm^2, tracker frame, the tracker at its origin) of one reading at p_WS.
Eigen::Matrix3d reading_covariance(const Eigen::Vector3d& p_WS_mm, const MeasurementNoise& noise);

/// The same of a point, its own excess included.
Eigen::Matrix3d point_covariance(const Measurement& point, const MeasurementNoise& noise);

/// What makes the residuals of points alike: W with W'W = s^2 times the inverse covariance of a point, where
/// s is the finest standard deviation of all, so that a whitened residual stays in mm.
struct Whitening {
  std::vector<Eigen::Matrix3d> W;  ///< one per point; empty = all points alike, their noise unknown
  double finest_mm = 0;            ///< s, 0 where the noise is unknown
};

/// By each point's stated sigma where every point has one, else by the noise model where there is one, else
/// all alike.
Whitening whitening_of(std::span<const Measurement> points, const std::optional<MeasurementNoise>& noise);

/// Standard deviation (mm) of further errors of each coordinate, in addition to the noise that whitens the
/// points, if their whitened residuals have the standard deviation `sigma0_mm`. 0 where that is no more than
/// the noise alone gives, or the noise is unknown.
double beyond_noise_mm(const Whitening& whitening, double sigma0_mm);

/// Marks part of the poses to identify and the rest to validate. Points with the same joints are one pose and
/// stay together, so that no validation pose has been seen by the identification.
///
/// Poses are numbered in the order of first appearance and shuffled by Fisher and Yates: for i = P - 1 down
/// to 1, swap pose i with pose n mod (i + 1), n the next number of SplitMix64 begun with the seed. The first
/// round(fraction * P) identify.
///
/// @param fraction  of the poses that identify, 0 to 1
void split_poses(MeasurementData& data, double fraction, std::uint64_t seed);

/// Marks the poses of one fold of a K-fold cross-validation to validate and all others to identify. The poses
/// are shuffled as in split_poses(), and the one at place n belongs to fold n mod K: over all folds every
/// pose validates once, and folds differ by one pose at most.
///
/// @param folds  K, at least 2
/// @param fold   0 to K - 1
void hold_out_fold(MeasurementData& data, int folds, int fold, std::uint64_t seed);

}  // namespace truepose
