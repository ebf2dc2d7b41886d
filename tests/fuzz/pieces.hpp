#pragma once

#include <string_view>
#include <vector>

#include "core/math/random.hpp"

namespace truepose::fuzz {

/// A stream cut at random places, as a network may deliver it; the same stream is always cut at the same
/// ones.
inline std::vector<std::string_view> pieces_of(std::string_view stream) {
  std::uint64_t seed = stream.size();
  for (const char c : stream) seed = 31 * seed + static_cast<unsigned char>(c);
  Random random{seed};
  const std::uint64_t longest = 1 + random.next() % 64;
  std::vector<std::string_view> pieces;
  while (!stream.empty()) {
    const std::string_view piece = stream.substr(0, 1 + random.next() % longest);
    pieces.push_back(piece);
    stream.remove_prefix(piece.size());
  }
  return pieces;
}

/// The same cut between any two bytes.
inline std::vector<std::string_view> bytes_of(std::string_view stream) {
  std::vector<std::string_view> bytes;
  for (std::size_t i = 0; i < stream.size(); ++i) bytes.push_back(stream.substr(i, 1));
  return bytes;
}

}  // namespace truepose::fuzz
