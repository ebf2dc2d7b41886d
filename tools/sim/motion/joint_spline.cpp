#include "tools/sim/motion/joint_spline.hpp"

#include <algorithm>
#include <cmath>

namespace truepose::sim {
namespace {

/// The speed at a point between two slopes: none where the axis turns back there, else so little that the
/// cubics stay between their ends.
/// Source: Fritsch and Butland, A method for constructing local monotone piecewise cubic interpolants, 1984.
double speed_between(double before, double after) {
  if (before * after <= 0) return 0;
  return 2 * before * after / (before + after);
}

}  // namespace

JointSpline::JointSpline(const JointVector& from, const std::vector<Leg>& legs) : times_s_{0}, points_{from} {
  std::vector<JointVector> slopes;
  for (const Leg& leg : legs) {
    if (leg.duration <= Seconds{0}) {
      times_s_.push_back(times_s_.back());
      slopes.push_back(JointVector::Zero(from.size()));
    } else {
      times_s_.push_back(times_s_.back() + leg.duration.count());
      slopes.push_back((leg.to - points_.back()) / leg.duration.count());
    }
    points_.push_back(leg.to);
  }
  speeds_.assign(points_.size(), JointVector::Zero(from.size()));
  for (std::size_t i = 0; i + 1 < slopes.size(); ++i)
    speeds_[i + 1] =
        slopes[i].binaryExpr(slopes[i + 1], [](double a, double b) { return speed_between(a, b); });
}

JointVector JointSpline::position(Seconds t) const {
  if (t >= duration()) return points_.back();
  const auto after = std::ranges::upper_bound(times_s_, t.count());
  const auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - times_s_.begin() - 1, 0));
  const double lasts = times_s_[i + 1] - times_s_[i];
  const double u = std::max(0.0, t.count() - times_s_[i]) / lasts, v = 1 - u;
  return v * v * (1 + 2 * u) * points_[i] + u * u * (3 - 2 * u) * points_[i + 1] +
         lasts * (u * v * v * speeds_[i] - u * u * v * speeds_[i + 1]);
}

}  // namespace truepose::sim
