#pragma once

#include <array>
#include <boost/json/object.hpp>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges whether two clients come to know the same: an event that is kept and one has seen the other has
/// seen too, or was informed that it may be missing.
class EventJudge {
 public:
  explicit EventJudge(SoakLog& log) : log_{log} {}

  /// @param client  0 or 1
  void take(std::size_t client, const boost::json::object& event);
  /// What events.subscribe answers.
  void subscribed(std::size_t client, const boost::json::object& answer);
  /// The store was replaced by a backup: what came since is known to no one.
  void restored();
  /// Of what both have passed.
  void judge();

  std::uint64_t compared = 0;

 private:
  using Seq = std::uint64_t;
  struct Seen {
    std::array<bool, 2> by{};
    std::string topic;
  };

  bool may_miss(std::size_t client, Seq seq) const;

  SoakLog& log_;
  std::map<Seq, Seen> events_;                               // of topics that are kept, not judged so far
  std::array<Seq, 2> last_{};                                // event of any topic
  Seq judged_ = 0;                                           // up to there
  std::array<std::vector<std::pair<Seq, Seq>>, 2> missing_;  // ranges
};

}  // namespace truepose::world
