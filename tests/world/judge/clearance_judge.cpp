#include "tests/world/judge/clearance_judge.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <string>

namespace truepose::world {

using namespace std::chrono_literals;

namespace {

constexpr int kStepsOfALine = 40;

Arm::Vector between(const Arm::Vector& a, const Arm::Vector& b, double part) {
  Arm::Vector p{};
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = a[i] + part * (b[i] - a[i]);
  return p;
}

double distance_mm(const Arm::Vector& a, const Arm::Vector& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

double distance_mm(const Arm::Vector& p, const Arm::Vector& from, const Arm::Vector& to) {
  double along = 0;
  for (std::size_t i = 0; i < p.size(); ++i) along += (p[i] - from[i]) * (to[i] - from[i]);
  const double length_mm = distance_mm(from, to);
  return distance_mm(p, between(from, to, std::clamp(along / (length_mm * length_mm), 0.0, 1.0)));
}

/// Without the links behind these.
Arm arm_until(const Arm& whole, std::size_t links) {
  Arm part = whole;
  part.reflector = {};
  for (std::size_t i = links; i < part.links.size(); ++i) part.links[i] = {};
  return part;
}

}  // namespace

ClearanceJudge::ClearanceJudge(Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {
  Arm whole = nominal_arm(cell.scenario.nominal);
  for (const std::size_t links : {2U, 3U, 4U}) parts_.push_back(arm_until(whole, links));
  for (int i = 0; i < 3; ++i) whole.reflector[static_cast<std::size_t>(i)] = cell.scenario.p_FS_mm[i];
  parts_.push_back(whole);
  for (const Capsule& obstacle : cell.pc.running()->surroundings.obstacles) {
    const auto vector_of = [](const Eigen::Vector3d& p_mm) { return Arm::Vector{p_mm[0], p_mm[1], p_mm[2]}; };
    posts_.push_back({vector_of(obstacle.from_mm), vector_of(obstacle.to_mm), obstacle.radius_mm});
  }
  posts_.push_back(tracker_of(cell));
}

ClearanceJudge::Post ClearanceJudge::tracker_of(const Cell& cell) {
  const Eigen::Vector3d p_mm = -(cell.scenario.X_WB.linear().transpose() * cell.scenario.X_WB.translation());
  constexpr double kStand_mm = 150;
  return {{p_mm[0], p_mm[1], 0}, {p_mm[0], p_mm[1], p_mm[2]}, kStand_mm};
}

void ClearanceJudge::look(bool campaign_measures) {
  const JointVector q_rad = cell_.devices.axes();
  if (q_rad_.size() > 0 && q_rad == q_rad_) return;
  q_rad_ = q_rad;
  const bool clear = is_clear(q_rad);
  if (was_clear_ && !clear && campaign_measures && !log_.was_jogged(2s))
    log_.broken("the arm is driven into what stands about it");
  was_clear_ = clear;
}

bool ClearanceJudge::is_clear(const JointVector& q_rad) const {
  std::array<double, 6> q{};
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = q_rad[static_cast<Eigen::Index>(i)];
  std::vector<Arm::Vector> points;
  for (const Arm& part : parts_) points.push_back(part.point(q));
  for (std::size_t i = 1; i < points.size(); ++i) {
    for (int step = 0; step <= kStepsOfALine; ++step) {
      const Arm::Vector p = between(points[i - 1], points[i], static_cast<double>(step) / kStepsOfALine);
      if (p[2] < 0) return false;
      for (const Post& post : posts_)
        if (distance_mm(p, post.from, post.to) < post.radius_mm) return false;
    }
  }
  return true;
}

}  // namespace truepose::world
