#include "core/arm/status_turn.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/arm/forward.hpp"
#include "core/arm/pose_inverse.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"

namespace truepose {
namespace {

// A taught position is rounded to some decimals: an axis on its boundary may come back on the other side.
constexpr double kRounding_rad = 0.01 * kRadPerDeg;
constexpr double kRounding_mm = 0.1;
// Nearer to a boundary than this, which side the controller finds is not the position's doing.
constexpr double kOnBoundary = 1e-8;
constexpr double kLimitSlack_rad = 1e-9;

bool bit(int bits, std::size_t i) { return (bits >> i) & 1; }

/// Whether a measure whose sign decides a bit agrees with it, up to rounding.
bool agrees(double measure, bool is_set, double rounding) {
  return is_set ? measure >= -rounding : measure <= rounding;
}

int chosen_bit(double measure, std::size_t i, std::optional<int> given) {
  const bool is_set = given && std::abs(measure) < kOnBoundary ? bit(*given, i) : measure > 0;
  return is_set ? 1 << i : 0;
}

std::string described(std::optional<int> status, std::optional<int> turn) {
  std::string text;
  if (status) text += " with S " + std::to_string(*status);
  if (turn) text += std::string(status ? " and" : " with") + " T " + std::to_string(*turn);
  return text;
}

}  // namespace

std::expected<StatusTurnInverse, std::string> StatusTurnInverse::of(const RobotModel& nominal) {
  auto closed_form = SphericalWristInverse::of(nominal);
  if (!closed_form) return std::unexpected(closed_form.error());
  return StatusTurnInverse(nominal, *closed_form);
}

std::expected<StatusTurnInverse, std::string> StatusTurnInverse::by_search(const RobotModel& nominal) {
  auto inverse = of(nominal);
  if (inverse || nominal.joint_count() != 6) return inverse;
  return StatusTurnInverse(nominal, std::nullopt);
}

std::vector<JointVector> StatusTurnInverse::all(const Eigen::Isometry3d& X_BF,
                                                const JointVector& reference) const {
  if (!closed_form_) return searched(X_BF, reference);
  const auto found = closed_form_->all(X_BF, reference);
  return {found.q.begin(), found.q.begin() + found.count};
}

std::vector<JointVector> StatusTurnInverse::searched(const Eigen::Isometry3d& X_BF,
                                                     const JointVector& reference) const {
  constexpr int kStarts = 60;  // of 8 to 16 branches each is found from several
  constexpr double kSame_rad = 1e-6;
  std::vector<JointVector> found;
  Random random(0);
  JointVector seed = reference;
  for (int start = 0; start < kStarts; ++start) {
    if (const auto solved = inverse_near(nominal_, X_BF, seed)) {
      JointVector q = solved->q;
      for (double& angle : q) angle = std::remainder(angle, 2 * std::numbers::pi);
      const auto is_same = [&](const JointVector& other) {
        return (q - other).cwiseAbs().maxCoeff() < kSame_rad;
      };
      if (std::ranges::none_of(found, is_same)) found.push_back(q);
    }
    for (std::size_t i = 0; i < 6; ++i)
      seed[static_cast<Eigen::Index>(i)] = random.uniform(nominal_.joints[i].min, nominal_.joints[i].max);
  }
  return found;
}

bool StatusTurnInverse::has_status(const JointVector& q, std::optional<int> status) const {
  if (!status || !closed_form_) return true;
  const auto measures = status_measures(q);
  return agrees(measures[0], bit(*status, 0), kRounding_mm) &&
         agrees(measures[1], bit(*status, 1), kRounding_rad) &&
         agrees(measures[2], bit(*status, 2), kRounding_rad);
}

std::array<double, 3> StatusTurnInverse::status_measures(const JointVector& q) const {
  const auto& joints = nominal_.joints;
  LinkFrames X_B;
  link_frames(nominal_, q, X_B);
  // The base frame turned by A1 about axis 1.
  const Eigen::Isometry3d X_turned = X_B[1] * inverse_of(link_transform(joints[0], 0));
  const double wrist_x_mm = (inverse_of(X_turned) * X_B[5].translation()).x();
  // In link frame 3, x points away from axis 2: the forearm is in line with it where its angle is 0.
  const Eigen::Vector3d forearm = inverse_of(X_B[3]) * X_B[5].translation();
  const Eigen::Vector3d upper_arm =
      X_B[3].linear().transpose() * (X_B[3].translation() - X_B[2].translation());
  const double elbow = std::atan2(upper_arm.x() * forearm.y() - upper_arm.y() * forearm.x(),
                                  upper_arm.head<2>().dot(forearm.head<2>()));
  // Bits 1 and 2 are set also where the axis stands exactly on the boundary.
  constexpr double kLeast = std::numeric_limits<double>::min();
  return {-wrist_x_mm, joints[2].sign * elbow + kLeast, kLeast - q[4]};
}

StatusTurn StatusTurnInverse::of_joints(const JointVector& q, const std::optional<StatusTurn>& given) const {
  const auto given_status = given ? std::optional(given->status) : std::nullopt;
  const auto given_turn = given ? std::optional(given->turn) : std::nullopt;
  StatusTurn result;
  if (closed_form_) {
    const auto measures = status_measures(q);
    for (std::size_t i = 0; i < measures.size(); ++i)
      result.status |= chosen_bit(measures[i], i, given_status);
  } else {
    result.status = given_status.value_or(0) & kStatusBits;
  }
  for (std::size_t i = 0; i < 6; ++i)
    result.turn |= chosen_bit(-q[static_cast<Eigen::Index>(i)], i, given_turn);
  return result;
}

std::optional<JointVector> StatusTurnInverse::turned(JointVector q, std::optional<int> turn,
                                                     const std::optional<JointVector>& near) const {
  constexpr double kTurn = 2 * std::numbers::pi;
  for (std::size_t i = 0; i < 6; ++i) {
    const Joint& joint = nominal_.joints[i];
    const auto axis = static_cast<Eigen::Index>(i);
    // A turn tells the sign of an axis, and so which of two positions 360 deg apart is meant.
    const double reference = turn || !near ? 0 : (*near)[axis];
    double best = std::numeric_limits<double>::infinity();
    for (const double k : {0.0, -1.0, 1.0, -2.0, 2.0}) {
      const double candidate = q[axis] + k * kTurn;
      if (candidate < joint.min - kLimitSlack_rad || candidate > joint.max + kLimitSlack_rad) continue;
      if (turn && !agrees(-candidate, bit(*turn, i), kRounding_rad)) continue;
      if (std::abs(candidate - reference) < std::abs(best - reference)) best = candidate;
    }
    if (!std::isfinite(best)) return std::nullopt;
    q[axis] = best;
  }
  return q;
}

std::expected<JointVector, std::string> StatusTurnInverse::solve(
    const Eigen::Isometry3d& X_BF, std::optional<int> status, std::optional<int> turn,
    const std::optional<JointVector>& near) const {
  const bool has_status_and_turn = status && turn;
  if (!has_status_and_turn && !near)
    return std::unexpected("S and T are not both given, and where the arm comes from is not known");
  // In the wrist singularity the controller puts A4 to 0, unless $SINGUL_POS says otherwise. Without a status
  // the turn may leave several: then the nearest to where the arm comes from.
  const bool is_decided = has_status_and_turn && closed_form_;
  const JointVector reference = is_decided || !near ? JointVector(JointVector::Zero(6)) : *near;
  const std::vector<JointVector> solutions = all(X_BF, reference);
  if (solutions.empty()) return std::unexpected("the position is out of the arm's reach");

  std::optional<JointVector> best;
  std::pair best_rank{true, 0.0};
  for (const JointVector& solution : solutions) {
    const auto q = turned(solution, turn, near);
    if (!q || !has_status(*q, status)) continue;
    // One that agrees only up to rounding comes after one that agrees.
    const bool is_rounded = status && of_joints(*q, StatusTurn{*status, 0}).status != (*status & kStatusBits);
    const std::pair rank{is_rounded, (*q - reference).squaredNorm()};
    if (best && rank >= best_rank) continue;
    best = q;
    best_rank = rank;
  }
  if (best) return *best;
  return std::unexpected("the arm cannot take the position" + described(status, turn) +
                         " within its joint limits");
}

}  // namespace truepose
