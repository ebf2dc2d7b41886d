#include "core/compensate/target_compensation.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "core/arm/joint_units.hpp"
#include "core/arm/robot_model.hpp"
#include "core/compensate/constrained_step.hpp"
#include "core/math/angles.hpp"
#include "core/step_count.hpp"

namespace truepose {

std::string cause_of(const CompensationFault& fault, const RobotModel& nominal) {
  const Joint& joint = nominal.joints[static_cast<std::size_t>(fault.joint)];
  const double unit = unit_of(joint);
  std::ostringstream text;
  switch (fault.kind) {
    case CompensationFault::Kind::DidNotConverge:
      text << "the calibrated arm cannot reach it: it is at the end of the arm's reach or in a singularity";
      break;
    case CompensationFault::Kind::TooFewJoints:
      text << "the calibrated arm cannot reach it: " << nominal.joint_count()
           << " joints cannot correct the six degrees of freedom of a pose";
      break;
    case CompensationFault::Kind::NotFinite:
      text << "the inverse of the calibrated arm is not finite";
      break;
    case CompensationFault::Kind::BeyondLimit:
      text << "joint " << fault.joint + 1 << " would have to go to " << fault.q_wrong / unit << ' '
           << unit_name(joint) << ", its limits are " << joint.min / unit << ".." << joint.max / unit;
      break;
    case CompensationFault::Kind::TooFar:
      text << "joint " << fault.joint + 1 << " would have to be corrected by " << std::fixed
           << std::setprecision(1) << fault.too_large / unit << ' ' << unit_name(joint)
           << ": too near to a singularity";
      break;
  }
  return text.str();
}

std::string way_out(CompensationFault::Kind kind) {
  switch (kind) {
    case CompensationFault::Kind::DidNotConverge:
    case CompensationFault::Kind::TooFar:
      return "move it away from there";
    case CompensationFault::Kind::TooFewJoints:
      return "correct the position alone (--position-only)";
    case CompensationFault::Kind::NotFinite:
      return "check the model";
    case CompensationFault::Kind::BeyondLimit:
      return "move it away from the limit";
  }
  return {};
}

std::string described(const CompensationFault& fault, const RobotModel& nominal) {
  return cause_of(fault, nominal) + "; " + way_out(fault.kind);
}

namespace {

constexpr int kPoseFreedoms = 6;
constexpr int kMaxSteps = 100;
constexpr double kLargestStep = 0.2;  // rad: from far away Newton does not leave the branch
constexpr double kTolerance_mm = 1e-9;
constexpr double kStill = 1e-10;  // rad: steps below do not count

constexpr double kLeastRatio = 0.03;    // of e to the bound
constexpr double kDampingRatio = 0.55;  // of lambda to that ratio
// The common turn may leave nothing of the bound, but a damping must stay finite.
constexpr double kLeastPartOfBound = 0.1;

/// Joint steps in the unit of the tasks, for which a millimetre of a slide is 1 / kLength_mm.
JointVector scales_of(const RobotModel& robot) {
  JointVector scales(robot.joint_count());
  for (Eigen::Index i = 0; i < scales.size(); ++i) {
    const bool turns = robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
    scales[i] = turns ? 1 : kLength_mm;
  }
  return scales;
}

/// The step, shortened where it is long.
JointVector shortened(const JointVector& step) {
  const double longest = step.cwiseAbs().maxCoeff();
  return longest > kLargestStep ? JointVector(step * (kLargestStep / longest)) : step;
}

/// lambda^2 of TargetCompensation.
/// @param apart  2 sin of half the angle between axes 4 and 6
double damping(const WristStep& first, double common, double apart, const CompensationOptions& options) {
  const double bound =
      std::max(options.singular_bound - std::abs(common), kLeastPartOfBound * options.singular_bound);
  const double ratio_squared = first.e_squared / (bound * bound) + kLeastRatio * kLeastRatio;
  const double below_squared = std::min(4 * ratio_squared, options.singular_below * options.singular_below);
  const double inside = std::max(0.0, 1 - apart * apart / below_squared);
  return kDampingRatio * kDampingRatio * ratio_squared * inside * inside;
}

/// How far a pose of the flange is off another.
struct PoseMiss {
  double rad = 0;
  double mm = 0;  // of the worst point within kReach_mm of the flange

