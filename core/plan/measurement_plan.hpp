#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/data/measurement.hpp"
#include "core/plan/candidates.hpp"
#include "core/plan/optimal_design.hpp"
#include "core/plan/tour.hpp"

namespace truepose {

struct PlanOptions {
  int poses = 50;
  int first = 0;     ///< of them to measure first: those that together tell most
  int validate = 0;  ///< further ones, drawn at random
  int candidates = 2000;
  std::uint64_t seed = 0;
  DesignCriterion criterion = DesignCriterion::I;
  /// In place of what tells most of the parameters, poses in which the flange is turned as differently as can
  /// be, for what is measured with a calibrated arm. The reflector may then be on the last axis.
  bool by_orientation = false;
  Box task;  ///< where predictions matter (of the reflector); the whole reach of the arm unless narrowed
  MeasurementNoise noise;
  JointVector start;        ///< where the arm is before the first pose
  int reference_every = 0;  ///< poses from one visit to the reference pose to the next; 0: none
  int random_sets = 20;     ///< of poses and of orders, to compare with; 0: no comparison
  std::vector<int> sizes{10, 15, 20, 30, 40, 60, 80, 100};  ///< of designs to say how many poses are enough
  PlanProgress progress = {};
};

/// Poses to measure, and what they are good for.
struct MeasurementPlan {
  std::vector<JointVector> poses;     ///< in the order in which to measure them
  std::vector<std::size_t> chosen;    ///< the same as indices of the candidates
  std::vector<JointVector> validate;  ///< likewise in order
  Candidates candidates;
  std::shared_ptr<const DesignProblem> problem;  ///< of the candidates
  std::optional<JointVector> reference;  ///< to be measured before the first, every so many poses, and last
  PredictedError predicted;              ///< of the task's positions
  PredictedError random;                 ///< the same of random candidates, as many: the mean of several sets
  std::vector<DesignSize> sizes;
  std::optional<int> enough;  ///< poses beyond which more hardly help
  double travel_s = 0;        ///< of all motions; where the straight one is not clear, about that of a detour
  double random_travel_s = 0;  ///< in a random order: the mean of several
};

/// Chooses and orders the poses of a calibration. Positions of the first reflector of `cell`, whose arm is
/// the scene's.
///
/// @param cell  roughly known: the nominal arm, base and reflector
/// @return a plan, or one sentence: what in the scene leaves too few poses
std::expected<MeasurementPlan, std::string> plan_measurements(const CalibratedCell& cell, const Scene& scene,
                                                              const PlanOptions& options);

/// Poses that were planned before, in the order in which to measure them.
struct EarlierPlan {
  std::vector<JointVector> poses, validate;
  std::optional<JointVector> reference;
};

/// The same about poses that were chosen before: neither chooses nor orders, and compares with nothing. Where
/// they are no candidates of the scene they become such.
std::expected<MeasurementPlan, std::string> plan_again(const CalibratedCell& cell, const Scene& scene,
                                                       const PlanOptions& options, EarlierPlan earlier);

/// Poses over the task at which predictions matter, whether the tracker sees them or not.
std::expected<std::vector<JointVector>, std::string> draw_task(const Scene& scene, const Box& task,
                                                               std::uint64_t seed);

}  // namespace truepose
