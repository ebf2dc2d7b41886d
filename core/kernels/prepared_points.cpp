#include "core/kernels/prepared_points.hpp"

#include <algorithm>
#include <cassert>

namespace truepose {
namespace {

constexpr int kLanes = kernels::kMostLanes;

int padded(int count) { return (count + kLanes - 1) / kLanes * kLanes; }

}  // namespace

PreparedPoints::PreparedPoints(const RobotModel& robot, std::span<const Measurement> points, int reflectors,
                               const Eigen::VectorXd& weights, const kernels::Kernels& code)
    : code_{&code}, joints_{robot.joint_count()} {
  begin_.resize(static_cast<std::size_t>(reflectors) + 1);
  place_.reserve(points.size());
  int end = 0;
  std::vector<int> next;
  for (int k = 0; k < reflectors; ++k) {
    begin_[static_cast<std::size_t>(k)] = end;
    next.push_back(end);
    end += padded(static_cast<int>(
        std::count_if(points.begin(), points.end(), [k](const Measurement& m) { return m.smr == k; })));
  }
  begin_.back() = end;
  for (const Measurement& point : points) place_.push_back(next[static_cast<std::size_t>(point.smr)]++);

  row_lines_ = end / kLanes;
  lines_.assign(static_cast<std::size_t>((kJoints + 2 * joints_) * row_lines_ + 1), {});
  for (std::size_t n = 0; n < points.size(); ++n) {
    for (int axis = 0; axis < 3; ++axis) row(kX + axis)[place_[n]] = points[n].p_WS_mm[axis];
    for (int i = 0; i < joints_; ++i) {
      row(kJoints + i)[place_[n]] = robot.joints[static_cast<std::size_t>(i)].sign * points[n].q[i];
    }
  }
  for (int i = 0; i < joints_; ++i) {
    if (robot.joints[static_cast<std::size_t>(i)].type == JointType::Prismatic) continue;
    double* const angle = row(kJoints + i);
    code.sincos(angle, row(kJoints + joints_ + i), angle, end);
  }
  reweight(weights);
}

void PreparedPoints::reweight(const Eigen::VectorXd& weights) {
  assert(weights.size() == 0 || weights.size() == size());
  for (std::size_t n = 0; n < place_.size(); ++n) {
    row(kWeight)[place_[n]] = weights.size() == 0 ? 1.0 : weights[static_cast<Eigen::Index>(n)];
  }
}

kernels::PointBlock PreparedPoints::of_reflector(int reflector) const {
  const int begin = begin_[static_cast<std::size_t>(reflector)];
  const int end = begin_[static_cast<std::size_t>(reflector) + 1];
  return {.measured = {row(kX) + begin, row(kY) + begin, row(kZ) + begin},
          .weight = row(kWeight) + begin,
          .first = row(kJoints) + begin,
          .second = row(kJoints + joints_) + begin,
          .stride = row_lines_ * kLanes,
          .count = end - begin};
}

}  // namespace truepose
