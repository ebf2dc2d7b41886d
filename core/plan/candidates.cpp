#include "core/plan/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/math/random.hpp"

namespace truepose {
namespace {

JointVector draw(const Scene& scene, Random& random) {
  JointVector q{scene.robot.joint_count()};
  for (int i = 0; i < scene.robot.joint_count(); ++i) {
    const Joint& joint = scene.robot.joints[static_cast<std::size_t>(i)];
    const double margin = joint.type == JointType::Revolute ? scene.limit_margin_rad : scene.limit_margin_mm;
    q[i] = random.uniform(joint.min + margin, joint.max - margin);
  }
  return q;
}

/// Poses of which no two are alike. Kept in the order of their first joint, so that a new one is compared
/// with those near it alone.
class DistinctPoses {
 public:
  DistinctPoses(const RobotModel& robot, double distinct_rad) : least_{robot.joint_count()} {
    for (int i = 0; i < robot.joint_count(); ++i) {
      const bool revolute = robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
      least_[i] = revolute ? distinct_rad : 1000 * distinct_rad;
    }
  }

  /// @return whether it was unlike all others, and so is one of them now
  bool add(const JointVector& q) {
    const auto end = by_first_.upper_bound(q[0] + least_[0]);
    for (auto other = by_first_.lower_bound(q[0] - least_[0]); other != end; ++other) {
      if (((q - other->second).array().abs() < least_.array()).all()) return false;
    }
    by_first_.emplace(q[0], q);
    return true;
  }

 private:
  JointVector least_;  ///< two poses that differ by less in every joint are alike
  std::multimap<double, JointVector> by_first_;
};

constexpr int kTriesBetweenLooks = 10'000;

/// Whether not even all tries would find enough: not at the highest rate that fits what was seen, three
/// standard deviations above it. The square root of a Poisson count has a standard deviation of 1/2; counting
/// one more keeps that true near zero.
bool hopeless(const Candidates& found, int tries, int least) {
  if (found.tried == 0 || found.tried % kTriesBetweenLooks != 0) return false;
  const double most = std::pow(std::sqrt(static_cast<double>(found.poses.size()) + 1) + 1.5, 2);
  return most / found.tried * tries < least;
}

std::string too_few(const Candidates& found, int wanted) {
  const auto most = std::ranges::max_element(found.faults);
  return "only " + std::to_string(found.poses.size()) + " of " + std::to_string(wanted) + " poses found in " +
         std::to_string(found.tried) + " tries; " + std::to_string(*most) + " " +
         std::string(fault_text(static_cast<PoseFault>(most - found.faults.begin()))) +
         ": check the tracker's placement, the reflector's direction, the workspace and what stands about "
         "the arm";
}

}  // namespace

std::expected<Candidates, std::string> draw_candidates(const Scene& scene, const CandidateOptions& options,
                                                       int least) {
  if (auto mistake = scene_mistake(scene)) return std::unexpected(*std::move(mistake));
  PoseChecker checker{scene};
  Random random{options.seed};
  Candidates found;
  DistinctPoses distinct{scene.robot, options.distinct_rad};
  const bool several = !scene.sight.further.empty() && options.visibility == Visibility::Required;
  const auto wanted = static_cast<std::size_t>(options.poses);
  for (; found.tried < options.tries && found.poses.size() < wanted; ++found.tried) {
    if (hopeless(found, options.tries, least)) break;
    const JointVector q = draw(scene, random);
    if (const auto fault = checker.fault_of(q, options.visibility)) {
      ++found.faults[static_cast<std::size_t>(*fault)];
    } else if (distinct.add(q)) {
      found.poses.push_back(q);
      if (several) found.seen.push_back(checker.seen_at(q).front());
    }
  }
  if (found.poses.size() < static_cast<std::size_t>(least))
    return std::unexpected(too_few(found, options.poses));
  return found;
}

}  // namespace truepose
