#pragma once

#include <chrono>

#include "config/scenario.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::sim {

inline constexpr Seconds kRsiCycle = std::chrono::milliseconds{4};
inline const JointVector kNoCorrection = JointVector::Zero(6);

inline config::Scenario demo_cell() {
  return config::load_scenario(TRUEPOSE_SOURCE_DIR "/config/scenarios/demo.yaml");
}

}  // namespace truepose::sim
