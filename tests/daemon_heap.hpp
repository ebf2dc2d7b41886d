#pragma once

#include <utility>

namespace truepose {

/// Whether what this thread allocates is the daemon's, or of the world about it. Counted by tests/world.
inline constinit thread_local bool allocates_for_daemon = false;

/// For as long as it lives.
class AllocatesFor {
 public:
  enum Owner { World, Daemon };
  explicit AllocatesFor(Owner owner) : before_{std::exchange(allocates_for_daemon, owner == Daemon)} {}
  ~AllocatesFor() { allocates_for_daemon = before_; }
  AllocatesFor(const AllocatesFor&) = delete;
  AllocatesFor& operator=(const AllocatesFor&) = delete;

 private:
  const bool before_;
};

}  // namespace truepose