  PoseMiss(const Eigen::Isometry3d& X, const Eigen::Isometry3d& wanted) {
    constexpr double kReach_mm = 300;
    const Eigen::Vector3d turn = turn_between(wanted.linear(), X.linear());
    const Eigen::Vector3d d_mm = X.translation() - wanted.translation();
    rad = turn.norm();
    // The turn moves the points square to its axis, the farthest of them along with d_mm.
    const double along = rad > 0 ? d_mm.dot(turn) / rad : 0;
    const double across = std::sqrt(std::max(0.0, d_mm.squaredNorm() - along * along));
    mm = std::hypot(along, across + 2 * std::sin(rad / 2) * kReach_mm);
  }
};

}  // namespace

/// The calibrated arm at some joints.
struct TargetCompensation::State {
  Eigen::Isometry3d X_BF;
  PositionTask task;  // its error is still to be set
  Eigen::Vector3d p_B_mm;

  double sense() const {  // of axis 6 to axis 4
    return axis(task.J.cols() - 3).dot(axis(task.J.cols() - 1)) > 0 ? 1 : -1;
  }
  double apart() const { return (axis(task.J.cols() - 3) - sense() * axis(task.J.cols() - 1)).norm(); }

 private:
  Eigen::Vector3d axis(Eigen::Index joint) const { return task.J.col(joint).tail<3>(); }
};

TargetCompensation::TargetCompensation(const RobotModel& nominal, const RobotModel& calibrated,
                                       const CompensationOptions& options)
    : nominal_{nominal},
      calibrated_{calibrated},
      nominal_geometry_{nominal},
      geometry_{calibrated},
      options_{options} {}

bool TargetCompensation::has_wrist() const {
  const auto& joints = calibrated_.joints;
  const auto turns = [](const Joint& joint) { return joint.type == JointType::Revolute; };
  // One that moves another of the three does not turn the flange about its own axis alone.
  const auto within = [&](const JointCoupling& each) { return each.to >= calibrated_.joint_count() - 3; };
  return joints.size() >= 6 && std::all_of(joints.end() - 3, joints.end(), turns) &&
         std::ranges::none_of(calibrated_.coupling, within);
}

NonGeometricError TargetCompensation::non_geometric_error(const JointVector& q) const {
  const JointVector joints = true_joints(calibrated_, q, options_.approach);
  NonGeometricError beyond{.q = q, .turned = joints - q};
  if (is_displaced(calibrated_)) {
    const Eigen::Isometry3d X_BF = geometry_.forward(joints);
    beyond.X_moved = displaced(calibrated_, q, joints, X_BF) * inverse_of(X_BF);
  }
  return beyond;
}

TargetCompensation::State TargetCompensation::state_at(const JointVector& q, const Eigen::Vector3d& p_F_mm,
                                                       const NonGeometricError* beyond) const {
  const JointVector joints =
      beyond ? JointVector(q + beyond->turned) : true_joints(calibrated_, q, options_.approach);
  PoseAndJacobian now;
  geometry_.forward_with_jacobian(joints, now);
  State state{now.X_BF, {now.J, {}}, {}};
  state.X_BF = beyond ? beyond->X_moved * now.X_BF : displaced(calibrated_, q, joints, now.X_BF);
  const Eigen::Vector3d lever = state.X_BF.linear() * p_F_mm;
  state.p_B_mm = state.X_BF.translation() + lever;
  const JointVector scales = scales_of(calibrated_);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Eigen::Vector3d axis = now.J.col(i).tail<3>();
    state.task.J.col(i).head<3>() += axis.cross(lever);
    state.task.J.col(i).head<3>() *= scales[i] / kLength_mm;
  }
  return state;
}

TargetCompensation::Result TargetCompensation::near(const JointVector& q_nominal,
                                                    const CompensatedTarget& target) const {
  Eigen::Index joint = 0;
  const JointVector correction = target.q - q_nominal;
  const double largest = correction.cwiseQuotient(scales_of(nominal_)).cwiseAbs().maxCoeff(&joint);
  if (largest <= options_.largest_correction) return within_limits(target);
  return std::unexpected(CompensationFault{.kind = CompensationFault::Kind::TooFar,
                                           .joint = static_cast<int>(joint),
                                           .too_large = correction[joint]});
}

TargetCompensation::Result TargetCompensation::within_limits(const CompensatedTarget& target) const {
  for (int i = 0; i < nominal_.joint_count(); ++i) {
    const Joint& joint = nominal_.joints[static_cast<std::size_t>(i)];
    if (!(target.q[i] >= joint.min && target.q[i] <= joint.max))
      return std::unexpected(CompensationFault{
          .kind = CompensationFault::Kind::BeyondLimit, .joint = i, .q_wrong = target.q[i]});
  }
  return target;
}

