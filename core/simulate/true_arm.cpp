#include "core/simulate/true_arm.hpp"

#include <Eigen/Geometry>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/arm/joint_coupling.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"

namespace truepose {
namespace {

constexpr double kMetrePerMm = 1e-3;
// Each step gains three digits, since a deflection of a milliradian changes the torque by a thousandth.
constexpr int kEquilibriumSteps = 5;

/// Of the joints of the chain, which stand at q.
JointVector rigid_displacement(const NonGeometricErrors& errors, const JointVector& q,
                               const ApproachDirections& directions) {
  JointVector displacement = JointVector::Zero(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const DriveError& drive = errors.drives[static_cast<std::size_t>(i)];
    double order = 1;
    for (const GearHarmonic& harmonic : drive.harmonics) {
      displacement[i] += harmonic.amplitude_rad * std::sin(order * q[i] + harmonic.phase_rad);
      ++order;
    }
    if (!directions.empty())
      displacement[i] -= 0.5 * drive.backlash_rad * directions[static_cast<std::size_t>(i)];
  }
  return displacement;
}

}  // namespace

JointVector gravity_torque_Nm(const RobotModel& arm, const NonGeometricErrors& errors, const JointVector& q) {
  LinkFrames X_B;
  link_frames(arm, q, X_B);
  JointVector torque = JointVector::Zero(q.size());
  // From the last link inwards: force and its moment about the base's origin of all that hangs on the joint.
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  for (std::size_t i = arm.joints.size(); i-- > 0;) {
    const LinkMass& link = errors.masses[i];
    const Eigen::Isometry3d& X_Bi = X_B[i + 1];
    const Eigen::Vector3d weight = link.mass_kg * errors.gravity_B_mps2;
    force += weight;
    moment += (kMetrePerMm * (X_Bi * link.centre_mm)).cross(weight);
    if (arm.joints[i].type != JointType::Revolute) continue;
    const Eigen::Vector3d about_joint = moment - (kMetrePerMm * X_Bi.translation()).cross(force);
    torque[static_cast<Eigen::Index>(i)] = arm.joints[i].sign * X_Bi.linear().col(2).dot(about_joint);
  }
  return torque;
}

JointVector joint_displacement(const RobotModel& arm, const NonGeometricErrors& errors, const JointVector& q,
                               const ApproachDirections& directions) {
  assert(q.size() == arm.joint_count());
  if (errors.drives.empty()) return JointVector::Zero(q.size());
  assert(errors.drives.size() == arm.joints.size());
  const JointVector rigid = rigid_displacement(errors, chain_joints(arm.coupling, q), directions);
  if (errors.masses.empty()) return controller_joints(arm.coupling, rigid);

  JointVector displacement = rigid;
  for (int step = 0; step < kEquilibriumSteps; ++step) {
    const JointVector torque =
        gravity_torque_Nm(arm, errors, q + controller_joints(arm.coupling, displacement));
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      displacement[i] =
          rigid[i] + errors.drives[static_cast<std::size_t>(i)].compliance_rad_per_Nm * torque[i];
    }
  }
  return controller_joints(arm.coupling, displacement);
}

NonGeometricErrors heavy_arm_errors(const HeavyArmOptions& options) {
  NonGeometricErrors errors;
  errors.masses = {{280, {150, 0, -120}}, {190, {520, 0, 90}}, {220, {60, 180, 0}},
                   {110, {0, 0, -520}},   {45, {0, 40, 0}},    {25, {0, 0, -30}}};
  LinkMass& last = errors.masses.back();
  const double kg = last.mass_kg + options.payload_kg;
  const Eigen::Vector3d payload_centre_mm{40, 0, 180};
  last = {kg, (last.mass_kg * last.centre_mm + options.payload_kg * payload_centre_mm) / kg};

  constexpr std::array kStiffnessNmPerRad{8.0e6, 2.0e7, 1.5e7, 2.0e6, 2.0e6, 1.0e6};
  Random random{options.seed};
  for (const double stiffness : kStiffnessNmPerRad) {
    DriveError drive{.backlash_rad = options.backlash_rad};
    if (options.compliance) drive.compliance_rad_per_Nm = 1 / stiffness;
    // Drawn even where not used, so that a seed means the same gears with and without the other errors.
    double share = 1;
    for (GearHarmonic& harmonic : drive.harmonics) {
      const double amplitude_rad = share * random.uniform(0.05e-3, 0.15e-3);
      const double phase_rad = random.uniform(0, 2 * std::numbers::pi);
      if (options.harmonics) harmonic = {amplitude_rad, phase_rad};
      share /= 3;
    }
    errors.drives.push_back(drive);
  }
  return errors;
}

