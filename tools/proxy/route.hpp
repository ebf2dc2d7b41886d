#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/proxy/command.hpp"
#include "tools/proxy/faulty_way.hpp"

namespace truepose::proxy {

struct RouteStatistics {
  std::string protocol, listen, target;
  std::optional<std::uint64_t> clients{};                     ///< of UDP
  std::optional<std::uint64_t> connections{}, open{}, cut{};  ///< of TCP
  Counters to_target, to_client;
};
struct Statistics {
  std::uint64_t seed = 0;
  std::vector<RouteStatistics> routes;
};
void layout(record::Io& io, Statistics& x);

/// From one address that the proxy listens on to one target.
class Route {
 public:
  virtual ~Route() = default;               ///< closes its sockets
  virtual std::string listens() const = 0;  ///< "127.0.0.1:49152"
  virtual void apply(const Command& command) = 0;
  virtual RouteStatistics statistics() const = 0;
};

/// Both directions of a route.
struct Ways {
  explicit Ways(Random& seeds) : to_target{seeds.next()}, to_client{seeds.next()} {}

  FaultyWay to_target, to_client;

  void apply(const Command& command);
};

}  // namespace truepose::proxy
