#include "tools/experiment/particle_swarm.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"

namespace truepose {
namespace {

constexpr double kConstriction = 0.7298, kPull = 1.49618;

/// Unknowns: rx, ry, rz, base position, then the coordinates of each reflector.
class Swarm {
 public:
  Swarm(const RobotModel& arm, std::span<const std::string> smr_names, std::span<const Measurement> points,
        const ParticleSwarmOptions& options)
      : points_{points}, options_{options}, random_{options.seed} {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double reach = options.reflector_mm;
    for (const Measurement& point : points) {
      flange_.push_back(forward_kinematics(arm, point.q));
      centre += point.p_WS_mm / static_cast<double>(points.size());
      reach = std::max(reach, flange_.back().translation().norm() + options.reflector_mm);
    }
    const auto dimensions = 6 + 3 * static_cast<Eigen::Index>(smr_names.size());
    low_ = Eigen::VectorXd::Constant(dimensions, -options.reflector_mm);
    high_ = -low_;
    low_.head<3>().setConstant(-std::numbers::pi);
    high_.head<3>().setConstant(std::numbers::pi);
    low_.segment<3>(3) = centre.array() - reach;
    high_.segment<3>(3) = centre.array() + reach;
  }

  Eigen::VectorXd best() {
    for (int n = 0; n < options_.particles; ++n) {
      Particle& p = swarm_.emplace_back();
      p.at = uniform(low_, high_);
      p.velocity = 0.5 * (uniform(low_, high_) - p.at);
      remember(p);
    }
    for (int i = 0; i < options_.iterations; ++i) {
      for (Particle& p : swarm_) {
        move(p);
        remember(p);
      }
    }
    return best_;
  }

 private:
  struct Particle {
    Eigen::VectorXd at, velocity, best;
    double best_cost = std::numeric_limits<double>::infinity();
  };

  Eigen::VectorXd uniform(const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
    Eigen::VectorXd x(low.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) x[k] = random_.uniform(low[k], high[k]);
    return x;
  }

  double cost(const Eigen::VectorXd& x) const {
    const Eigen::Matrix3d R = rotation_zyx(x[2], x[1], x[0]);
    double sum = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d p_FS = x.segment<3>(6 + 3 * points_[i].smr);
      sum += (R * (flange_[i] * p_FS) + x.segment<3>(3) - points_[i].p_WS_mm).squaredNorm();
    }
    return sum;
  }

  void move(Particle& p) {
    for (Eigen::Index k = 0; k < p.at.size(); ++k) {
      const double own = kPull * random_.uniform() * (p.best[k] - p.at[k]);
      const double shared = kPull * random_.uniform() * (best_[k] - p.at[k]);
      p.velocity[k] = kConstriction * p.velocity[k] + own + shared;
      p.at[k] += p.velocity[k];
      if (p.at[k] >= low_[k] && p.at[k] <= high_[k]) continue;
      p.at[k] = std::clamp(p.at[k], low_[k], high_[k]);
      p.velocity[k] *= -0.5;
    }
  }

  void remember(Particle& p) {
    const double here = cost(p.at);
    if (here < p.best_cost) {
      p.best_cost = here;
      p.best = p.at;
    }
    if (here < best_cost_) {
      best_cost_ = here;
      best_ = p.at;
    }
  }

  std::span<const Measurement> points_;
  ParticleSwarmOptions options_;
  Random random_;
  std::vector<Eigen::Isometry3d> flange_;
  Eigen::VectorXd low_, high_, best_;
  double best_cost_ = std::numeric_limits<double>::infinity();
  std::vector<Particle> swarm_;
};

}  // namespace

CalibratedCell particle_swarm_start(const RobotModel& arm, std::span<const std::string> smr_names,
                                    std::span<const Measurement> points,
                                    const ParticleSwarmOptions& options) {
  const Eigen::VectorXd x = Swarm(arm, smr_names, points, options).best();
  CalibratedCell cell{arm, {.p_mm = x.segment<3>(3), .rxyz_rad = x.head<3>()}, {}};
  for (std::size_t k = 0; k < smr_names.size(); ++k) {
    cell.reflectors.push_back({smr_names[k], x.segment<3>(6 + 3 * static_cast<Eigen::Index>(k))});
  }
  return cell;
}

}  // namespace truepose
