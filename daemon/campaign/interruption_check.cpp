#include "daemon/campaign/interruption_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/change/tracker_motion.hpp"
#include "core/formatted.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"

namespace truepose::daemon {

namespace {

// Two tell that something moved, eight by how much: all that is measured later depends on that.
constexpr std::size_t kToCheck = 2, kToFit = 8, kFewestToFit = 3;
constexpr std::size_t kMostTries = 12;
// Beyond so many standard deviations, points of before and of now are not of one arm and one reflector.
constexpr double kMostSigmas = 6;

CampaignError refused(const std::string& why) { return {CampaignFault::Calibration, why}; }

std::string poses_text(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " pose" : " poses");
}

class InterruptionCheck {
 public:
  explicit InterruptionCheck(MeasuringSession& session);
  CampaignOutcome<void> run();

 private:
  CampaignOutcome<void> check_nests();
  CampaignOutcome<void> measure(std::size_t poses);
  CampaignOutcome<void> judge();
  bool agrees() const;
  double sigma_mm(std::size_t i) const;
  double left_mm(std::size_t i) const { return (then_[i].p_mm - X_ * now_[i].p_mm).norm(); }
  std::size_t worst() const;
  Done fit();
  std::string finding_text() const;

  MeasuringSession& session_;
  const MeasurementNoise noise_;
  std::vector<StoredPoint> poses_;  ///< of before, as the first stand saw them, in the order to measure them
  std::vector<StoredPoint> nests_;
  Eigen::Isometry3d X_;              ///< first from now, as far as it is known
  Eigen::Vector3d off_mm_{0, 0, 0};  ///< of what was seen last from where X_ has it, now
  std::size_t tried_ = 0;            ///< of the poses
  NestReadings then_, now_;          ///< of the poses that were seen again
  NestReadings nests_then_, nests_now_;
  bool nests_moved_ = false;
  bool touched_ = false;      ///< there are points that the arm's TCP touched, which no tracker sees
  std::vector<int> numbers_;  ///< of the poses that were seen again
  std::string moved_;         ///< by how much the tracker has, in words; empty: not at all
};

/// Each pose once, the last one measured first, then always the one that is farthest from those before it.
std::vector<StoredPoint> spread(std::vector<StoredPoint> points) {
  std::ranges::reverse(points);
  std::vector<StoredPoint> chosen;
  while (!points.empty()) {
    const auto distance_mm = [&](const StoredPoint& point) {
      double nearest_mm = std::numeric_limits<double>::infinity();
      for (const StoredPoint& other : chosen)
        nearest_mm = std::min(nearest_mm, (*point.p_WS_mm - *other.p_WS_mm).norm());
      return nearest_mm;
    };
    const auto next = chosen.empty() ? points.begin() : std::ranges::max_element(points, {}, distance_mm);
    chosen.push_back(*next);
    std::erase_if(points,
                  [q = chosen.back().q_target](const StoredPoint& point) { return point.q_target == q; });
  }
  return chosen;
}

InterruptionCheck::InterruptionCheck(MeasuringSession& session)
    : session_{session},
      noise_{session.config().tracker.noise, session.config().robot.repeatability_mm},
      X_{session.result().resumptions.back().X_first_now} {
  std::map<std::string, StoredPoint> nests;
  std::vector<StoredPoint> poses;
  for (const StoredPoint& point : session_.result().points) {
    const StoredPoint at_first = in_first_frame(point, session_.result().resumptions);
    if (point.purpose == PointPurpose::Nest) nests[point.smr] = at_first;
    touched_ = touched_ || !point.p_WS_mm;
    if (is_pose(point.purpose) && session_.search().is_there(point.smr)) poses.push_back(at_first);
  }
  poses_ = spread(std::move(poses));
  for (const auto& [name, nest] : nests) nests_.push_back(nest);
}

CampaignOutcome<void> InterruptionCheck::run() {
  Resumption& resumption = session_.result().resumptions.back();
  if (touched_)
    resumption.found =
        "the points that had been touched are kept; whether arm or fixture moved since was not checked";
  else if (poses_.empty())
    resumption.found = "nothing had been measured";
  if (!resumption.found.empty()) co_return Done{};
  Done done = co_await check_nests();
  if (done) done = co_await measure(kToCheck);
  if (done && (nests_moved_ || !agrees())) {
    done = co_await measure(kToFit);
    if (done) done = co_await judge();
  }
  if (!done) co_return done;
  resumption.found = finding_text();
  resumption.X_first_now = X_;
  co_return done;
}

/// What seems to have moved. Where the nests stand still and the poses are too few to tell by how much,
/// chance alone has some look moved: they do so once more, or nothing has.
CampaignOutcome<void> InterruptionCheck::judge() {
  if (now_.size() >= kFewestToFit || nests_moved_) co_return fit();
  tried_ = 0;
  for (auto* readings : {&then_, &now_}) readings->clear();
  numbers_.clear();
  Done done = co_await measure(kToCheck);
  if (done && !agrees()) done = fit();
  co_return done;
}

/// Where they have moved, they also tell where to look for the arm's reflector.
CampaignOutcome<void> InterruptionCheck::check_nests() {
  for (const StoredPoint& nest : nests_) {
    const Eigen::Vector3d p_mm = X_.inverse() * *nest.p_WS_mm;
    auto seen = co_await session_.measure_again(nest, p_mm + off_mm_);
    if (!seen) co_return std::unexpected(seen.error());
    if (!*seen) continue;
    off_mm_ = **seen - p_mm;
    nests_then_.push_back({*nest.p_WS_mm, 1});
    nests_now_.push_back({**seen, 1});
  }
  const auto motion = tracker_motion(nests_then_, nests_now_, {.tracker = noise_.tracker});
  if (!motion || motion->fit < kSignificance || motion->probability >= kSignificance) co_return Done{};
  nests_moved_ = true;
  X_ = motion->X;
  off_mm_.setZero();
  co_return Done{};
}

/// Until so many were seen, or no more are there.
CampaignOutcome<void> InterruptionCheck::measure(std::size_t poses) {
  for (; now_.size() < poses && tried_ < std::min(poses_.size(), kMostTries); ++tried_) {
    const StoredPoint& before = poses_[tried_];
    const Eigen::Vector3d p_mm = X_.inverse() * *before.p_WS_mm;
    auto seen = co_await session_.measure_again(before, p_mm + off_mm_);
    if (!seen) co_return std::unexpected(seen.error());
    if (!*seen) continue;
    off_mm_ = **seen - p_mm;
    then_.push_back({*before.p_WS_mm, 1});
    now_.push_back({**seen, 1});
    numbers_.push_back(before.pose);
  }
  if (now_.size() >= std::min(kToCheck, poses_.size())) co_return Done{};
  co_return std::unexpected(refused(
      "of " + poses_text(tried_) + " measured before the interruption " + std::to_string(now_.size()) +
      " could be seen again: let the tracker see the reflector, then resume the campaign"));
}

/// As an unchanged cell would show it.
bool InterruptionCheck::agrees() const {
  double distance2 = 0;
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const Eigen::Matrix3d W = inverse_cholesky(2 * reading_covariance(then_[i].p_mm, noise_));
    distance2 += (W * (then_[i].p_mm - X_ * now_[i].p_mm)).squaredNorm();
  }
  return chi_square_tail(distance2, 3 * static_cast<int>(now_.size())) >= kSignificance;
}

