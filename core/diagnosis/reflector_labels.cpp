#include "core/diagnosis/reflector_labels.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <string>

#include "core/arm/forward.hpp"
#include "core/fit/placement.hpp"

namespace truepose {
namespace {

constexpr std::size_t kMostReflectors = 5;  // 120 orders to try
constexpr std::size_t kPosesToLabel = 5;

using Order = std::vector<int>;  // by name: which of the pose's names stands for it

/// The point of each reflector of a pose, or nothing where the pose does not show each of them once.
std::vector<std::size_t> by_reflector(std::span<const Measurement> points,
                                      const std::vector<std::size_t>& pose, std::size_t reflectors) {
  std::vector<std::size_t> point_of(reflectors, points.size());
  for (const std::size_t k : pose) point_of[static_cast<std::size_t>(points[k].smr)] = k;
  const bool complete = pose.size() == reflectors && std::ranges::count(point_of, points.size()) == 0;
  return complete ? point_of : std::vector<std::size_t>{};
}

Eigen::Matrix3Xd positions(std::span<const Measurement> points, const std::vector<std::size_t>& of) {
  Eigen::Matrix3Xd p(3, static_cast<Eigen::Index>(of.size()));
  for (std::size_t k = 0; k < of.size(); ++k) p.col(static_cast<Eigen::Index>(k)) = points[of[k]].p_WS_mm;
  return p;
}

Order best_order(const Eigen::Matrix3Xd& first, const Eigen::Matrix3Xd& other) {
  Order order(static_cast<std::size_t>(first.cols())), best;
  std::iota(order.begin(), order.end(), 0);
  double least = std::numeric_limits<double>::infinity();
  do {
    const double distance = (other(Eigen::all, order) - first).squaredNorm();
    if (distance < least) {
      least = distance;
      best = order;
    }
  } while (std::ranges::next_permutation(order).found);
  return best;
}

}  // namespace

Relabelled relabelled(const RobotModel& arm, std::span<const std::string> smr_names,
                      std::span<const Measurement> points) {
  Relabelled result{{points.begin(), points.end()}, {}};
  const std::size_t reflectors = smr_names.size();
  if (reflectors < 2 || reflectors > kMostReflectors) return result;

  std::vector<std::vector<std::size_t>> poses;
  std::vector<Measurement> middles;
  for (const auto& pose : pose_groups(points)) {
    const auto point_of = by_reflector(points, pose, reflectors);
    if (point_of.empty()) continue;
    poses.push_back(point_of);
    middles.push_back({.q = points[pose[0]].q, .p_WS_mm = positions(points, point_of).rowwise().mean()});
  }
  if (poses.size() < kPosesToLabel) return result;

  const std::string middle = "middle";
  const Eigen::Matrix3d R_WB = placement(arm, {&middle, 1}, middles).base.isometry().linear();
  Eigen::Matrix3Xd first;
  std::vector<Order> orders;
  std::map<Order, int> votes;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Eigen::Matrix3d R_WF = R_WB * forward_kinematics(arm, middles[k].q).linear();
    const Eigen::Matrix3Xd p_F =
        R_WF.transpose() * (positions(points, poses[k]).colwise() - middles[k].p_WS_mm);
    if (k == 0) first = p_F;
    orders.push_back(best_order(first, p_F));
    ++votes[orders.back()];
  }
  const Order agreed =
      std::ranges::max_element(votes, {}, [](const auto& vote) { return vote.second; })->first;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (orders[k] == agreed) continue;
    result.rows.push_back(points[*std::ranges::min_element(poses[k])].row);
    for (std::size_t name = 0; name < reflectors; ++name) {
      result.points[poses[k][static_cast<std::size_t>(orders[k][name])]].smr = agreed[name];
    }
  }
  return result;
}

}  // namespace truepose
