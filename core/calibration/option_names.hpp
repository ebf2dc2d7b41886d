#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "core/calibration/calibrate.hpp"

namespace truepose {

/// A choice and its name on the command line and in documents.
template <typename Value>
struct Named {
  std::string_view name;
  Value value;
};

inline constexpr std::array kMethodNames{
    Named{"two-stage", CalibrationMethod::TwoStage},
    Named{"least-squares", CalibrationMethod::LeastSquares},
    Named{"gauss-newton", CalibrationMethod::GaussNewton},
    Named{"levenberg-marquardt", CalibrationMethod::LevenbergMarquardt},
    Named{"ridge", CalibrationMethod::Ridge},
    Named{"particle-swarm", CalibrationMethod::ParticleSwarm},
};
inline constexpr std::array kLossNames{
    Named{"squared", Loss::Squared},
    Named{"huber", Loss::Huber},
    Named{"igg3", Loss::Igg3},
    Named{"tukey", Loss::Tukey},
};
inline constexpr std::array kPriorNames{
    Named{"auto", PriorUse::Auto},
    Named{"off", PriorUse::Off},
    Named{"on", PriorUse::On},
};

/// The name of a value that the table holds.
template <typename Value, std::size_t N>
constexpr std::string_view name_of(const std::array<Named<Value>, N>& table, Value value) {
  return std::ranges::find(table, value, &Named<Value>::value)->name;
}

/// The value of a name that the table holds.
template <typename Value, std::size_t N>
constexpr Value value_of(const std::array<Named<Value>, N>& table, std::string_view name) {
  return std::ranges::find(table, name, &Named<Value>::name)->value;
}

}  // namespace truepose
