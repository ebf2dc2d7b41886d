#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <set>
#include <string>

#include "tests/world/cell.hpp"
#include "tests/world/client.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges models: at most one is active, none that was edited, and one that its campaign activated is about
/// as good as it was found to be, everywhere.
class ModelJudge {
 public:
  ModelJudge(const Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {}

  /// An event of the topic model.
  void take(const boost::json::object& change);
  boost::asio::awaitable<void> look(Client& client);

  double largest_error_mm = 0, largest_ratio = 0;  ///< to what the model says of itself

 private:
  boost::asio::awaitable<void> compare_with_truth(Client& client);

  const Cell& cell_;
  SoakLog& log_;
  std::set<std::string> trusted_;  // models that their campaigns activated
};

}  // namespace truepose::world
