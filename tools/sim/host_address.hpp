#pragma once

#include <expected>
#include <string>

namespace truepose::sim {

/// @return a numeric IPv4 address of the host, or why there is none
std::expected<std::string, std::string> address_of(const std::string& host);

}  // namespace truepose::sim
