#pragma once

#include <boost/json/object.hpp>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges whether all clients come to know the same: an event that is kept and one has seen every other has
/// seen too, or was informed that it may be missing.
class EventJudge {
 public:
  /// @param clients  their names
  EventJudge(const std::vector<std::string>& clients, SoakLog& log);

  /// @param client  by its place among the names
  void take(std::size_t client, const boost::json::object& event);
  /// What events.subscribe answers.
  void subscribed(std::size_t client, const boost::json::object& answer);
  /// The store was replaced by a backup: what came since is known to no one.
  void restored();
  /// Of what all have passed.
  void judge();

  std::uint64_t compared = 0;

 private:
  using Seq = std::uint64_t;
  /// Events that it may miss, of these topics; of none: of all.
  struct Gap {
    Seq first, last;
    std::set<std::string> topics{};
  };
  struct Reader {
    std::string name;
    Seq last = 0;  // event of any topic
    std::vector<Gap> gaps{};
  };
  struct Seen {
    std::set<std::size_t> by{};  // readers
    std::string topic{};
  };

  static bool may_miss(const Reader& reader, Seq seq, const std::string& topic);
  void judge_event(Seq seq, const Seen& seen);

  SoakLog& log_;
  std::vector<Reader> readers_;
  std::map<Seq, Seen> events_;  // of topics that are kept, not judged so far
  Seq judged_ = 0;              // up to there
};

}  // namespace truepose::world
