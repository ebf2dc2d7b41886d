#include "proto/text/random_bytes.hpp"

#include <sys/random.h>

#include <array>
#include <stdexcept>
#include <vector>

#include "proto/text/digest.hpp"

namespace truepose {

void kernel_random(std::span<unsigned char> bytes) {
  if (::getrandom(bytes.data(), bytes.size(), 0) != std::ssize(bytes))
    throw std::runtime_error{"the kernel has no random numbers"};
}

std::string random_hex(std::size_t bytes, const RandomBytes& random) {
  std::vector<unsigned char> drawn(bytes);
  random(drawn);
  return text::hexadecimal(drawn);
}

std::string random_uuid(const RandomBytes& random) {
  std::array<unsigned char, 16> drawn{};
  random(drawn);
  drawn[6] = static_cast<unsigned char>((drawn[6] & 0x0f) | 0x40);  // version 4
  drawn[8] = static_cast<unsigned char>((drawn[8] & 0x3f) | 0x80);  // the variant of the RFC
  std::string uuid = text::hexadecimal(drawn);
  for (const std::size_t hyphen : {8U, 13U, 18U, 23U}) uuid.insert(hyphen, 1, '-');
  return uuid;
}

}  // namespace truepose
