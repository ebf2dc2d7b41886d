#include "tools/sim/stream_path.hpp"

#include <utility>

namespace truepose::sim {

StreamPath::StreamPath(RobotModel nominal, std::vector<JointVector> points, double speed_scale)
    : nominal_{std::move(nominal)}, points_{std::move(points)}, speed_scale_{speed_scale}, motion_{leg()} {}

JointMotion StreamPath::leg() const {
  return {nominal_, points_[from_], points_[(from_ + 1) % points_.size()], speed_scale_};
}

JointVector StreamPath::position() const { return motion_.position(on_leg_); }

void StreamPath::advance(Seconds dt) {
  on_leg_ += dt;
  if (on_leg_ < motion_.duration()) return;
  on_leg_ -= motion_.duration();
  from_ = (from_ + 1) % points_.size();
  motion_ = leg();
}

}  // namespace truepose::sim
