#include "core/data/carried_payload.hpp"

#include <algorithm>

namespace truepose {

bool payload_varies(std::span<const Measurement> points) {
  return std::ranges::adjacent_find(points, std::ranges::not_equal_to{}, &Measurement::payload) !=
         points.end();
}

RobotModel carrying_as_measured(RobotModel robot, std::span<const Measurement> points) {
  if (!points.empty() && points.front().payload && !payload_varies(points))
    robot.payload = points.front().payload;
  return robot;
}

}  // namespace truepose
