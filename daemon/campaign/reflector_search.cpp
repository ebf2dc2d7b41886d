#include "daemon/campaign/reflector_search.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "config/cell_setup.hpp"

namespace truepose::daemon {
namespace {

// So far from one reflector no other is taken for it.
constexpr double kOfSpacing = 0.3;

DeviceError cannot_tell() {
  return {Remedy::Retry,
          "tracker: which of the reflectors it found is not known, as not all are there that should "
          "be seen here: take those that are not there out of the cell file, or correct tracker.robot_base"};
}

/// The least distance between any two.
double spacing_mm(const std::vector<Eigen::Vector3d>& places_mm) {
  double least_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < places_mm.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) least_mm = std::min(least_mm, (places_mm[i] - places_mm[k]).norm());
  return least_mm;
}

}  // namespace

ReflectorSearch::ReflectorSearch(const config::CellConfig& config, CellDevices& devices)
    : config_{config}, devices_{devices}, expected_{config::rough_cell(config)} {
  for (const config::ReflectorConfig& reflector : config::reflectors_of(config))
    names_.push_back(reflector.name);
}

void ReflectorSearch::look_for(Reflectors reflectors) {
  sight_.reset();
  if (reflectors == Reflectors::All && names_.size() > 1) prepare_visibility();
}

void ReflectorSearch::expect(CalibratedCell cell, double reach) {
  expected_ = std::move(cell);
  expected_.reflectors = config::reflectors_of(config_, expected_.reflectors);
  reach_ = reach;
  placement_known_ = true;
  if (sight_) prepare_visibility();
}

void ReflectorSearch::set_tracker_shift(const Eigen::Isometry3d& X_now_first) {
  X_now_first_ = X_now_first;
  if (sight_) prepare_visibility();
}

Eigen::Vector3d ReflectorSearch::place_mm(const ArmPosture& posture, std::size_t reflector) const {
  return X_now_first_ * expected_.predict(posture.q, static_cast<int>(reflector), posture.direction);
}

double ReflectorSearch::clear_radius_mm() const {
  std::vector<Eigen::Vector3d> places_mm;
  for (const Reflector& reflector : expected_.reflectors) places_mm.push_back(reflector.p_FS_mm);
  return std::min(config_.tracker.first_search_radius_mm, kOfSpacing * spacing_mm(places_mm));
}

/// With base and reflectors where they are known to be by now.
void ReflectorSearch::prepare_visibility() {
  Scene scene = config::scene_of(config_);
  scene.sight.X_WB = X_now_first_ * expected_.base.isometry();
  scene.sight.p_FS_mm = expected_.reflectors.front().p_FS_mm;
  for (std::size_t k = 0; k < scene.sight.further.size(); ++k)
    scene.sight.further[k].p_FS_mm = expected_.reflectors[k + 1].p_FS_mm;
  sight_.emplace(std::move(scene));
}

Eigen::Vector3d ReflectorSearch::predicted_mm(const StoredPoint& point) const {
  const auto found = std::ranges::find(expected_.reflectors, point.smr, &Reflector::name);
  const auto known = found == expected_.reflectors.end() ? 0 : found - expected_.reflectors.begin();
  return expected_.predict(point.q_actual, static_cast<int>(known), point.direction);
}

/// Those that the tracker should see; where that is none, the first may be worth a try. A reference is always
/// the same one.
std::vector<std::size_t> ReflectorSearch::reflectors_at(const JointVector& q, PointPurpose purpose) {
  if (!sight_) return {one_.value_or(0)};
  const std::vector<int> seen = sight_->seen_at(q);
  std::vector<std::size_t> reflectors(seen.begin(), seen.end());
  if (reflectors.empty()) reflectors.push_back(0);
  if (purpose == PointPurpose::Reference && placement_known_) reflectors.resize(1);
  return reflectors;
}

std::string ReflectorSearch::names_at(const JointVector& q, PointPurpose purpose) {
  std::string names;
  for (const std::size_t reflector : reflectors_at(q, purpose))
    names += (names.empty() ? "" : ", ") + names_[reflector];
  return names;
}

CellDevices::Outcome<CellDevices::MeasureResult> ReflectorSearch::look_at(const ArmPosture& posture,
                                                                          const Eigen::Vector3d& p_W_mm,
                                                                          double radius_mm) {
  const config::TrackerConfig& tracker = config_.tracker;
  return devices_.measure({.p_W_mm = p_W_mm,
                           .search_mm = placement_known_ ? reach_ * tracker.search_radius_mm : radius_mm,
                           .gate_mm = placement_known_ ? reach_ * tracker.gate_mm : radius_mm,
                           .readings = posture.readings,
                           .two_face = posture.two_face});
}

