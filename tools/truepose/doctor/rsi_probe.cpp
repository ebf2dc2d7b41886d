#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <future>
#include <memory>
#include <sstream>

#include "drivers/kuka/rsi_port.hpp"
#include "drivers/port_holder.hpp"
#include "tools/truepose/doctor/network.hpp"
#include "tools/truepose/doctor/probes.hpp"

namespace truepose::tools {

namespace {

using drivers::TimePoint;

/// What passes the network cards, before any firewall. Needs CAP_NET_RAW.
class WireTap {
 public:
  WireTap() : socket_{::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IP))} {
    const timeval patience{.tv_sec = 0, .tv_usec = 30'000};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~WireTap() {
    if (open()) ::close(socket_);
  }
  WireTap(const WireTap&) = delete;
  WireTap& operator=(const WireTap&) = delete;
  bool open() const { return socket_ >= 0; }

  /// The next UDP packet that comes in; valid until the next call.
  std::optional<UdpPacket> next() {
    sockaddr_ll card{};
    socklen_t size = sizeof card;
    const ssize_t received =
        ::recvfrom(socket_, buffer_.data(), buffer_.size(), 0, reinterpret_cast<sockaddr*>(&card), &size);
    if (received <= 0 || card.sll_pkttype == PACKET_OUTGOING) return std::nullopt;
    return read_udp({buffer_.data(), static_cast<std::size_t>(received)});
  }

 private:
  int socket_;
  std::array<std::byte, 64 * 1024> buffer_{};
};

void count(std::vector<SeenStream>& streams, const UdpPacket& packet) {
  const auto known = std::ranges::find_if(streams, [&](const SeenStream& stream) {
    return stream.source == packet.source && stream.target == packet.target;
  });
  if (known == streams.end()) {
    streams.push_back({packet.source, packet.target, 1});
  } else {
    ++known->datagrams;
  }
}

/// What is seen of RSI on all cards.
struct Tapped {
  std::vector<SeenStream> streams;
  RsiWatch watch;  ///< of what goes to our port
};

/// The RSI streams of a while: those for ports of other programs are these programs' own.
std::optional<Tapped> tap(std::uint16_t our_port, TimePoint until) {
  const auto wire = std::make_unique<WireTap>();
  if (!wire->open()) return std::nullopt;
  Tapped tapped;
  for (TimePoint now; (now = std::chrono::steady_clock::now()) < until;) {
    const auto packet = wire->next();
    if (!packet || !packet->payload.starts_with("<Rob")) continue;
    count(tapped.streams, *packet);
    if (packet->target.port == our_port)
      tapped.watch.take({.bytes = packet->payload, .source = packet->source, .received = now}, false);
  }
  std::erase_if(tapped.streams, [&](const SeenStream& stream) {
    const std::uint16_t port = stream.target.port;
    return port != our_port && drivers::is_held(drivers::Protocol::Udp, port);
  });
  return tapped;
}

/// The kernel's count of datagrams that came to ports that no program has (proc(5), /proc/net/snmp).
std::uint64_t unclaimed_datagrams() {
  std::ifstream file{"/proc/net/snmp"};
  std::string names, values, name, value;
  while (std::getline(file, names) && std::getline(file, values)) {
    if (!names.starts_with("Udp:")) continue;
    std::istringstream each_name{names}, each_value{values};
    while (each_name >> name && each_value >> value) {
      if (name == "NoPorts") return std::stoull(value);
    }
  }
  return 0;
}

std::string output_of(const char* command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe{::popen(command, "r"), ::pclose};
  std::string text;
  std::array<char, 4096> part;
  while (pipe && std::fgets(part.data(), part.size(), pipe.get())) text += part.data();
  return text;
}

std::optional<std::string> firewall_rules() {
  if (::geteuid() != 0) return std::nullopt;
  return output_of(
      "PATH=$PATH:/usr/sbin:/sbin; nft list ruleset 2>/dev/null || iptables -S INPUT 2>/dev/null");
}

void listen(RsiObservation& seen, const config::StreamConfig& stream, TimePoint until) {
  auto port = drivers::RsiPort::bind(stream.listen.host, stream.listen.port, std::nullopt);
  if (!port) {
    seen.not_bound = port.error().text;
    seen.taken = drivers::is_held(drivers::Protocol::Udp, stream.listen.port);
    return;
  }
  RsiWatch watch;
  while (std::chrono::steady_clock::now() < until) {
    if (const auto received = port->receive()) watch.take(received->datagram, received->cut);
  }
  seen.senders = watch.senders();
}

}  // namespace

RsiObservation observe_rsi(const config::StreamConfig& stream, bool daemon_has_port) {
  RsiObservation seen;
  const TimePoint until = std::chrono::steady_clock::now() + kListenTime;
  const std::uint64_t before = unclaimed_datagrams();
  auto wire = std::async(std::launch::async, [&] { return tap(stream.listen.port, until); });
  if (!daemon_has_port) listen(seen, stream, until);
  if (auto tapped = wire.get()) {
    seen.seen = std::move(tapped->streams);
    if (daemon_has_port) seen.senders = tapped->watch.senders();
  }
  seen.unclaimed = unclaimed_datagrams() - before;
  seen.firewall = firewall_rules();
  return seen;
}

}  // namespace truepose::tools
