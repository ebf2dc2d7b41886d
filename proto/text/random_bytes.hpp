#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

namespace truepose {

/// Fills the bytes with random numbers: the kernel's, or those of a test that replays them. Copies
/// draw from one source.
using RandomBytes = std::function<void(std::span<unsigned char> bytes)>;

/// The kernel's random numbers, fit for secrets. Throws std::runtime_error where it has none.
void kernel_random(std::span<unsigned char> bytes);

/// Random bytes in lower-case hexadecimal digits.
std::string random_hex(std::size_t bytes, const RandomBytes& random);

/// A random UUID in lower-case digits (RFC 9562, version 4).
std::string random_uuid(const RandomBytes& random);

}  // namespace truepose