Eigen::Vector3d noisy_reading(const Eigen::Vector3d& p_true_mm, const TrackerNoiseModel& model,
                              Random& random) {
  const double distance_m = p_true_mm.norm() / 1000.0;
  const double range_mm = model.range_mm + model.range_mm_per_m * distance_m;
  const double transverse_mm = model.transverse_mm + model.transverse_mm_per_m * distance_m;

  const Eigen::Vector3d along =
      distance_m > 0 ? Eigen::Vector3d{p_true_mm.normalized()} : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d across = along.unitOrthogonal();
  // One draw a line: the order in which a sum's terms are evaluated is the compiler's choice.
  const double e_range_mm = range_mm * random.normal();
  const double e_across_mm = transverse_mm * random.normal();
  const double e_third_mm = transverse_mm * random.normal();
  return p_true_mm + e_range_mm * along + e_across_mm * across + e_third_mm * along.cross(across);
}

MeasuredOrientation noisy_orientation(const Eigen::Matrix3d& R_true, double sigma_rad, Random& random) {
  Eigen::Vector3d rotation_rad;
  for (double& about_axis : rotation_rad) about_axis = sigma_rad * random.normal();
  return {rotation_by(rotation_rad) * R_true, sigma_rad};
}

namespace {

// By so much (rad, mm) the joints of two poses may differ that were meant to be the same.
constexpr double kRounding = 1e-9;

}  // namespace

TrueArm::TrueArm(TrueArmSetup setup, std::uint64_t seed)
    : setup_{std::move(setup)},
      reflectors_{{setup_.p_FS_mm, setup_.facing_F, setup_.acceptance_rad}},
      robot_{setup_.robot},
      random_{seed} {
  reflectors_.insert(reflectors_.end(), setup_.further.begin(), setup_.further.end());
  for (TrueReflector& reflector : reflectors_) reflector.facing_F.normalize();
  stop_anew();
}

void TrueArm::stop_anew() {
  for (double& axis_mm : deviation_mm_) axis_mm = setup_.repeatability_mm * random_.normal();
}

void TrueArm::warm_up(Seconds since_start) { robot_ = warmed(setup_.robot, setup_.warm_up, since_start); }

void TrueArm::move(const JointVector& from, const JointVector& to) {
  directions_.resize(setup_.robot.joints.size(), 0);
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (std::abs(to[k] - from[k]) > kRounding) directions_[i] = to[k] > from[k] ? 1 : -1;
  }
  stands_at_ = to;
  stop_anew();
}

void TrueArm::move_to(const JointVector& q) { move(directions_.empty() ? q : stands_at_, q); }

Eigen::Isometry3d TrueArm::X_BF(const JointVector& q) const {
  return forward_kinematics(robot_, q + joint_displacement(robot_, setup_.non_geometric, q, directions_));
}

Eigen::Vector3d TrueArm::p_WS_mm(const JointVector& q, std::size_t reflector) const {
  return setup_.X_WB * (X_BF(q) * reflectors_[reflector].p_FS_mm + deviation_mm_);
}

Eigen::Matrix3d TrueArm::R_WT(const JointVector& q) const {
  return setup_.X_WB.linear() * X_BF(q).linear() * setup_.R_FT;
}

bool TrueArm::visible(const JointVector& q, std::size_t reflector) const {
  const TrueReflector& seen = reflectors_[reflector];
  const Eigen::Isometry3d X_BF_true = X_BF(q);
  const Eigen::Vector3d p_BS_mm = X_BF_true * seen.p_FS_mm;
  const Eigen::Vector3d to_tracker_B = (inverse_of(setup_.X_WB).translation() - p_BS_mm).normalized();
  const Eigen::Vector3d facing_B = X_BF_true.linear() * seen.facing_F;
  return p_BS_mm.z() > 0 && facing_B.dot(to_tracker_B) >= std::cos(seen.acceptance_rad);
}

}  // namespace truepose
