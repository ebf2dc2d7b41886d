#include "tests/daemon/plant.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace truepose::test {

Plant::Plant(const PlantOptions& options)
    : options_{options},
      dead_cycles_{static_cast<std::size_t>(options.dead_time_ms / options.cycle_ms)},
      dead_part_{options.dead_time_ms / options.cycle_ms - static_cast<double>(dead_cycles_)},
      ipoc_{options.first_ipoc - options.ipoc_step},
      source_port_{options.source_port} {
  if (!(options.cycle_ms > 0) || options.ipoc_step == 0 || options.timeout_cycles < 1 ||
      options.timeout_counts == Count::None || !(options.lag_ms >= 0) || !(options.dead_time_ms >= 0) ||
      dead_cycles_ > kMaxDeadTimeCycles)
    throw std::invalid_argument{"PlantOptions: out of range"};
  for (std::size_t i = 0; i < share_.size(); ++i) {
    const double lag_ms = options.lag_ms * options.axis_lag_scale[i];
    share_[i] = lag_ms > 0 ? 1 - std::exp(-options.cycle_ms / lag_ms) : 1;
  }
}

std::optional<Plant::Sent> Plant::begin_cycle(const Axes& aspos_deg) {
  if (!alive_) return std::nullopt;
  ipoc_ += options_.ipoc_step;
  reply_.reset();
  if (pause_cycles_ == 0 && std::exchange(settles_, false)) {
    stand_at(aspos_deg);
  } else {
    drive(aspos_deg);
  }
  sent_ = pause_cycles_ == 0;
  if (!sent_) {
    --pause_cycles_;
    return std::nullopt;
  }
  Sent sent{ipoc_, aspos_deg, actual_deg_, std::nullopt, source_port_};
  if (options_.delay == Count::Cumulative) sent.delay = unanswered_;
  if (options_.delay == Count::Consecutive) sent.delay = unanswered_in_a_row_;
  return sent;
}

bool Plant::take_reply(std::uint64_t ipoc, const Axes& correction_deg) {
  if (!sent_ || reply_ || ipoc != ipoc_) return false;
  if (!std::ranges::all_of(correction_deg, [](double deg) { return std::isfinite(deg); })) return false;
  reply_ = correction_deg;
  return true;
}

Plant::State Plant::end_cycle() {
  if (!std::exchange(sent_, false)) return {alive_, in_force_deg_, 0};
  if (reply_) {
    unanswered_in_a_row_ = 0;
  } else {
    ++unanswered_;
    ++unanswered_in_a_row_;
  }
  const double limit_deg = options_.axis_corr_limit_deg;
  double step_deg = 0;
  for (std::size_t i = 0; i < in_force_deg_.size(); ++i) {
    double next_deg = options_.holdon ? in_force_deg_[i] : 0;
    if (reply_) next_deg = options_.ignores_correction ? 0 : std::clamp((*reply_)[i], -limit_deg, limit_deg);
    step_deg = std::max(step_deg, std::abs(next_deg - in_force_deg_[i]));
    in_force_deg_[i] = next_deg;
  }
  const bool total = options_.timeout_counts == Count::Cumulative;
  alive_ = (total ? unanswered_ : unanswered_in_a_row_) < options_.timeout_cycles;
  return {alive_, in_force_deg_, step_deg};
}

void Plant::restart_session(const Restart& restart) {
  pause_cycles_ = restart.pause_cycles;
  if (restart.ipoc) {
    ipoc_ = *restart.ipoc - static_cast<std::uint64_t>(pause_cycles_ + 1) * options_.ipoc_step;
  }
  source_port_ = restart.source_port.value_or(source_port_);
  settles_ = restart.arm_settled;
  sent_ = false;
  alive_ = true;
  unanswered_ = 0;
  unanswered_in_a_row_ = 0;
  in_force_deg_ = {};
}

void Plant::drive(const Axes& aspos_deg) {
  newest_ = (newest_ + 1) % kLine;
  Axes& commanded_deg = commanded_deg_[newest_];
  for (std::size_t i = 0; i < commanded_deg.size(); ++i) commanded_deg[i] = aspos_deg[i] + in_force_deg_[i];
  const Axes& later = commanded_ago(dead_cycles_);
  const Axes& earlier = commanded_ago(dead_cycles_ + 1);
  for (std::size_t i = 0; i < actual_deg_.size(); ++i) {
    const double given_deg = later[i] + dead_part_ * (earlier[i] - later[i]);
    actual_deg_[i] += share_[i] * (given_deg - actual_deg_[i]);
  }
}

void Plant::stand_at(const Axes& axes_deg) {
  commanded_deg_.fill(axes_deg);
  actual_deg_ = axes_deg;
}

const Plant::Axes& Plant::commanded_ago(std::size_t cycles) const {
  return commanded_deg_[(newest_ + kLine - cycles) % kLine];
}

}  // namespace truepose::test
