#include "drivers/mock/mock_cell.hpp"

#include <utility>

namespace truepose::drivers {

MockCell::MockCell(MockCellOptions options, Clock& clock)
    : options_{std::move(options)},
      clock_{clock},
      random_{options_.seed},
      arm_{options_.truth, random_.next()},
      stand_{options_.q_start},
      start_{clock.now()},
      switched_on_{start_} {}

void MockCell::start_motion(const JointVector& q, double speed_percent) {
  const JointVector from = this->q();
  motion_.emplace(options_.nominal, from, q, speed_percent / 100);
  start_ = clock_.now();
  arm_.warm_up(start_ - switched_on_);
  arm_.move(from, q);
}

void MockCell::stop_motion() {
  stand_ = q();
  motion_.reset();
}

TimePoint MockCell::motion_ends() const {
  if (!motion_) return start_;
  return start_ + std::chrono::ceil<Duration>(motion_->duration());
}

JointVector MockCell::q() const { return motion_ ? motion_->position(clock_.now() - start_) : stand_; }

}  // namespace truepose::drivers
