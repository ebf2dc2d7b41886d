#pragma once

#include <cstdint>

namespace truepose {

/// A small generator that gives the same numbers on every machine and in every language.
/// Source: Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators (2014), as SplitMix64.
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EB;
    return z ^ (z >> 31U);
  }

  /// Uniform over [low, high), from the upper 53 bits.
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(next() >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

}  // namespace truepose
