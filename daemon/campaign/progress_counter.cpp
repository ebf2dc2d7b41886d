#include "daemon/campaign/progress_counter.hpp"

#include <algorithm>
#include <cmath>

namespace truepose::daemon {

void ProgressCounter::enter(CampaignPhase phase) {
  counted_.phase = phase;
  error_sum_mm_ = 0;
  error_count_ = 0;
  report();
}

void ProgressCounter::count_error(double deviation_mm) {
  error_sum_mm_ += deviation_mm;
  counted_.error_mm = error_sum_mm_ / ++error_count_;
}

void ProgressCounter::begin_pose() {
  if (!pose_begun_) pose_begun_ = clock_.now();
}

void ProgressCounter::end_pose() {
  const drivers::TimePoint now = clock_.now();
  if (pose_begun_) pose_times_s_.push_back(std::chrono::duration<double>(now - *pose_begun_).count());
  pose_begun_ = now;
}

CampaignProgress ProgressCounter::now() const {
  CampaignProgress now = counted_;
  now.time_left_s = time_left_s();
  if (!past_) return now;
  // What it will take from its past once it has the devices, it has done.
  now.done = std::max(now.done, past_->poses_done());
  now.skipped = std::max(now.skipped, static_cast<int>(past_->skipped.size()));
  now.total = std::max(now.total, now.done + now.skipped);
  return now;
}

/// By the median, so that a pose that waited for a device does not count; of the present one what is left of
/// that, or what it has taken beyond.
std::optional<double> ProgressCounter::time_left_s() const {
  const int left = counted_.left();
  if (pose_times_s_.empty() || left <= 0) return pose_times_s_.empty() ? std::nullopt : std::optional{0.0};
  std::vector<double> times_s = pose_times_s_;
  const auto middle = times_s.begin() + static_cast<std::ptrdiff_t>(times_s.size() / 2);
  std::ranges::nth_element(times_s, middle);
  const double taken_s = std::chrono::duration<double>(clock_.now() - *pose_begun_).count();
  return (left - 1) * *middle + std::abs(*middle - taken_s);
}

}  // namespace truepose::daemon
