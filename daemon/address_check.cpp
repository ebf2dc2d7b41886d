#include "daemon/address_check.hpp"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/udp.hpp>
#include <iterator>
#include <optional>

#include "daemon/control/control_address.hpp"

namespace truepose::daemon {

namespace {

namespace ip = boost::asio::ip;
using Level = Finding::Level;

std::string text_of(const config::Endpoint& endpoint) {
  const bool is_v6 = endpoint.host.find(':') != std::string::npos;
  return (is_v6 ? "[" + endpoint.host + "]" : endpoint.host) + ":" + std::to_string(endpoint.port);
}

std::optional<ip::address_v4> ipv4(const std::string& text) {
  boost::system::error_code error;
  const ip::address_v4 address = ip::make_address_v4(text, error);
  return error ? std::nullopt : std::optional{address};
}

/// Whether a socket can have the address: all of 127.0.0.0/8 counts, which no list of network cards shows.
bool is_of_this_machine(const ip::address_v4& address) {
  boost::asio::io_context context;
  ip::udp::socket socket{context, ip::udp::v4()};
  boost::system::error_code error;
  socket.bind({address, 0}, error);
  return !error;
}

}  // namespace

std::vector<Finding> check_stream_address(const config::StreamConfig& stream,
                                          const rsi::EthernetConfig& ethernet) {
  const std::string file = stream.ethernet_xml.string();
  const auto target = ipv4(ethernet.address);
  if (!target || target->is_unspecified()) {
    return {{Level::Failure, file + ": CONFIG/IP_NUMBER is \"" + ethernet.address +
                                 "\", expected the IPv4 address of this PC in the RSI network"}};
  }
  const auto listen = ipv4(stream.listen.host);
  if (!listen) {
    return {{Level::Failure, "stream.listen: \"" + stream.listen.host +
                                 "\" is not an IPv4 address: give that of this PC in the RSI network"}};
  }
  std::vector<Finding> findings;
  const auto warn = [&findings](std::string text) { findings.push_back({Level::Warning, std::move(text)}); };
  const std::string goes_to = "the controller sends to " + ethernet.address + ":" +
                              std::to_string(ethernet.port) + " (IP_NUMBER and PORT of " + file + ")";
  const bool same_port = stream.listen.port == 0 || stream.listen.port == ethernet.port;
  const bool same_address = listen->is_unspecified() || *listen == *target;
  if (!same_port || !same_address)
    warn(goes_to + ", but stream.listen is " + text_of(stream.listen) + ": make them the same");
  if (!is_of_this_machine(*listen)) {
    warn("stream.listen: this machine does not have the address " + stream.listen.host +
         " now: the daemon cannot start before its network card has it");
  }
  if (listen->is_unspecified() && !is_of_this_machine(*target))
    warn(goes_to + ", but this machine does not have that address now");
  return findings;
}

std::vector<Finding> check_control_address(const config::ControlConfig& control) {
  const auto address = control_address(control.listen);
  if (address) return {};
  return {{Level::Failure, address.error()}};
}

std::vector<Finding> check_ports(const config::CellConfig& config) {
  struct Named {
    const char* key;
    config::Endpoint endpoint;
  };
  // RSI is UDP: its port is another one, whatever its number.
  std::vector<Named> all{{"robot.eki_motion", config.robot.eki_motion},
                         {"robot.eki_state", config.robot.eki_state},
                         {"tracker.address", config.tracker.address},
                         {"control.listen", config.control.listen}};
  for (Named& named : all) {
    if (named.endpoint.host == "localhost") named.endpoint.host = "127.0.0.1";
  }
  std::vector<Finding> findings;
  for (auto one = all.begin(); one != all.end(); ++one) {
    for (auto other = std::next(one); other != all.end(); ++other) {
      if (one->endpoint.port == 0 || text_of(one->endpoint) != text_of(other->endpoint)) continue;
      findings.push_back({Level::Failure, std::string{one->key} + " and " + other->key + " are both " +
                                              text_of(one->endpoint) + ": each needs a port of its own"});
    }
  }
  return findings;
}

}  // namespace truepose::daemon
