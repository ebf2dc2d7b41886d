#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <string>

#include "drivers/clock.hpp"

namespace truepose::daemon {

/// Who was not let in lately, and how often. Of very many those that failed last are known.
class FailedLogins {
 public:
  static constexpr std::size_t kMostPeers = 1000;

  /// @param window  how long each counts
  explicit FailedLogins(drivers::Duration window) : window_{window} {}

  void count(const std::string& peer, drivers::TimePoint now);
  /// How many of a peer count now.
  std::size_t of(const std::string& peer, drivers::TimePoint now);
  std::size_t peers() const { return times_.size(); }

 private:
  void forget_old(drivers::TimePoint now);

  drivers::Duration window_;
  std::map<std::string, std::deque<drivers::TimePoint>> times_;  ///< of each peer, none without
};

}  // namespace truepose::daemon
