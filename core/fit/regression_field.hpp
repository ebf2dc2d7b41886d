#pragma once

#include <span>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/field/regressor.hpp"

namespace truepose {

/// A residual field by regression on cosine and sine of every revolute joint's angle and of its double, where
/// gears err, and on the position of every prismatic one. Arms of more than eight joints: of the angle alone.
///
/// It moves a point of the flange (in the base frame, mm) and turns the flange about that point where the
/// measurements determine it. With one reflector the orientation is unknown.
class RegressionField final : public ResidualField {
 public:
  /// @param robot      whose joints' types say what the features are
  /// @param regressor  of 3 targets (displacement) or 6 (and rotation vector times kTurnLever_mm)
  /// @param p_F_mm     the point, in the flange frame
  /// @param variance_factor  true variance over the one that the regressor knows of
  RegressionField(const RobotModel& robot, RegressorPtr regressor, const Eigen::Vector3d& p_F_mm,
                  double variance_factor = 1);

  Eigen::Isometry3d displaced(const JointVector& q, const Eigen::Isometry3d& X_BF) const noexcept override;
  Eigen::Matrix3d covariance(const JointVector& q, const Eigen::Isometry3d& X_BF,
                             const Eigen::Vector3d& p_F_mm) const override;

  /// The flange as targets `y` of the regressor displace it.
  Eigen::Isometry3d displaced_by(const Eigen::Ref<const Eigen::VectorXd>& y,
                                 const Eigen::Isometry3d& X_BF) const noexcept;

  const RegressorPtr& regressor() const { return regressor_; }
  const Eigen::Vector3d& p_F_mm() const { return p_F_mm_; }
  double variance_factor() const { return variance_factor_; }

 private:
  std::vector<JointType> joints_;
  RegressorPtr regressor_;
  Eigen::Index targets_;
  Eigen::Vector3d p_F_mm_;
  double variance_factor_;
};

/// Predicted minus measured positions of the points that field_data() was made of, each in the frame of its
/// station (mm), as the field puts them with these targets of the poses (its rows).
std::vector<Eigen::Vector3d> errors_with(const Eigen::MatrixXd& targets, const RegressionField& field,
                                         const CalibratedCell& without_field,
                                         std::span<const Measurement> points);

/// How many features a field over this arm has: columns of its regressor's X.
int field_features(const RobotModel& robot);

/// Length (mm) by which a rotation is weighed against a displacement.
inline constexpr double kTurnLever_mm = 100;

inline constexpr std::size_t kMostFieldPoses = 2000;

/// Which of the points a field is made of. Where most poses have three readings and more, the others are left
/// out: a single reading that was screened out must not take the turn of the flange from the whole field. Of
/// more poses than kMostFieldPoses so many, spread evenly: the time grows with their cube.
std::vector<bool> makes_field(std::span<const Measurement> points);

/// What a residual field has to explain: the displacement of every pose, one group per pose, and the point of
/// the flange to which they apply. With three or more reflectors on every pose the rotation of the flange is
/// given too.
struct FieldData {
  RegressionData regression;
  Eigen::Vector3d p_F_mm{0, 0, 0};
};
FieldData field_data(const CalibratedCell& cell, std::span<const Measurement> points);

}  // namespace truepose
