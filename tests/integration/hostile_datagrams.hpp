#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/math/random.hpp"

namespace truepose {

/// What somebody who wants to harm a stream sends to its port, one datagram after another: noise, nothing,
/// sixty kilobytes, elements in elements, frames cut short or with NaN, and frames as good as the
/// controller's own with a time stamp that it may be about to use and axes that it may have.
class HostileDatagrams {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param ipoc  of the controller's session, which it had at `then`: it counts milliseconds
  HostileDatagrams(std::uint64_t seed, std::uint64_t ipoc, Clock::time_point then);

  /// @return valid until the next call
  const std::string& next();

 private:
  std::string random_bytes(std::size_t size);
  std::string forged();
  std::string damaged(std::string frame);

  Random random_;
  std::uint64_t ipoc_;
  Clock::time_point then_;
  std::vector<std::string> prepared_;
  std::string forged_;
  std::size_t turn_ = 0;
};

}  // namespace truepose
