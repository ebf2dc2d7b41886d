#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "core/compensate/target_compensation.hpp"
#include "daemon/realtime/deviation_cache.hpp"
#include "daemon/realtime/lock_free.hpp"

namespace truepose::daemon {

/// What the model in effect asks for at the commanded axes, followed from cycle to cycle. One thread changes
/// the model, the realtime thread does all else, without allocation or lock.
class ModelCorrection {
 public:
  /// @param number  of the caller's choice, not 0
  /// @param p_F_mm  whose position comes first next to the wrist singularity, flange frame
  void use(std::uint64_t number, TargetCompensation compensation, const Eigen::Vector3d& p_F_mm);
  void use_none();

  /// @return whether another model is in effect from now on
  bool take_model() noexcept;
  std::uint64_t model() const noexcept { return models_.front().number; }  ///< 0: none
  /// Another session: nothing of the search before is of use.
  void restart() noexcept;
  /// The arm comes from another side now: it deviates in another way than was foreseen.
  void turned_round() noexcept { deviation_cache_.restart(); }

  /// Brings value() up to date. @return false where the calibrated arm has no solution, none near, or none
  /// yet
  bool solve(const JointVector& commanded) noexcept;
  /// Why the last search found nothing; none where it is not over.
  const std::optional<CompensationFault>& no_solution() const noexcept { return no_solution_; }
  /// rad, of the last solution; zero without a model.
  const JointVector& value() const noexcept { return value_; }
  bool damped() const noexcept { return damped_; }  ///< the last solution, next to the wrist singularity
  /// After the reply.
  void look_ahead() noexcept;

 private:
  struct Model {
    std::uint64_t number = 0;
    std::optional<TargetCompensation> compensation;
    Eigen::Vector3d p_F_mm{0, 0, 0};
  };

  SnapshotExchange<Model> models_;
  DeviationCache deviation_cache_;
  JointVector search_ = JointVector::Zero(6);        // where the solver is, of value_
  JointVector searched_for_ = JointVector::Zero(6);  // commanded axes
  JointVector value_ = JointVector::Zero(6);
  std::optional<CompensationFault> no_solution_;
  bool found_ = false, damped_ = false;
};

}  // namespace truepose::daemon
