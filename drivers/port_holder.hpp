#pragma once

#include <cstdint>
#include <string>

namespace truepose::drivers {

enum class Protocol { Tcp, Udp };

/// Who has a local port, for the sentence "port 49152 is in use by ...": "trueposed (process 1234)", "another
/// user's process (uid 107)" where we may not look closer, "a process of uid 0 that is just ending, or runs
/// in another container" where we may and find none, or "an unknown process" where the port is free by now.
std::string port_holder(Protocol protocol, std::uint16_t port);

/// Whether a program has it, at any address.
bool is_held(Protocol protocol, std::uint16_t port);

}  // namespace truepose::drivers
