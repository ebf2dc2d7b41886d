#include "proto/rsi/gain_word.hpp"

namespace truepose::rsi {
namespace {

constexpr std::int64_t kFull = 100, kRoom = 1000;
constexpr std::uint64_t kCounts = 1'000'000;  // a KRL INT has 32 bits

}  // namespace

std::int64_t gain_word(std::int64_t gain, std::uint64_t ipoc) {
  const auto count = static_cast<std::int64_t>(ipoc % kCounts) + 1;
  return -(kRoom * count + kFull - gain);
}

std::optional<std::int64_t> gain_of(std::int64_t word) {
  if (word > -kRoom) return std::nullopt;
  return kFull - -word % kRoom;
}

}  // namespace truepose::rsi
