#pragma once

#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "core/plan/measurement_plan.hpp"
#include "core/plan/motion.hpp"

namespace truepose {

/// The poses of one campaign: those planned, what replaces one that cannot be measured, and how to come from
/// one to the next. Not for several threads at once.
class PoseSupply {
 public:
  /// @return or one sentence: what in the scene leaves too few poses
  static std::expected<PoseSupply, std::string> make(CalibratedCell cell, const Scene& scene,
                                                     const PlanOptions& options);

  /// The same of poses that were planned before.
  static std::expected<PoseSupply, std::string> again(CalibratedCell cell, const Scene& scene,
                                                      const PlanOptions& options, EarlierPlan earlier);

  const MeasurementPlan& plan() const { return plan_; }

  /// Gives up a pose to identify and says what to measure in its place; none where nothing is left.
  std::optional<JointVector> substitute(const JointVector& failed);
  /// The same for a pose to validate: a candidate near the one that failed.
  std::optional<JointVector> validation_substitute(const JointVector& failed);

  /// Takes note of a substitute that was found before, of a pose to identify or to validate.
  void replaced(const JointVector& failed, const JointVector& by);

  /// Stopovers of a clear way, none where the straight motion is clear; nothing where none was found.
  std::optional<std::vector<JointVector>> way(const JointVector& from, const JointVector& to);

 private:
  PoseSupply(CalibratedCell cell, const Scene& scene, const PlanOptions& options, MeasurementPlan plan);
  /// Of a candidate; their number where it is none.
  std::size_t index_of(const JointVector& q) const;
  /// Whether a candidate is free and its reflector far from all that failed.
  bool may_replace(std::size_t candidate) const;
  Eigen::Vector3d reflector(std::size_t candidate) const;

  CalibratedCell cell_;
  DesignCriterion criterion_;
  MeasurementPlan plan_;
  MotionChecker motion_;
  std::vector<std::size_t> kept_;  ///< to identify
  std::vector<std::size_t> validating_;
  std::vector<std::size_t> failed_;
};

}  // namespace truepose
