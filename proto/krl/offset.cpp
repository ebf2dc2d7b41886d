#include "proto/krl/offset.hpp"

#include "core/math/angles.hpp"

namespace truepose::krl {

Eigen::Isometry3d pose_of_numbers(const std::array<double, 6>& v) {
  return pose_from_kuka({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
}

std::array<double, 6> numbers_of_pose(const Eigen::Isometry3d& X) {
  const Eigen::Vector3d p = X.translation(), abc = kuka_abc_deg(X.linear());
  return {p.x(), p.y(), p.z(), abc.x(), abc.y(), abc.z()};
}

std::array<double, 6> numbers_of(const Offset& offset) {
  std::array<double, 6> numbers{};
  for (std::size_t i = 0; i < 6; ++i) numbers[i] = offset.numbers[i] ? offset.numbers[i]->value : 0;
  return numbers;
}

Eigen::Isometry3d target_of(const Offset& offset, const Eigen::Isometry3d& from,
                            const Eigen::Isometry3d& point) {
  const std::array<double, 6> by = numbers_of(offset);
  switch (offset.kind) {
    case Offset::Kind::Behind:
      return point * pose_of_numbers(by);
    case Offset::Kind::Before:
      return pose_of_numbers(by) * point;
    case Offset::Kind::Tool:
      return from * pose_of_numbers(by);
    default:
      break;
  }
  std::array<double, 6> sum = numbers_of_pose(from);
  for (std::size_t i = 0; i < 6; ++i) sum[i] += by[i];
  return pose_of_numbers(sum);
}

std::array<double, 6> offset_to(const Offset& offset, const Eigen::Isometry3d& from,
                                const Eigen::Isometry3d& point, const Eigen::Isometry3d& target) {
  switch (offset.kind) {
    case Offset::Kind::Behind:
      return numbers_of_pose(point.inverse() * target);
    case Offset::Kind::Before:
      return numbers_of_pose(target * point.inverse());
    case Offset::Kind::Tool:
      return numbers_of_pose(from.inverse() * target);
    default:
      break;
  }
  std::array<double, 6> difference = numbers_of_pose(target);
  const std::array<double, 6> start = numbers_of_pose(from);
  for (std::size_t i = 0; i < 6; ++i) difference[i] -= start[i];
  return difference;
}

}  // namespace truepose::krl
