#include "proto/text/digest.hpp"

#include <openssl/sha.h>

#include <array>

namespace truepose::text {

std::string hexadecimal(std::span<const unsigned char> bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

namespace {

std::array<unsigned char, SHA256_DIGEST_LENGTH> digest_of(std::string_view bytes) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), digest.data());
  return digest;
}

}  // namespace

std::string sha256(std::string_view bytes) {
  const auto digest = digest_of(bytes);
  return {digest.begin(), digest.end()};
}

std::string sha256_hex(std::string_view bytes) { return hexadecimal(digest_of(bytes)); }

}  // namespace truepose::text
