#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <string>

#include "core/math/random.hpp"
#include "tests/world/client.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// A client that reads what the daemon keeps: a campaign with its points, report and file, models,
/// recordings. Judges that what comes in parts fits together, and that what is listed can be read.
class Reading {
 public:
  Reading(Client& client, SoakLog& log, Random& random) : client_{client}, log_{log}, random_{random} {}

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

  Client& client_;
  SoakLog& log_;
  Random& random_;
};

}  // namespace truepose::world
