#include "tests/core/scene_oracle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace truepose::test {
namespace {

constexpr int kPoints = 150;

/// A row of equal spheres.
struct Spheres {
  std::vector<std::array<double, 3>> centres_mm;
  double radius_mm;
};

Spheres spheres(const Capsule& capsule, int points) {
  Spheres row{{}, capsule.radius_mm};
  for (int i = 0; i < points; ++i) {
    const double share = points == 1 ? 0 : static_cast<double>(i) / (points - 1);
    const Eigen::Vector3d centre_mm = (1 - share) * capsule.from_mm + share * capsule.to_mm;
    row.centres_mm.push_back({centre_mm.x(), centre_mm.y(), centre_mm.z()});
  }
  return row;
}

double nearest_mm(const Spheres& a, const Spheres& b) {
  double nearest_mm2 = std::numeric_limits<double>::infinity();
  for (const auto& [ax, ay, az] : a.centres_mm) {
    for (const auto& [bx, by, bz] : b.centres_mm) {
      const double x = ax - bx, y = ay - by, z = az - bz;
      nearest_mm2 = std::min(nearest_mm2, x * x + y * y + z * z);
    }
  }
  return std::sqrt(nearest_mm2) - a.radius_mm - b.radius_mm;
}

/// Points every few centimetres do for bodies, whose radii are as large; the beam is long and thin.
Spheres body_spheres(const Capsule& capsule) {
  return spheres(capsule, 2 + static_cast<int>((capsule.to_mm - capsule.from_mm).norm() / 20));
}

/// The link's transform written out as its four factors.
Eigen::Isometry3d link(const Joint& joint, double q) {
  using Eigen::AngleAxisd, Eigen::Translation3d, Eigen::Vector3d;
  const bool revolute = joint.type == JointType::Revolute;
  const double theta = joint.theta_rad + (revolute ? joint.sign * q : 0);
  const double d_mm = joint.d_mm + (revolute ? 0 : joint.sign * q);
  return AngleAxisd(joint.beta_rad, Vector3d::UnitY()) * AngleAxisd(joint.alpha_rad, Vector3d::UnitX()) *
         Translation3d(joint.a_mm, 0, 0) * AngleAxisd(theta, Vector3d::UnitZ()) * Translation3d(0, 0, d_mm);
}

}  // namespace

double sampled_distance_mm(const Capsule& a, const Capsule& b, int points) {
  return nearest_mm(spheres(a, points), spheres(b, points));
}

OracleVerdict judge_by_sampling(const Scene& scene, const JointVector& q) {
  std::vector<Eigen::Isometry3d> X{Eigen::Isometry3d::Identity()};
  for (int i = 0; i < scene.robot.joint_count(); ++i)
    X.push_back(X.back() * link(scene.robot.joints[static_cast<std::size_t>(i)], q[i]));
  const int last = scene.robot.joint_count();
  X.push_back(X.back() * scene.robot.X_flange);

  const Eigen::Vector3d p_mm = X.back() * scene.sight.p_FS_mm;
  const Eigen::Vector3d tracker_mm = scene.sight.X_WB.inverse() * Eigen::Vector3d::Zero();
  const Eigen::Vector3d facing = X.back().linear() * scene.sight.facing_F;
  const double angle = std::atan2(facing.cross(tracker_mm - p_mm).norm(), facing.dot(tracker_mm - p_mm));

  const Surroundings& about = scene.surroundings;
  const Spheres post =
      body_spheres({tracker_mm,
                    {tracker_mm.x(), tracker_mm.y(), std::min(about.floor_mm, tracker_mm.z())},
                    about.tracker_radius_mm});
  const Spheres beam = spheres({tracker_mm, p_mm, 0}, 4 * kPoints);

  OracleVerdict verdict{.seen = angle <= scene.sight.acceptance_rad + 1e-9,
                        .clearance_mm = p_mm.z() - about.floor_mm,
                        .beam_clearance_mm = 1e9,
                        .mount_clearance_mm = 1e9};
  std::vector<Spheres> bodies;
  for (const BodyPart& part : scene.body)
    bodies.push_back(body_spheres(X[static_cast<std::size_t>(part.link)] * part.capsule));
  const auto keep = [](double& least, double value) { least = std::min(least, value); };
  for (const Capsule& obstacle : about.obstacles)
    keep(verdict.beam_clearance_mm, nearest_mm(beam, body_spheres(obstacle)));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const int link_i = std::min(scene.body[i].link, last);
    keep(link_i == last ? verdict.mount_clearance_mm : verdict.beam_clearance_mm,
         nearest_mm(beam, bodies[i]));
    if (link_i < 2) continue;
    for (const auto& [x, y, z] : bodies[i].centres_mm)
      keep(verdict.clearance_mm, z - bodies[i].radius_mm - about.floor_mm);
    keep(verdict.clearance_mm, nearest_mm(bodies[i], post));
    for (const Capsule& obstacle : about.obstacles)
      keep(verdict.clearance_mm, nearest_mm(bodies[i], body_spheres(obstacle)));
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      if (link_i - std::min(scene.body[k].link, last) >= 2)
        keep(verdict.clearance_mm, nearest_mm(bodies[i], bodies[k]));
    }
  }
  return verdict;
}

}  // namespace truepose::test
