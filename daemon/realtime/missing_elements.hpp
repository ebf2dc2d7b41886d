#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "daemon/realtime/stream_status.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

/// Looks for elements by which the stream is watched and that the controller does not send although its
/// configuration, as we read it, does: then it loaded another one. The realtime thread's own.
class MissingElements {
 public:
  /// @param limit_cycles  for so long an element may be missing
  MissingElements(const rsi::EthernetConfig& ethernet, double limit_cycles) noexcept;

  void restart() noexcept;
  /// @param elapsed  cycles since the frame before
  /// @return NotSent or nothing
  std::optional<FoundFault> take(const rsi::RobotFrame& frame, std::uint64_t elapsed) noexcept;

 private:
  struct Watched {
    std::string_view element;
    bool sent = false;
    double missing_cycles = 0;
  };
  double limit_cycles_;
  std::array<Watched, 3> watched_{{{.element = "Delay"}, {.element = "AIPos"}, {.element = "RIst"}}};
};

}  // namespace truepose::daemon
