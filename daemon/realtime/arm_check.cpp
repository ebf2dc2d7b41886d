#include "daemon/realtime/arm_check.hpp"

#include <Eigen/Geometry>

#include "core/arm/forward.hpp"
#include "daemon/realtime/controller_session.hpp"

namespace truepose::daemon {
namespace {

// KR C2 counts cycles, all others milliseconds.
constexpr std::uint64_t kCountsCycles = 1;

}  // namespace

ArmCheck::ArmCheck(const RobotModel& nominal, std::chrono::milliseconds cycle, double max_deviation_mm)
    : nominal_{nominal},
      cycle_ms_{static_cast<std::uint64_t>(cycle.count())},
      second_cycles_{1000.0 / static_cast<double>(cycle.count())},
      max_deviation_mm_{max_deviation_mm} {}

std::optional<FoundFault> ArmCheck::cycle(std::uint64_t step) const noexcept {
  if (step == 0 || step == cycle_ms_ || step == kCountsCycles) return std::nullopt;
  return FoundFault{StreamFault::WrongCycle,
                    {.value = static_cast<double>(step), .limit = static_cast<double>(cycle_ms_)}};
}

std::optional<FoundFault> ArmCheck::arm(const rsi::RobotFrame& frame, std::uint64_t elapsed) noexcept {
  wait_ -= static_cast<double>(elapsed);
  if (wait_ > 0) return std::nullopt;
  wait_ = second_cycles_;
  if (!frame.rist || !frame.aipos_rad) return std::nullopt;
  const Eigen::Vector3d p_BF_mm = forward_kinematics(nominal_, vector_of(*frame.aipos_rad)).translation();
  const double off_mm =
      (Eigen::Vector3d{frame.rist->x_mm, frame.rist->y_mm, frame.rist->z_mm} - p_BF_mm).norm();
  if (off_mm <= max_deviation_mm_) return std::nullopt;
  return FoundFault{StreamFault::WrongArm, {.value = off_mm, .limit = max_deviation_mm_}};
}

}  // namespace truepose::daemon
