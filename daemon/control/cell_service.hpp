#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/fwd.hpp>
#include <expected>
#include <string>
#include <vector>

#include "proto/control/request.hpp"

namespace truepose::daemon {

/// What the control server serves: the cell's methods, as openrpc.json describes them.
class CellService {
 public:
  virtual ~CellService() = default;

  /// Every method that call() knows; the server answers "method not found" to others. session.hello,
  /// system.info, events.subscribe, events.unsubscribe and rpc.discover are the server's own.
  virtual std::vector<std::string> methods() const = 0;

  /// Carries out one call, on the io thread. It may take long: other connections are served meanwhile, and
  /// calls of several connections overlap. A client that goes away does not cancel its call; the server's
  /// stop does (it then throws operation_aborted). Any other exception is answered as an internal error.
  virtual boost::asio::awaitable<std::expected<boost::json::value, control::RpcError>> call(
      std::string method, boost::json::object params) = 0;
};

}  // namespace truepose::daemon
