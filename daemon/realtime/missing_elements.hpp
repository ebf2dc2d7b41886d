#pragma once

#include <array>
#include <string_view>

#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

/// Looks for elements by which the stream is watched and that the controller does not send although its
/// configuration, as we read it, does: then it loaded another one. The realtime thread's own.
class MissingElements {
 public:
  explicit MissingElements(const rsi::EthernetConfig& ethernet) noexcept;

  void restart() noexcept;
  /// @param cycles  since the frame before
  /// @return the element that could not be read for `limit` cycles or more; empty: there is none
  std::string_view take(const rsi::RobotFrame& frame, double cycles, double limit) noexcept;

 private:
  struct Watched {
    std::string_view element;
    bool sent = false;
    double missing_cycles = 0;
  };
  std::array<Watched, 3> watched_{{{.element = "Delay"}, {.element = "AIPos"}, {.element = "RIst"}}};
};

}  // namespace truepose::daemon
