#pragma once

#include <boost/json/fwd.hpp>

#include "tools/proxy/command.hpp"
#include "tools/proxy/faulty_way.hpp"

namespace truepose::proxy {

/// From one address that the proxy listens on to one target.
class Route {
 public:
  virtual ~Route() = default;               ///< closes its sockets
  virtual std::string listens() const = 0;  ///< "127.0.0.1:49152"
  virtual void apply(const Command& command) = 0;
  virtual boost::json::object statistics() const = 0;
};

/// Both directions of a route.
struct Ways {
  explicit Ways(Random& seeds) : to_target{seeds.next()}, to_client{seeds.next()} {}

  FaultyWay to_target, to_client;

  void apply(const Command& command);
  void tell(boost::json::object& statistics) const;
};

}  // namespace truepose::proxy