CellDevices::Outcome<ReflectorSearch::SearchResult> ReflectorSearch::measure(ArmPosture posture) {
  std::vector<std::size_t> reflectors = reflectors_at(posture.q, posture.purpose);
  if (placement_known_ || !sight_) co_return co_await measure_each(std::move(posture), std::move(reflectors));
  if (reflectors.size() == 1) co_return co_await confirm_expected(std::move(posture), reflectors.front());
  co_return co_await identify_by_shape(std::move(posture), std::move(reflectors));
}

CellDevices::Outcome<ReflectorSearch::SearchResult> ReflectorSearch::measure_each(
    ArmPosture posture, std::vector<std::size_t> reflectors) {
  SearchResult seen;
  std::optional<DeviceError> first_error;
  for (const std::size_t reflector : reflectors) {
    auto measured =
        co_await look_at(posture, place_mm(posture, reflector), config_.tracker.first_search_radius_mm);
    if (measured) {
      seen.found.push_back({reflector, *measured});
      continue;
    }
    if (measured.error().remedy != Remedy::Retry) co_return std::unexpected(measured.error());
    seen.missed.push_back("reflector \"" + names_[reflector] +
                          "\" was not measured: " + measured.error().detail);
    if (!first_error) first_error = measured.error();
  }
  if (seen.found.empty()) co_return std::unexpected(*first_error);
  co_return seen;
}

// While the base is known by some 100 mm alone, a search may find any of those that are in sight. Which it
// was shows by where all others stand from it: no shape of points but shifted onto itself by nothing is the
// same.
CellDevices::Outcome<ReflectorSearch::SearchResult> ReflectorSearch::identify_by_shape(
    ArmPosture posture, std::vector<std::size_t> reflectors) {
  Places places_mm;
  for (const std::size_t reflector : reflectors) places_mm.push_back(place_mm(posture, reflector));
  auto first = co_await look_at(posture, places_mm.front(), config_.tracker.first_search_radius_mm);
  if (!first) co_return std::unexpected(first.error());
  for (std::size_t which = 0; which < places_mm.size(); ++which) {
    auto seen = co_await measure_as_if_first(posture, places_mm, which, *first);
    if (!seen && seen.error().remedy != Remedy::Retry) co_return seen;
    if (!seen) continue;
    for (ReflectorResult& found : seen->found) found.reflector = reflectors[found.reflector];
    if (posture.purpose == PointPurpose::Reference) seen->found.resize(1);
    co_return seen;
  }
  co_return std::unexpected(cannot_tell());
}

/// The one that should be seen alone. The search may find another one that is in sight too. Then the expected
/// one is measured at its known distance from that one.
CellDevices::Outcome<ReflectorSearch::SearchResult> ReflectorSearch::confirm_expected(ArmPosture posture,
                                                                                      std::size_t expected) {
  Places places_mm;
  for (std::size_t k = 0; k < names_.size(); ++k) places_mm.push_back(place_mm(posture, k));
  auto first = co_await look_at(posture, places_mm[expected], config_.tracker.first_search_radius_mm);
  if (!first) co_return std::unexpected(first.error());
  const double radius_mm = kOfSpacing * spacing_mm(places_mm);
  SearchResult seen{.found = {{expected, *first}}};
  for (std::size_t other = 0; other < names_.size(); ++other) {
    if (other == expected) continue;
    const Eigen::Vector3d expected_mm = first->point.p_WS_mm + places_mm[expected] - places_mm[other];
    auto measured = co_await look_at(posture, expected_mm, radius_mm);
    if (!measured && measured.error().remedy != Remedy::Retry) co_return std::unexpected(measured.error());
    if (!measured) continue;
    seen.found = {{expected, *measured}};
    if (posture.purpose != PointPurpose::Reference) seen.found.push_back({other, *first});
    break;
  }
  co_return seen;
}

/// All of them, in their order, where the one that was found first is this one; fails where another is not
/// found.
CellDevices::Outcome<ReflectorSearch::SearchResult> ReflectorSearch::measure_as_if_first(
    ArmPosture posture, Places places_mm, std::size_t which, CellDevices::MeasureResult first) {
  const double radius_mm = kOfSpacing * spacing_mm(places_mm);
  const Eigen::Vector3d shift_mm = first.point.p_WS_mm - places_mm[which];
  SearchResult seen;
  for (std::size_t k = 0; k < places_mm.size(); ++k) {
    if (k == which) {
      seen.found.push_back({k, first});
      continue;
    }
    auto other = co_await look_at(posture, places_mm[k] + shift_mm, radius_mm);
    if (!other) co_return std::unexpected(other.error());
    seen.found.push_back({k, *other});
  }
  co_return seen;
}

}  // namespace truepose::daemon
