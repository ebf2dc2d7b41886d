#include "drivers/kuka/udp_source.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstring>

namespace truepose::drivers {

std::string text(const UdpSource& source) {
  const auto byte = [&](int shift) { return std::to_string((source.address >> shift) & 0xff); };
  return byte(24) + '.' + byte(16) + '.' + byte(8) + '.' + byte(0) + ':' + std::to_string(source.port);
}

std::expected<std::uint32_t, std::string> ipv4_of(const std::string& host) {
  const addrinfo wanted{.ai_flags = 0,
                        .ai_family = AF_INET,
                        .ai_socktype = SOCK_DGRAM,
                        .ai_protocol = 0,
                        .ai_addrlen = 0,
                        .ai_addr = nullptr,
                        .ai_canonname = nullptr,
                        .ai_next = nullptr};
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), nullptr, &wanted, &found); error != 0) {
    return std::unexpected(host + " has no IPv4 address: " + ::gai_strerror(error));
  }
  sockaddr_in name;
  std::memcpy(&name, found->ai_addr, sizeof name);
  ::freeaddrinfo(found);
  return ntohl(name.sin_addr.s_addr);
}

}  // namespace truepose::drivers
