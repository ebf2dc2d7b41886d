#include "tools/sim/tracker/tracker_beam.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace truepose::sim {

namespace {

constexpr std::size_t kStray = std::numeric_limits<std::size_t>::max();
constexpr std::size_t kInHomeNest = kStray - 1;

}  // namespace

MeanReading MeanReading::of(const std::vector<Eigen::Vector3d>& readings_mm) {
  const auto count = static_cast<double>(readings_mm.size());
  MeanReading mean;
  for (const Eigen::Vector3d& reading_mm : readings_mm) mean.p_mm += reading_mm / count;
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& reading_mm : readings_mm)
    variance += (reading_mm - mean.p_mm).cwiseAbs2() / (count * (count - 1));
  mean.std_mm = variance.cwiseSqrt();
  return mean;
}

void TrackerBeam::block(std::chrono::milliseconds duration) {
  blocked_until_ = std::max(blocked_until_, clock_.now() + duration);
}

void TrackerBeam::point_at(const Eigen::Vector3d& p_mm) {
  release();
  aim_mm_ = p_mm;
}

void TrackerBeam::turn_over() {
  release();
  face_ = 3 - face_;
}

void TrackerBeam::initialise() {
  release();
  face_ = 1;
}

void TrackerBeam::come_home() {
  initialise();
  locked_ = kInHomeNest;
  follow();
}

std::chrono::duration<double> TrackerBeam::age() const {
  return std::chrono::duration<double>{clock_.now() - switched_on_} * speedup_;
}

std::optional<Eigen::Vector3d> TrackerBeam::place_of(Reflector reflector, const TargetSight& sight) const {
  if (reflector == kStray) return stray_mm_;
  if (reflector == kInHomeNest) return kHomeNest_mm;
  if (reflector == 0) return sight.p_WS_mm;
  --reflector;
  if (reflector < sight.others_mm.size()) return sight.others_mm[reflector];
  return instrument_.nests_mm[reflector - sight.others_mm.size()];
}

/// Where the beam finds a reflector now; nothing while it is hidden or the beam is broken.
std::optional<Eigen::Vector3d> TrackerBeam::seen(Reflector reflector) const {
  // On the tracker's own body: no obstacle stands before it, and it moves with the tracker.
  if (reflector == kInHomeNest) return kHomeNest_mm;
  if (clock_.now() < blocked_until_) return std::nullopt;
  auto p_mm = place_of(reflector, target_.look());
  if (!p_mm) return std::nullopt;
  return instrument_.stand.moved(*p_mm, age()) + disturbance_.moved_mm;
}

std::optional<TrackerBeam::Reflector> TrackerBeam::nearest_to(const Eigen::Vector3d& p_mm,
                                                              double radius_mm) const {
  std::optional<Reflector> nearest;
  const auto consider = [&](Reflector reflector) {
    const auto at_mm = seen(reflector);
    if (!at_mm || (*at_mm - p_mm).norm() > radius_mm) return;
    radius_mm = (*at_mm - p_mm).norm();
    nearest = reflector;
  };
  // PowerLock, which has no radius, looks into the cell and not at the tracker.
  if (std::isfinite(radius_mm)) consider(kInHomeNest);
  const std::size_t reflectors = 1 + target_.look().others_mm.size() + instrument_.nests_mm.size();
  for (Reflector reflector = 0; reflector < reflectors; ++reflector) consider(reflector);
  return nearest;
}

std::optional<Eigen::Vector3d> TrackerBeam::find(const Eigen::Vector3d& p_mm, double radius_mm) const {
  const auto found = nearest_to(p_mm, radius_mm);
  return found ? seen(*found) : std::nullopt;
}

bool TrackerBeam::lock_within(double radius_mm) {
  locked_ = nearest_to(aim_mm_, radius_mm);
  if (!locked_) return false;
  if (const auto p_mm = place_of(*locked_, target_.look()); p_mm && disturbance_.stray_mm) {
    stray_mm_ = *p_mm + *disturbance_.stray_mm;
    locked_ = kStray;
  }
  follow();
  return locked();
}

bool TrackerBeam::follow() {
  if (!locked_) return false;
  const auto p_mm = seen(*locked_);
  if (p_mm) {
    aim_mm_ = *p_mm;
  } else {
    release();
  }
  return !p_mm;
}

Eigen::Vector3d TrackerBeam::reading(double index) const {
  const Eigen::Vector3d warm_mm = instrument_.warming.seen(aim_mm_, age());
  Eigen::Vector3d read_mm = instrument_.aiming.seen(warm_mm, face_);
  if (instrument_.air) read_mm *= edlen_group_index(*instrument_.air) / index;
  // Scaled so that the mean of the readings scatters as the noise of one point says.
  const Eigen::Vector3d noise_mm = noise_(aim_mm_) - aim_mm_;
  return read_mm + disturbance_.bias_mm + std::sqrt(double{kReadings}) * noise_mm;
}

std::optional<MeasuredOrientation> TrackerBeam::orientation(const OrientationNoise& noise) const {
  if (locked_ != Reflector{0}) return std::nullopt;
  return noise(instrument_.stand.motion(age()).linear() * target_.look().R_WT);
}

}  // namespace truepose::sim
