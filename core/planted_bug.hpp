#pragma once

#include <string_view>
#ifdef TRUEPOSE_PLANTED_BUGS
#include <cstdlib>
#endif

/// A test that passes whatever the product does proves nothing. So tests/planted_bugs.py plants one bug after
/// another, by its name, and each must be found. Only the preset `planted` compiles them in.
namespace truepose {

struct PlantedBug {
  std::string_view name;
  std::string_view finds;  ///< the test program that has to find it
};

inline constexpr PlantedBug kPlantedBugs[]{
    {"zero at the start of each session", "daemon_stream_test"},
    {"a source that is not pinned", "daemon_stream_test"},
    {"a timeout of the controller that is a constant", "daemon_stream_test"},
    {"a limit from the last datagram, not from what is in effect", "daemon_stream_test"},
    {"a new start that is judged on one axis", "daemon_stream_test"},
    {"a waiting peer has no correction in effect", "daemon_stream_test"},
    {"a waiting peer has taken what it was offered", "daemon_stream_test"},

    {"half a document of a lost connection is kept", "daemon_test"},
    {"half a packet of a lost connection is kept", "daemon_test"},
    {"a lost device is tried every twenty seconds", "daemon_test"},

    {"a repeated motion order has a new number", "drivers_test"},
    {"connecting does not release a stop", "drivers_test"},
    {"an open gate is ready", "drivers_test"},
    {"an emergency stop is ready", "drivers_test"},
    {"the search radius is never set", "drivers_test"},
    {"an interrupted measurement is not stopped", "drivers_test"},
    {"a broken beam is waited for", "drivers_test"},
    {"a point of impossible air is taken", "drivers_test"},
    {"a tracker that was switched on is not initialised", "drivers_test"},
    {"settings of another program are not checked", "drivers_test"},
    {"the status of a bridge is ignored", "drivers_test"},
    {"an interrupted request of a bridge is not stopped", "drivers_test"},

    {"a commit is not synced", "world_test"},
    {"the audit trail is not synced", "world_test"},
    {"every hundredth event is dropped", "world_test"},
    {"an armed stream is forgotten at a restart", "world_test"},
    {"control never ends", "world_test"},
    {"a resumed campaign measures all again", "world_test"},
    {"the stream keeps its first model", "world_test"},
    {"a tool taken out of use is back after a restart", "world_test"},
    {"a correction that moves nothing is not noticed", "world_test"},
    {"a model of a resumed campaign stays in its first station", "world_test"},
    {"a model works on any arm that connects", "world_test"},
};

/// A name of the table. Any other does not compile.
class PlantedBugName {
 public:
  consteval PlantedBugName(const char* name) : name_{name} {
    for (const PlantedBug& bug : kPlantedBugs)
      if (bug.name == name_) return;
    throw "no planted bug has this name";
  }
  constexpr std::string_view name() const { return name_; }

 private:
  std::string_view name_;
};

#ifdef TRUEPOSE_PLANTED_BUGS
/// Whether TRUEPOSE_PLANTED_BUG names this bug.
inline bool planted(PlantedBugName bug) {
  static const char* const chosen = std::getenv("TRUEPOSE_PLANTED_BUG");
  return chosen && bug.name() == chosen;
}
#else
constexpr bool planted(PlantedBugName) { return false; }
#endif

}  // namespace truepose
