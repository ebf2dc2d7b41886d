#include "core/simulate/measurement_campaign.hpp"

#include <cmath>
#include <numeric>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"

namespace truepose {
namespace {

Eigen::Vector3d normal_vector(Random& random) {
  Eigen::Vector3d v;
  for (double& axis : v) axis = random.normal();
  return v;
}

/// The first `count` of a seeded shuffle (Fisher and Yates).
std::vector<bool> drawn(std::size_t of, std::size_t count, Random& random) {
  std::vector<std::size_t> order(of);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<bool> is_drawn(of, false);
  for (std::size_t i = 0; i < count; ++i) {
    std::swap(order[i], order[i + random.next() % (of - i)]);
    is_drawn[order[i]] = true;
  }
  return is_drawn;
}

}  // namespace

SimulatedCampaign measure_campaign(const TrueArmSetup& arm, std::span<const JointVector> identify,
                                   std::span<const JointVector> validate, const CampaignOptions& options) {
  // Streams of their own, so that outliers do not change the noise of the other points.
  Random seeds{options.seed};
  TrueArm repeating{arm, seeds.next()};
  Random noise{seeds.next()}, fault{seeds.next()}, turning{seeds.next()};
  TrueArmSetup exact_setup = arm;
  exact_setup.repeatability_mm = 0;
  TrueArm exact{std::move(exact_setup), 0};

  SimulatedCampaign campaign;
  campaign.data.smr_names = {"1"};
  const auto faults =
      static_cast<std::size_t>(std::llround(options.gross.fraction * static_cast<double>(identify.size())));
  campaign.gross = drawn(identify.size(), faults, fault);
  campaign.gross.resize(identify.size() + validate.size(), false);

  const auto measure = [&](const JointVector& q, PoseSet set) {
    repeating.move_to(q);
    exact.move_to(q);
    Measurement point{.q = q, .set = set};
    campaign.p_stood_mm.push_back(repeating.p_WS_mm(q));
    point.p_WS_mm = campaign.p_stood_mm.back() + options.tracker_noise_mm * normal_vector(noise);
    if (campaign.gross[campaign.data.points.size()]) {
      const double length_mm = fault.uniform(options.gross.min_mm, options.gross.max_mm);
      point.p_WS_mm += length_mm * normal_vector(fault).normalized();
    }
    if (options.turn_noise_rad > 0)
      point.orientation = noisy_orientation(repeating.R_WT(q), options.turn_noise_rad, turning);
    if (options.record_directions) point.direction = repeating.directions();
    campaign.p_true_mm.push_back(exact.p_WS_mm(q));
    campaign.data.points.push_back(std::move(point));
  };
  for (const JointVector& q : identify) measure(q, PoseSet::Identify);
  for (const JointVector& q : validate) measure(q, PoseSet::Validate);
  return campaign;
}

std::vector<JointVector> random_poses(const RobotModel& robot, int count, Random& random) {
  std::vector<JointVector> poses;
  while (static_cast<int>(poses.size()) < count) {
    JointVector q{robot.joint_count()};
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
      q[i] = random.uniform(joint.min, joint.max);
    }
    if (forward_kinematics(robot, q).translation().z() > 0) poses.push_back(std::move(q));
  }
  return poses;
}

}  // namespace truepose
