#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>

namespace truepose::config {

struct Endpoint {
  std::string host;
  std::uint16_t port = 0;
};

/// Reads HOST:PORT, an IPv6 address in brackets.
/// @param least_port  1 for a peer; 0 for a socket of ours, which may take any free one
/// @return what was expected and found, where it is not that
std::expected<Endpoint, std::string> parse_endpoint(std::string_view text, std::uint16_t least_port = 1);

}  // namespace truepose::config
