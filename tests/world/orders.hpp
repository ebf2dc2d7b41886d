#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <optional>
#include <string>

#include "tests/world/client.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// What a client orders, each with an id, in the log, and judged: a refusal has a reason.
class Orders {
 public:
  Orders(Client& client, SoakLog& log) : client_{client}, log_{log} {}

  /// @return the answer; null where the session ended before
  boost::asio::awaitable<boost::json::value> give(std::string method, boost::json::object params = {});
  /// Whether the last one has no answer: it may have been carried out.
  bool is_last_lost() const { return lost_.has_value(); }
  void forget_lost() { lost_.reset(); }
  /// Gives that one again, with its id: it is carried out once.
  boost::asio::awaitable<void> repeat_lost();

 private:
  boost::asio::awaitable<boost::json::value> send(std::string method, boost::json::object params);

  Client& client_;
  SoakLog& log_;
  int given_ = 0;
  std::optional<Request> lost_;
};

}  // namespace truepose::world
