#pragma once

#include <cstdlib>
#include <string_view>

#include "tests/sanitized.hpp"

namespace truepose {

/// Whether a statistic is made of all its trials: TRUEPOSE_TRIALS=all, as `tools/test all` sets it. Else of a
/// tenth.
inline bool all_trials() {
  const char* const asked = std::getenv("TRUEPOSE_TRIALS");
  return asked && std::string_view{asked} == "all";
}

inline int trials(int all) { return all_trials() ? all : all / 10; }

/// Every how many-th random input a test takes: a sanitizer needs ten times as long for each.
inline int share() { return TRUEPOSE_SANITIZED && !all_trials() ? 10 : 1; }

/// What a rate must reach that reaches `of_all` over all trials: a tenth of them spread three times as wide.
inline double least_rate(double of_all) { return all_trials() ? of_all : 1 - 3 * (1 - of_all); }

/// The bound of a mean that keeps to `of_all` over all trials.
inline double widened(double of_all, double by) { return all_trials() ? of_all : of_all + by; }

}  // namespace truepose
