#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <string>

#include "tests/world/client.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// What a client orders, in the log, and judged: a refusal has a reason.
class Orders {
 public:
  Orders(Client& client, SoakLog& log) : client_{client}, log_{log} {}

  /// @return the answer; null where the session ended before
  boost::asio::awaitable<boost::json::value> give(std::string method, boost::json::object params = {});
  /// Whether the last one has no answer: it may have been carried out.
  bool is_last_lost() const { return is_last_lost_; }

 private:
  Client& client_;
  SoakLog& log_;
  bool is_last_lost_ = false;
};

}  // namespace truepose::world