TargetCompensation::Result TargetCompensation::at_joints(const JointVector& q,
                                                         const Eigen::Vector3d& p_F_mm) const {
  return at_pose(nominal_geometry_.forward(q), q, p_F_mm);
}

TargetCompensation::Result TargetCompensation::at_joints_within(int steps, const JointVector& q,
                                                                const Eigen::Vector3d& p_F_mm,
                                                                JointVector& correction,
                                                                const NonGeometricError* beyond) const {
  Search search{.q = q + correction, .steps = steps, .beyond = beyond};
  const Result result = at_pose(nominal_geometry_.forward(q), q, p_F_mm, search);
  correction = search.q - q;
  const bool goes_on = result || result.error().kind == CompensationFault::Kind::DidNotConverge;
  // From elsewhere it would lead to another branch.
  if (!goes_on || !near(q, {.q = search.q})) correction.setZero();
  return result;
}

TargetCompensation::Result TargetCompensation::at_pose(const Eigen::Isometry3d& X_BF,
                                                       const JointVector& q_nominal,
                                                       const Eigen::Vector3d& p_F_mm) const {
  Search search{.q = q_nominal};
  Result result = at_pose(X_BF, q_nominal, p_F_mm, search);
  using Kind = CompensationFault::Kind;
  if (!result && result.error().kind == Kind::DidNotConverge && nominal_.joint_count() < kPoseFreedoms)
    result.error().kind = Kind::TooFewJoints;
  return result;
}

TargetCompensation::Result TargetCompensation::at_pose(const Eigen::Isometry3d& X_BF,
                                                       const JointVector& q_nominal,
                                                       const Eigen::Vector3d& p_F_mm, Search& search) const {
  count_step();
  if (!has_wrist() || options_.singular_below == 0) return exact(X_BF, q_nominal, search);
  const State start = state_at(q_nominal, p_F_mm, search.beyond);
  return start.apart() < options_.singular_below ? damped(X_BF, q_nominal, p_F_mm, start, search)
                                                 : exact(X_BF, q_nominal, search);
}

std::expected<PoseInverseResult, PoseInverseFault> TargetCompensation::inverse(
    const Eigen::Isometry3d& X_BF, const Search& search, const PoseInverseOptions& options) const {
  if (!search.beyond) return inverse_near(calibrated_, geometry_, X_BF, search.q, options);
  const NonGeometricError& beyond = *search.beyond;
  auto solved = geometry_.inverse_near(inverse_of(beyond.X_moved) * X_BF, search.q + beyond.turned, options);
  if (solved) solved->q -= beyond.turned;
  return solved;
}

TargetCompensation::Result TargetCompensation::exact(const Eigen::Isometry3d& X_BF,
                                                     const JointVector& q_nominal, Search& search) const {
  PoseInverseOptions options{.approach = options_.approach, .in_parts = search.steps.has_value()};
  options.max_iterations = search.steps.value_or(options.max_iterations);
  const auto solved = inverse(X_BF, search, options);
  using Kind = CompensationFault::Kind;
  if (!solved) {
    return std::unexpected(CompensationFault{
        solved.error() == PoseInverseFault::NotFinite ? Kind::NotFinite : Kind::DidNotConverge});
  }
  search.q = solved->q;
  if (solved->residual_mm > options.position_tolerance_mm ||
      solved->residual_rad > options.rotation_tolerance_rad)
    return std::unexpected(CompensationFault{Kind::DidNotConverge});
  return near(q_nominal, {solved->q, solved->residual_mm, solved->residual_rad, solved->iterations});
}

CompensatedTarget TargetCompensation::no_worse_than_none(const Eigen::Isometry3d& X_BF,
                                                         const JointVector& q_nominal,
                                                         const Eigen::Vector3d& p_F_mm,
                                                         const NonGeometricError* beyond,
                                                         CompensatedTarget target) const {
  constexpr int kHalvings = 24;
  constexpr double kNegligible = 1e-9;
  const PoseMiss none{state_at(q_nominal, p_F_mm, beyond).X_BF, X_BF};
  const JointVector correction = target.q - q_nominal;
  const auto is_worse = [&](double part) {
    const PoseMiss miss{state_at(q_nominal + part * correction, p_F_mm, beyond).X_BF, X_BF};
    return miss.rad > none.rad + kNegligible || miss.mm > none.mm + kNegligible * kLength_mm;
  };
  if (!is_worse(1)) return target;
  double good = 0, bad = 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (good + bad) / 2;
    (is_worse(middle) ? bad : good) = middle;
  }
  target.q = q_nominal + good * correction;
  const State state = state_at(target.q, p_F_mm, beyond);
  target.residual_mm = (X_BF * p_F_mm - state.p_B_mm).norm();
  target.residual_rad = angle_between(state.X_BF.linear(), X_BF.linear());
  return target;
}

