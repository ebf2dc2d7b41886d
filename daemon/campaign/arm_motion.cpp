#include "daemon/campaign/arm_motion.hpp"

#include <cmath>
#include <utility>

#include "core/math/angles.hpp"
#include "core/plan/scene.hpp"

namespace truepose::daemon {

namespace {

// A joint that moved less than this has not taken up its backlash.
constexpr double kMoved = 1e-4;

}  // namespace

double approach_way_rad(const config::CampaignConfig& campaign, int pose) {
  const double way_rad = campaign.approach_deg * kRadPerDeg;
  switch (campaign.approach) {
    case config::ApproachSide::Any:
      return 0;
    case config::ApproachSide::Upwards:
      return way_rad;
    case config::ApproachSide::Alternate:
      return pose % 2 == 1 ? way_rad : -way_rad;
  }
  return 0;
}

std::vector<std::int8_t> direction_after(std::vector<std::int8_t> direction, const JointVector& way) {
  direction.resize(static_cast<std::size_t>(way.size()));
  for (Eigen::Index i = 0; i < way.size(); ++i) {
    if (std::abs(way[i]) > kMoved) direction[static_cast<std::size_t>(i)] = way[i] > 0 ? 1 : -1;
  }
  return direction;
}

CellDevices::Outcome<JointVector> ArmMotion::drive(JointVector q) {
  auto here = co_await devices_.position();
  if (!here) co_return here;
  auto job = [poses = poses_, from = *here, q] { return poses->way(from, q); };
  auto way = co_await result_of(compute_, job);
  if (!way) {
    co_return std::unexpected(
        DeviceError{Remedy::Retry, "no clear way was found from where the arm stands; move it by hand"});
  }
  way->push_back(q);
  for (const JointVector& stop : *way) {
    const JointVector from = *here;
    here = co_await devices_.move(stop);
    if (!here) co_return here;
    direction_ = direction_after(std::move(direction_), *here - from);
  }
  co_return here;
}

CellDevices::Outcome<JointVector> ArmMotion::arrive(JointVector q, double way_rad) {
  if (way_rad != 0) {
    auto start = co_await drive(approach_start(robot_, q, way_rad));
    if (!start) co_return start;
  }
  co_return co_await drive(q);
}

}  // namespace truepose::daemon
