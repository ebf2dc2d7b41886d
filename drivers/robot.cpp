#include "drivers/robot.hpp"

#include <array>
#include <string_view>
#include <utility>

namespace truepose::drivers {

std::string not_ready_text(const std::string& why_not_ready) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kWaysOut{
      {{"emergency stop", "release it, acknowledge it on the pendant and start truepose_motion there"},
       {"safety gate open", "close it, acknowledge it on the pendant and start truepose_motion there"},
       {"drives off", "switch them on, and start truepose_motion on the pendant"},
       {"a stop message is pending on the pendant", "acknowledge it there, and start truepose_motion"},
       {"the robot program is not running", "start truepose_motion on the pendant"}}};
  for (const auto& [why, way_out] : kWaysOut)
    if (why_not_ready == why) return "robot: " + why_not_ready + ": " + std::string{way_out};
  return "robot: " + why_not_ready + ": put that right on the pendant, and start truepose_motion there";
}

}  // namespace truepose::drivers
