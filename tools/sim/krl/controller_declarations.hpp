#pragma once

#include <string_view>

namespace truepose::sim {

/// KRL: what a KR C4 has next to the language itself: system variables, messages, Ethernet KRL and RSI.
std::string_view controller_declarations();

}  // namespace truepose::sim