/// Of the difference of two readings, per axis.
double InterruptionCheck::sigma_mm(std::size_t i) const {
  return std::sqrt(2 * reading_covariance(then_[i].p_mm, noise_).trace() / 3);
}

std::size_t InterruptionCheck::worst() const {
  std::size_t worst = 0;
  for (std::size_t i = 1; i < now_.size(); ++i)
    if (left_mm(i) > left_mm(worst)) worst = i;
  return worst;
}

Done InterruptionCheck::fit() {
  if (now_.size() < kFewestToFit)
    return std::unexpected(refused(formatted(
        "pose %d, measured again, is %.3f mm from where it was, and %zu of them are too few to show "
        "what has moved: abort the campaign and start it again",
        numbers_[worst()], left_mm(worst()), now_.size())));
  // The nests, as far as they tell the same: they stand farther apart.
  NestReadings then = then_, now = now_;
  if (nests_moved_) {
    then.insert(then.end(), nests_then_.begin(), nests_then_.end());
    now.insert(now.end(), nests_now_.begin(), nests_now_.end());
  }
  auto motion = tracker_motion(then, now, noise_);
  if (!motion || motion->fit < kSignificance) motion = tracker_motion(then_, now_, noise_);
  if (!motion) return std::unexpected(refused("the poses measured again: " + motion.error()));
  if (motion->probability < kSignificance) {
    X_ = motion->X;
    moved_ = formatted("the tracker or the base has moved by %.3f mm and %.0f urad",
                       motion->shift_mm().norm(), 1e6 * motion->turn_rad().norm());
  }
  if (left_mm(worst()) <= kMostSigmas * sigma_mm(worst())) return {};
  return std::unexpected(refused(formatted(
      "pose %d, measured again, is %.3f mm from where it was, and no motion of the tracker explains "
      "that: see that reflector, load and mastering are as they were and resume the campaign, or "
      "abort it and start it again",
      numbers_[worst()], left_mm(worst()))));
}

std::string InterruptionCheck::finding_text() const {
  const std::string seen =
      formatted("%s measured again %s within %.3f mm of where %s", poses_text(now_.size()).c_str(),
                now_.size() == 1 ? "is" : "are", left_mm(worst()), now_.size() == 1 ? "it was" : "they were");
  if (moved_.empty()) return "nothing has moved: " + seen;
  return moved_ + ", and what is measured since is brought to where it stood at first; with that " + seen;
}

}  // namespace

CampaignOutcome<void> find_what_moved(MeasuringSession& session) {
  InterruptionCheck check{session};
  co_return co_await check.run();
}

}  // namespace truepose::daemon
