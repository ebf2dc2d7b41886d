#include "tests/world/judge/truth_judge.hpp"

#include <Eigen/Geometry>
#include <array>

#include "core/math/random.hpp"
#include "tests/world/judge/arm.hpp"

namespace truepose::world {

Eigen::Vector3d true_point_mm(const JointVector& q_rad, const std::string& reflector,
                              const config::Scenario& truth) {
  std::array<double, 6> q{};
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = q_rad[static_cast<Eigen::Index>(i)];
  Arm arm = true_arm(truth);
  const bool is_second = reflector == "2";
  if (is_second)
    for (std::size_t i = 0; i < 3; ++i)
      arm.reflector[i] = truth.further_reflectors.at(0).p_FS_mm[static_cast<Eigen::Index>(i)];
  const Arm::Vector p_mm = arm.point(q);
  return {p_mm[0], p_mm[1], p_mm[2]};
}

double mean_error_mm(const boost::json::array& parameters, const config::Scenario& truth) {
  constexpr std::array<std::array<double, 2>, 6> kRanges_rad{
      {{-1, 1}, {-2, -1}, {1, 2}, {-1.5, 1.5}, {-1, 1}, {-1.5, 1.5}}};
  constexpr int kPoses = 100;
  const Arm real = true_arm(truth), model = arm_of(parameters, truth.nominal);
  Random random{1};
  Eigen::Matrix3Xd there(3, kPoses), found(3, kPoses);
  for (int pose = 0; pose < kPoses; ++pose) {
    std::array<double, 6> q{};
    for (std::size_t i = 0; i < q.size(); ++i) q[i] = random.uniform(kRanges_rad[i][0], kRanges_rad[i][1]);
    const Arm::Vector a = real.point(q), b = model.point(q);
    there.col(pose) << a[0], a[1], a[2];
    found.col(pose) << b[0], b[1], b[2];
  }
  // Where the tracker stands is not the arm's.
  const Eigen::Isometry3d to_there{Eigen::umeyama(found, there, false)};
  return (to_there * found - there).colwise().norm().mean();
}

}  // namespace truepose::world
