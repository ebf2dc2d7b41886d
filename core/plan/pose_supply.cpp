#include "core/plan/pose_supply.hpp"

#include <algorithm>
#include <utility>

namespace truepose {
namespace {

// Whatever was in the way of one pose may be in the way of others as near as this.
constexpr double kSameTrouble_mm = 150;

bool holds(const std::vector<std::size_t>& numbers, std::size_t k) {
  return std::ranges::find(numbers, k) != numbers.end();
}

}  // namespace

std::expected<PoseSupply, std::string> PoseSupply::make(CalibratedCell cell, const Scene& scene,
                                                        const PlanOptions& options) {
  auto plan = plan_measurements(cell, scene, options);
  if (!plan) return std::unexpected(std::move(plan.error()));
  return PoseSupply{std::move(cell), scene, options, *std::move(plan)};
}

std::expected<PoseSupply, std::string> PoseSupply::again(CalibratedCell cell, const Scene& scene,
                                                         const PlanOptions& options, EarlierPlan earlier) {
  auto plan = plan_again(cell, scene, options, std::move(earlier));
  if (!plan) return std::unexpected(std::move(plan.error()));
  return PoseSupply{std::move(cell), scene, options, *std::move(plan)};
}

PoseSupply::PoseSupply(CalibratedCell cell, const Scene& scene, const PlanOptions& options,
                       MeasurementPlan plan)
    : cell_{std::move(cell)},
      criterion_{options.criterion},
      plan_{std::move(plan)},
      motion_{scene},
      kept_{plan_.chosen} {
  for (const JointVector& q : plan_.validate) validating_.push_back(index_of(q));
}

std::size_t PoseSupply::index_of(const JointVector& q) const {
  return static_cast<std::size_t>(std::ranges::find(plan_.candidates.poses, q) -
                                  plan_.candidates.poses.begin());
}

Eigen::Vector3d PoseSupply::reflector(std::size_t candidate) const {
  return cell_.predict(plan_.candidates.poses[candidate], 0);
}

bool PoseSupply::may_replace(std::size_t candidate) const {
  return !holds(kept_, candidate) && !holds(validating_, candidate) &&
         std::ranges::all_of(failed_, [&](std::size_t other) {
           return (reflector(candidate) - reflector(other)).norm() > kSameTrouble_mm;
         });
}

std::optional<JointVector> PoseSupply::substitute(const JointVector& failed) {
  failed_.push_back(index_of(failed));
  std::erase(kept_, failed_.back());
  std::vector<bool> allowed(plan_.candidates.poses.size());
  for (std::size_t k = 0; k < allowed.size(); ++k) allowed[k] = may_replace(k);
  Design design{*plan_.problem, criterion_};
  for (const std::size_t k : kept_) design.add(k);
  const auto next = best_addition(design, allowed);
  if (!next) return std::nullopt;
  kept_.push_back(*next);
  return plan_.candidates.poses[*next];
}

std::optional<JointVector> PoseSupply::validation_substitute(const JointVector& failed) {
  failed_.push_back(index_of(failed));
  std::erase(validating_, failed_.back());
  std::optional<std::size_t> nearest;
  const auto off_mm = [&](std::size_t k) { return (reflector(k) - reflector(failed_.back())).norm(); };
  for (std::size_t k = 0; k < plan_.candidates.poses.size(); ++k) {
    if (may_replace(k) && (!nearest || off_mm(k) < off_mm(*nearest))) nearest = k;
  }
  if (!nearest) return std::nullopt;
  validating_.push_back(*nearest);
  return plan_.candidates.poses[*nearest];
}

void PoseSupply::replaced(const JointVector& failed, const JointVector& by) {
  const std::size_t lost = index_of(failed), next = index_of(by), candidates = plan_.candidates.poses.size();
  const bool identifies = holds(kept_, lost);
  if (lost < candidates) failed_.push_back(lost);
  std::erase(kept_, lost);
  std::erase(validating_, lost);
  if (next < candidates) (identifies ? kept_ : validating_).push_back(next);
}

std::optional<std::vector<JointVector>> PoseSupply::way(const JointVector& from, const JointVector& to) {
  return motion_.way(from, to, plan_.candidates.poses);
}

}  // namespace truepose
