#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace truepose::control {

/// Bytes in a JSON text (RFC 4648, with padding).
std::string base64(std::string_view bytes);
/// And back; nothing where the text is none.
std::optional<std::string> from_base64(std::string_view text);

}  // namespace truepose::control
