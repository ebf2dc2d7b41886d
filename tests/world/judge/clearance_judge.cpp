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

Arm::Vector vector_of(const Eigen::Vector3d& p_mm) { return {p_mm[0], p_mm[1], p_mm[2]}; }

/// Without the links behind these.
Arm arm_until(const Arm& whole, std::size_t links) {
  Arm part = whole;
  for (std::size_t i = links; i < part.links.size(); ++i) part.links[i] = {.sign = 0};
  return part;
}

}  // namespace

ClearanceJudge::ClearanceJudge(Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {
  const Arm whole = nominal_arm(cell.scenario.nominal);
  const config::CellConfig& config = *cell.pc.running();
  for (const BodyPart& part : config.robot.body) {
    constexpr int kFirst = 2;  // whatever the axes are, those before it are where they are
    const auto links = std::min<std::size_t>(static_cast<std::size_t>(part.link), whole.links.size());
    if (part.link >= kFirst) bodies_.push_back(body_of(arm_until(whole, links), part.capsule));
  }
  for (const Capsule& obstacle : config.surroundings.obstacles)
    posts_.push_back({vector_of(obstacle.from_mm), vector_of(obstacle.to_mm), obstacle.radius_mm});
  posts_.push_back(tracker_of(cell));
}

ClearanceJudge::Body ClearanceJudge::body_of(const Arm& until, const Capsule& capsule) {
  Body body{until, until, capsule.radius_mm};
  body.from.reflector = vector_of(capsule.from_mm);
  body.to.reflector = vector_of(capsule.to_mm);
  return body;
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
  for (const Body& body : bodies_) {
    const Arm::Vector from = body.from.point(q), to = body.to.point(q);
    for (int step = 0; step <= kStepsOfALine; ++step) {
      const Arm::Vector p = between(from, to, static_cast<double>(step) / kStepsOfALine);
      if (p[2] < body.radius_mm) return false;
      for (const Post& post : posts_)
        if (distance_mm(p, post.from, post.to) < post.radius_mm + body.radius_mm) return false;
    }
  }
  return true;
}

}  // namespace truepose::world
