#pragma once

#include <chrono>
#include <string>

#include "proto/record/io.hpp"

namespace truepose::daemon {

struct ThreadHealth {
  std::string state;
  std::chrono::milliseconds still{0};  ///< since it last advanced
};
inline void layout(record::Io& io, ThreadHealth& x) {
  io("state", x.state, record::OneOf{"running", "idle", "stuck"});
  io("still_ms", x.still, record::kLargeCount);
}

/// Whether the daemon is well, for load balancers and people.
struct Health {
  std::string status;
  record::ByName<ThreadHealth> threads;

  bool well() const { return status == "ok"; }
};
inline void layout(record::Io& io, Health& x) {
  io("status", x.status, record::OneOf{"ok", "stuck", "stopping"});
  io("threads", x.threads);
}

}  // namespace truepose::daemon
