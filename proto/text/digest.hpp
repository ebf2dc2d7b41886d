#pragma once

#include <span>
#include <string>
#include <string_view>

namespace truepose::text {

/// Bytes in lower-case hexadecimal digits.
std::string hexadecimal(std::span<const unsigned char> bytes);

/// The 32 bytes of SHA-256.
std::string sha256(std::string_view bytes);
/// SHA-256 in hexadecimal digits.
std::string sha256_hex(std::string_view bytes);

}  // namespace truepose::text
