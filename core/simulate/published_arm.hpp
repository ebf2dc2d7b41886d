#pragma once

#include <array>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// The KR 210 R2700-2 of the method's paper as its data sheet has it (its Table 1, with the zero positions,
/// signs, limits and speeds of the controller's axes), without masses.
RobotModel published_arm();

/// Errors of one link, mm and rad.
struct LinkErrors {
  double a_mm, alpha_rad, d_mm, theta_rad, beta_rad;
};

/// The errors injected into the simulated KR 210 of the method's paper (its Table 2), axis 1 first.
inline constexpr std::array<LinkErrors, 6> kPublishedErrors{{
    {0.45, 0.003, 0.72, 0.0015, 0},
    {0.63, 0.002, 0.43, 0.0032, 0},
    {0.55, 0.003, 0.21, 0.0026, 0.001},
    {0.32, 0.006, 0.32, 0.0018, 0},
    {0.72, 0.004, 0.51, 0.0012, 0},
    {0.23, 0.005, 0.62, 0.0022, 0},
}};

/// The six-axis arm with the published errors added.
RobotModel with_published_errors(RobotModel nominal);

}  // namespace truepose
