#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "core/arm/robot_model.hpp"
#include "proto/eki/messages.hpp"

namespace truepose::sim {

inline eki::Axes axes_of(const JointVector& q) {
  eki::Axes axes;
  std::ranges::copy(q, axes.begin());
  return axes;
}

inline JointVector joints_of(const eki::Axes& axes) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 1>>(axes.data());
}

}  // namespace truepose::sim
