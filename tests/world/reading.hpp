#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <string>

#include "core/math/random.hpp"
#include "tests/world/cell.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// A client that reads what the daemon keeps: a campaign with its points, report and file, models,
/// recordings. Judges that what comes in parts fits together, and that what is listed can be read.
class Reading {
 public:
  Reading(Cell& cell, SoakLog& log, Random& random) : cell_{cell}, log_{log}, random_{random} {}

  boost::asio::awaitable<void> read_all();

 private:
  using Wait = boost::asio::awaitable<void>;

  Wait read_campaign(std::string id);
  Wait read_models();
  Wait read_recordings();
  /// Of a file or a page, until its end.
  Wait read_parts(std::string method, boost::json::object which, std::string part);
  Wait read(std::string method, boost::json::object params = {});
  void refused(const std::string& method, const boost::json::value& answer);

  Cell& cell_;
  Client& client_ = cell_.panel;
  SoakLog& log_;
  Random& random_;
};

}  // namespace truepose::world
