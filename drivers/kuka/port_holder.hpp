#pragma once

#include <cstdint>
#include <string>

namespace truepose::drivers {

/// " by trueposed (pid 812)": who has the UDP port, as far as this user may see it; empty otherwise.
std::string udp_port_holder(std::uint16_t port);

}  // namespace truepose::drivers
