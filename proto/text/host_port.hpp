#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace truepose::text {

/// HOST:PORT, an IPv6 address in brackets, as parsers of such a text expect it.
std::string host_port(std::string_view host, std::uint16_t port);

}  // namespace truepose::text
