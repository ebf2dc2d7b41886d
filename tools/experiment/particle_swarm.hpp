#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

struct ParticleSwarmOptions {
  int particles = 80;
  int iterations = 400;
  double reflector_mm = 500;  ///< greatest coordinate of a reflector on the flange
  std::uint64_t seed = 0;
};

/// Base and reflectors with the least squared error that a swarm finds from anywhere, the arm held at `arm`:
/// the global start of the literature, for comparison with placement(), which needs no search. Source:
/// Clerc and Kennedy, The particle swarm, 2002 (constriction factor).
CalibratedCell particle_swarm_start(const RobotModel& arm, std::span<const std::string> smr_names,
                                    std::span<const Measurement> points,
                                    const ParticleSwarmOptions& options = {});

}  // namespace truepose
