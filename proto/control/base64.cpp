#include "proto/control/base64.hpp"

#include <openssl/evp.h>

#include <algorithm>

namespace truepose::control {
namespace {

const unsigned char* unsigned_of(std::string_view bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}
unsigned char* unsigned_of(std::string& bytes) { return reinterpret_cast<unsigned char*>(bytes.data()); }

}  // namespace

std::string base64(std::string_view bytes) {
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');  // with the end that OpenSSL writes
  text.resize(static_cast<std::size_t>(
      EVP_EncodeBlock(unsigned_of(text), unsigned_of(bytes), static_cast<int>(bytes.size()))));
  return text;
}

std::optional<std::string> from_base64(std::string_view text) {
  std::string bytes(text.size() / 4 * 3, '\0');
  const int size = EVP_DecodeBlock(unsigned_of(bytes), unsigned_of(text), static_cast<int>(text.size()));
  if (size < 0) return std::nullopt;
  const auto padding = std::min<std::ptrdiff_t>(std::ranges::count(text, '='), 2);
  bytes.resize(static_cast<std::size_t>(size - padding));
  return bytes;
}

}  // namespace truepose::control
