#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "tests/world/client.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges measured points: what was reported as measured is in the store.
class PointJudge {
 public:
  explicit PointJudge(SoakLog& log) : log_{log} {}

  /// An event of the topic measurement.
  void take(const boost::json::object& measurement);
  /// Reads the points of each campaign, and compares them with those that were reported.
  boost::asio::awaitable<void> compare_with_store(Client& client);

  std::uint64_t points = 0;  ///< reported

 private:
  SoakLog& log_;
  std::map<std::string, std::set<std::string>> reported_;  // points, by their campaigns
};

}  // namespace truepose::world
