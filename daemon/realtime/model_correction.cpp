#include "daemon/realtime/model_correction.hpp"

#include <utility>

namespace truepose::daemon {
namespace {

// Of the solver in a cycle. Going on from the cycle before it needs two or three.
constexpr int kSolverSteps = 8;

}  // namespace

void ModelCorrection::use(std::uint64_t number, TargetCompensation compensation,
                          const Eigen::Vector3d& p_F_mm) {
  models_.back() = Model{.number = number, .compensation = std::move(compensation), .p_F_mm = p_F_mm};
  models_.publish();
}

void ModelCorrection::use_none() {
  models_.back() = Model{};
  models_.publish();
}

bool ModelCorrection::take_model() noexcept {
  if (!models_.take()) return false;
  restart();
  return true;
}

void ModelCorrection::restart() noexcept {
  search_.setZero();
  deviation_cache_.restart();
}

bool ModelCorrection::solve(const JointVector& commanded) noexcept {
  const Model& model = models_.front();
  damped_ = false;
  if (model.number == 0) {
    value_.setZero();
    return true;
  }
  // A search that is not over continues only for the arm that stands: elsewhere it could lead to another
  // branch.
  if (!found_ && commanded != searched_for_) search_.setZero();
  searched_for_ = commanded;
  const auto compensated =
      deviation_cache_.at_joints_within(kSolverSteps, *model.compensation, commanded, model.p_F_mm, search_);
  found_ = compensated && compensated->q.allFinite();
  no_solution_.reset();
  if (!compensated) no_solution_ = compensated.error();
  if (!found_) return false;
  value_ = compensated->q - commanded;
  damped_ = compensated->damped;
  return true;
}

void ModelCorrection::look_ahead() noexcept {
  if (model() != 0) deviation_cache_.look_ahead(*models_.front().compensation);
}

}  // namespace truepose::daemon
