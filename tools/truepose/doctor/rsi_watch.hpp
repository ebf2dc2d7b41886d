#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/kuka/rsi_link.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "proto/rsi/frame_elements.hpp"

namespace truepose::tools {

/// What one sender sends to an RSI port that answers nothing.
struct RsiSender {
  drivers::UdpSource source;
  std::uint64_t frames = 0;  ///< that can be believed
  std::uint64_t malformed = 0;
  drivers::TimePoint first{}, last{};           ///< arrival of its first and last datagram
  drivers::Duration longest{0};                 ///< between two of them
  std::optional<drivers::Duration> shortest{};  ///< between two of them
  std::uint64_t ipoc_begin = 0, ipoc = 0;       ///< of the first frame and the last
  std::uint64_t ipoc_step = 0;              ///< least that it rises from frame to frame; 0 = not yet known
  std::optional<std::int64_t> delay_begin;  ///< of the first frame
  rsi::RobotFrame frame;                    ///< the last one
  rsi::FrameElements elements;              ///< of the last one
  std::string why_malformed;                ///< of the last malformed one: the reason, its byte and 80 bytes

  /// By their arrival; none before the second datagram.
  std::optional<double> cycle_ms() const;
  bool delay_rises() const { return delay_begin && frame.delay && *frame.delay > *delay_begin; }
};

/// Looks at the datagrams that come to an RSI port. No I/O and no clock.
class RsiWatch {
 public:
  void take(const drivers::Datagram& datagram, bool cut);

  /// In the order of their addresses; later senders of a flood are left out.
  std::vector<RsiSender> senders() const;
  std::uint64_t frames() const { return frames_; }

 private:
  static constexpr std::size_t kMostSenders = 32;

  std::map<std::pair<std::uint32_t, std::uint16_t>, RsiSender> senders_;
  std::uint64_t frames_ = 0;
};

}  // namespace truepose::tools
