#pragma once

#include <array>
#include <boost/json/array.hpp>

#include "config/scenario.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::world {

/// An arm with its reflector before a tracker, computed by itself: mm and rad.
struct Arm {
  using Vector = std::array<double, 3>;
  /// Modified DH with Hayati's beta.
  struct Link {
    double a = 0, alpha = 0, d = 0, theta = 0, beta = 0, sign = 1;
  };

  /// Where the reflector is, in the frame of the tracker.
  Vector point(const std::array<double, 6>& q) const;

  std::array<Link, 6> links;
  Vector base{}, base_turn{};  ///< position, and turns about x, then y, then z of the tracker
  Vector reflector{};
};

/// By its data sheet, with the reflector in the flange's origin and the base in the tracker's.
Arm nominal_arm(const RobotModel& robot);
Arm true_arm(const config::Scenario& truth);
/// @param parameters  of model.get
/// @param nominal     whose axes turn as those of the model
Arm arm_of(const boost::json::array& parameters, const RobotModel& nominal);

}  // namespace truepose::world
