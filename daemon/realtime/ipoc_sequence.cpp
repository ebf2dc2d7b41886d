#include "daemon/realtime/ipoc_sequence.hpp"

#include <algorithm>
#include <utility>

namespace truepose::daemon {
namespace {

constexpr std::uint64_t kWrap32 = std::uint64_t{1} << 32;

}  // namespace

IpocSequence::Position IpocSequence::place(std::uint64_t ipoc) const noexcept {
  if (!begun_) return {.place = Place::Jump};
  if (ipoc == last_) return {.place = Place::Duplicate};

  const std::uint64_t window = std::max<std::uint64_t>(step_, 1) * gap_cycles_;
  std::uint64_t forward = ipoc - last_;
  if (ipoc < last_) {
    // Some controllers count in 32 bits, which are full after 49 days: no reason to let go of the correction.
    const bool wrapped = last_ < kWrap32 && kWrap32 - last_ <= window && ipoc < window;
    if (!wrapped) return {.place = last_ - ipoc <= window ? Place::Stale : Place::Jump};
    forward = kWrap32 - last_ + ipoc;
  }
  const std::uint64_t step = step_ == 0 ? forward : step_;
  if (forward < step / 2) return {.place = Place::Stale};  // no tick of the controller
  const std::uint64_t elapsed =
      std::max<std::uint64_t>(1, forward / step + (forward % step > step / 2 ? 1 : 0));
  return {.place = elapsed > gap_cycles_ ? Place::Jump : Place::Next, .forward = forward, .elapsed = elapsed};
}

bool IpocSequence::bears_out(std::uint64_t ipoc) noexcept {
  constexpr std::uint64_t kSoon = 1000;
  const bool goes_on = others_ > 0 && ipoc > other_ && ipoc - other_ < kSoon;
  others_ = goes_on ? others_ + 1 : 1;
  other_ = ipoc;
  return !begun_ || others_ >= 3;
}

void IpocSequence::start(std::uint64_t ipoc, std::uint64_t step) noexcept {
  begun_ = true;
  last_ = ipoc;
  step_ = step;
  last_forward_ = 0;
  others_ = 0;
}

void IpocSequence::advance(std::uint64_t ipoc, const Position& position) noexcept {
  last_ = ipoc;
  others_ = 0;
  // The smallest step that was seen twice in a row: not a gap, not a damaged time stamp.
  const bool again = std::exchange(last_forward_, position.forward) == position.forward;
  if (again && (step_ == 0 || position.forward < step_)) step_ = position.forward;
}

}  // namespace truepose::daemon
