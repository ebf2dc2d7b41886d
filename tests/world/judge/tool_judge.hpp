#pragma once

#include <boost/asio/awaitable.hpp>
#include <map>
#include <optional>
#include <string>

#include "tests/world/client.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges which measured tools are in use: those that were activated, across every restart.
class ToolJudge {
 public:
  explicit ToolJudge(SoakLog& log) : log_{log} {}

  /// An order about tools was answered, or its session ended before.
  void answered(const Request& request);
  /// The store was replaced by a backup.
  void restored() { campaigns_.reset(); }
  boost::asio::awaitable<void> look(Client& client);

 private:
  SoakLog& log_;
  // The campaign of each tool in use, by its number. None: not known.
  std::optional<std::map<int, std::string>> campaigns_{std::in_place};
};

}  // namespace truepose::world