TargetCompensation::Result TargetCompensation::damped(const Eigen::Isometry3d& X_BF,
                                                      const JointVector& q_nominal,
                                                      const Eigen::Vector3d& p_F_mm, State state,
                                                      Search& search) const {
  using Kind = CompensationFault::Kind;
  const JointVector scales = scales_of(calibrated_);
  const Eigen::Vector3d p_B_mm = X_BF * p_F_mm;
  const Eigen::Index axis_4 = q_nominal.size() - 3, axis_6 = q_nominal.size() - 1;
  CompensatedTarget result{.q = q_nominal, .damped = true};
  const double sense = -state.sense();
  double lambda_squared = 0;
  for (; result.iterations < search.steps.value_or(kMaxSteps); ++result.iterations) {
    if (result.iterations > 0) state = state_at(result.q, p_F_mm, search.beyond);
    const Eigen::Vector3d rotation_error = turn_between(state.X_BF.linear(), X_BF.linear());
    state.task.p_error = (p_B_mm - state.p_B_mm) / kLength_mm;
    const auto step = wrist_step(state.task, rotation_error, sense);
    if (!step) {
      const bool is_target_finite = X_BF.matrix().allFinite();
      return std::unexpected(CompensationFault{is_target_finite ? Kind::DidNotConverge : Kind::NotFinite});
    }
    if (result.iterations == 0) {
      lambda_squared = damping(*step, step->others[axis_4], state.apart(), options_);
      if (lambda_squared == 0) return exact(X_BF, q_nominal, search);
      if (search.q != q_nominal) {
        result.q = search.q;
        continue;
      }
    }

    const JointVector correction = result.q - q_nominal;
    const double u = (correction[axis_4] + sense * correction[axis_6]) / 2;
    const double t = (step->e_s - lambda_squared * u) / (step->s_squared + lambda_squared);
    const JointVector move = step->others + t * step->opposite;
    result.residual_mm = (p_B_mm - state.p_B_mm).norm();
    result.residual_rad = rotation_error.norm();
    search.q = result.q;
    if (result.residual_mm <= kTolerance_mm && move.cwiseAbs().maxCoeff() <= kStill)
      return near(q_nominal, no_worse_than_none(X_BF, q_nominal, p_F_mm, search.beyond, result));
    result.q += shortened(move).cwiseProduct(scales);
  }
  search.q = result.q;
  return std::unexpected(CompensationFault{Kind::DidNotConverge});
}

TargetCompensation::Result TargetCompensation::at_position(const Eigen::Vector3d& p_B_mm,
                                                           const JointVector& q_near,
                                                           const Eigen::Vector3d& p_F_mm) const {
  const JointVector scales = scales_of(calibrated_);
  JointVector q_goal = q_near;  // a held joint's goal is its limit
  std::bitset<kMaxJoints> held;
  CompensatedTarget result{.q = q_near};
  for (; result.iterations < kMaxSteps; ++result.iterations) {
    State state = state_at(result.q, p_F_mm, nullptr);
    state.task.p_error = (p_B_mm - state.p_B_mm) / kLength_mm;
    const auto step = nearest_step(state.task, (q_goal - result.q).cwiseQuotient(scales), held);
    if (!step) return std::unexpected(CompensationFault{CompensationFault::Kind::NotFinite});
    result.residual_mm = (p_B_mm - state.p_B_mm).norm();
    if (result.residual_mm > kTolerance_mm || step->cwiseAbs().maxCoeff() > kStill) {
      result.q += shortened(*step).cwiseProduct(scales);
      continue;
    }
    const auto checked = within_limits(result);
    if (checked || checked.error().kind != CompensationFault::Kind::BeyondLimit) return checked;
    const int i = checked.error().joint;
    const Joint& joint = nominal_.joints[static_cast<std::size_t>(i)];
    if (held[static_cast<std::size_t>(i)]) return checked;
    held.set(static_cast<std::size_t>(i));
    q_goal[i] = std::clamp(result.q[i], joint.min, joint.max);
  }
  return std::unexpected(CompensationFault{CompensationFault::Kind::DidNotConverge});
}

}  // namespace truepose
