#include "tools/proxy/proxy.hpp"

#include <algorithm>
#include <boost/asio/ip/udp.hpp>
#include <boost/system/system_error.hpp>

#include "proto/record/io.hpp"
#include "tools/proxy/tcp_route.hpp"
#include "tools/proxy/udp_route.hpp"

namespace truepose::proxy {

namespace asio = boost::asio;
using asio::ip::udp;

namespace {

/// IPv4, as controllers speak it, but for an IPv6 address in digits. Throws boost::system::system_error for a
/// host that has no address.
udp::endpoint resolve(const asio::any_io_executor& executor, const config::Endpoint& endpoint) {
  udp::resolver resolver{executor};
  const auto family = endpoint.host.contains(':') ? udp::v6() : udp::v4();
  return resolver.resolve(family, endpoint.host, std::to_string(endpoint.port)).begin()->endpoint();
}

}  // namespace

void layout(record::Io& io, Counters& x) {
  io("received", x.received);
  io("bytes", x.bytes);
  io("forwarded", x.forwarded);
  io("lost", x.lost);
  io("duplicated", x.duplicated);
  io("reordered", x.reordered);
  io("truncated", x.truncated);
  io("corrupted", x.corrupted);
}
void layout(record::Io& io, RouteStatistics& x) {
  io("protocol", x.protocol);
  io("listen", x.listen);
  io("target", x.target);
  io.optional("clients", x.clients);
  io.optional("connections", x.connections);
  io.optional("open", x.open);
  io.optional("cut", x.cut);
  io("to_target", x.to_target);
  io("to_client", x.to_client);
}
void layout(record::Io& io, Statistics& x) {
  io("seed", x.seed);
  io("routes", x.routes);
}
void layout(record::Io& io, Reply& x) {
  io.optional("error", x.error);
  io.where(x.error.empty(), "ok", true);
  io.optional("routes", x.routes);
}

void Ways::apply(const Command& command) {
  if (command.direction != Direction::ToClient) command.apply(to_target.faults);
  if (command.direction != Direction::ToTarget) command.apply(to_client.faults);
}

std::expected<RouteOptions, std::string> parse_route(Protocol protocol, std::string_view text) {
  const std::size_t middle = text.find('=');
  if (middle == std::string_view::npos)
    return std::unexpected("expected LISTEN=TARGET, both HOST:PORT, found " + config::in_quotes(text));
  const auto listen = config::parse_endpoint(text.substr(0, middle), 0);
  if (!listen) return std::unexpected(listen.error());
  const auto target = config::parse_endpoint(text.substr(middle + 1));
  if (!target) return std::unexpected(target.error());
  return RouteOptions{protocol, *listen, *target};
}

Proxy::Proxy(asio::any_io_executor executor, std::uint64_t seed)
    : executor_{std::move(executor)}, seed_{seed}, seeds_{seed}, timer_{executor_} {}

std::expected<std::string, std::string> Proxy::add(const RouteOptions& options) try {
  const udp::endpoint listen = resolve(executor_, options.listen),
                      target = resolve(executor_, options.target);
  const auto end = [](const udp::endpoint& of) {
    return net::Stream::End{of.address().to_string(), of.port()};
  };
  routes_.push_back(options.protocol == Protocol::Udp
                        ? udp_route(executor_, listen, target, seeds_)
                        : tcp_route(executor_, end(listen), end(target), seeds_));
  return routes_.back()->listens();
} catch (const boost::system::system_error& e) {
  return std::unexpected("route from " + config::text(options.listen) + " to " + options.target.host + ": " +
                         e.code().message());
}

Reply Proxy::obey(const Command& command) {
  bool found = false;
  for (const auto& route : routes_) {
    if (!command.route.empty() && command.route != route->listens()) continue;
    route->apply(command);
    found = true;
  }
  if (!found) return {.error = "no route listens on " + command.route};
  Reply reply;
  if (command.statistics) reply.routes = statistics().routes;
  return reply;
}

void Proxy::follow(const std::vector<Command>& timeline) {
  timeline_.assign(timeline.begin(), timeline.end());
  begun_ = asio::steady_timer::clock_type::now();
  await_next();
}

void Proxy::await_next() {
  if (timeline_.empty()) return;
  timer_.expires_at(begun_ + *timeline_.front().at);
  timer_.async_wait([this](boost::system::error_code cancelled) {
    if (cancelled) return;
    obey(timeline_.front());
    timeline_.pop_front();
    await_next();
  });
}

Statistics Proxy::statistics() const {
  Statistics statistics{seed_, {}};
  for (const auto& route : routes_) statistics.routes.push_back(route->statistics());
  return statistics;
}

}  // namespace truepose::proxy
