#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <string>
#include <vector>

#include "core/plan/scene.hpp"

namespace truepose {

struct CandidateOptions {
  int poses = 2000;
  std::uint64_t seed = 0;
  Visibility visibility = Visibility::Required;
  double distinct_rad = 0.05;  ///< two poses differ at least so much in one joint (prismatic: as many metres)
  int tries = 4'000'000;       ///< before giving up, which comes sooner where even so many would not do
};

struct Candidates {
  std::vector<JointVector> poses;  ///< in the order in which they were drawn
  int tried = 0;                   ///< joint vectors, uniform between the limits
  std::vector<int> seen;           ///< the first reflector that is seen at each; empty: the first of all
  std::array<int, kPoseFaults> faults{};  ///< how many of them failed, by PoseFault
};

/// Random poses of a scene that can be driven to and measured, and that are distinct. The same options give
/// the same poses on every machine.
///
/// @param least  so many must be found
/// @return at most as many as asked for; or one sentence: how many were found, and what most of the others
/// failed on
std::expected<Candidates, std::string> draw_candidates(const Scene& scene, const CandidateOptions& options,
                                                       int least);

}  // namespace truepose
