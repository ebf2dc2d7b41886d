#include "core/change/change_hypothesis.hpp"

#include "core/formatted.hpp"
#include "core/math/units.hpp"

namespace truepose {
namespace {

/// "0.21 mm and 0.0030 deg"; empty for what has no single amount.
std::string amount_of(const Change& change, const Eigen::VectorXd& v, const CalibratedCell& cell) {
  switch (change.kind) {
    case ChangeKind::Base:
      return formatted("%.2f mm and %.4f deg", v.head<3>().norm(), v.tail<3>().norm() * kDegPerRad);
    case ChangeKind::JointZero:
      return cell.robot.joints[static_cast<std::size_t>(change.index)].type == JointType::Revolute
                 ? formatted("%.4f deg", v[0] * kDegPerRad)
                 : formatted("%.3f mm", v[0]);
    case ChangeKind::Growth:
      return formatted("%.0f ppm", 1e6 * v[0]);
    case ChangeKind::Reflector:
    case ChangeKind::Reading:
      return formatted("%.2f mm", v.norm());
    default:
      return {};
  }
}

}  // namespace

std::string name_of(const ChangeHypothesis& change, const CalibratedCell& cell,
                    std::span<const Measurement> points) {
  const auto at = static_cast<std::size_t>(change.what.index);
  const int number = change.what.index + 1;
  const bool between = change.profile == TimeProfile::BetweenChecks;
  switch (change.what.kind) {
    case ChangeKind::Base:
      return "the tracker or the base moved";
    case ChangeKind::Reflector:
      return "reflector '" + cell.reflectors[at].name +
             (between ? "' moved on the flange" : "' was exchanged or moved on the flange");
    case ChangeKind::JointZero:
      return formatted(between ? "axis %d's zero moved" : "the encoder offset of joint %d changed", number);
    case ChangeKind::Growth:
      return between ? "all lengths of the arm grew"
                     : "all lengths of the arm changed, as it became warmer or colder";
    case ChangeKind::AllZeros:
      return "the joints were mastered again";
    case ChangeKind::Load:
      return "the load on the flange changed";
    case ChangeKind::Link:
      return parameter_names(cell)[at] + " changed";
    case ChangeKind::Reading:
      return formatted("the reading of point %d alone is off", points[at].row > 0 ? points[at].row : number);
    case ChangeKind::WarmUp:
      return "the arm warmed up";
    case ChangeKind::JointErrors:
      return formatted("joint %d errs as much with its position", number);
    case ChangeKind::Pose:
      return "the reference pose did not stay where it was";
  }
  return {};
}

std::string described(const ChangeFound& found, const CalibratedCell& cell,
                      std::span<const Measurement> points) {
  const std::string amount = amount_of(found.what, found.moved, cell);
  return name_of(found, cell, points) + (amount.empty() ? "" : " by " + amount);
}

std::string described_with_sigma(const ChangeFound& found, const CalibratedCell& cell,
                                 std::span<const Measurement> points) {
  return described(found, cell, points) + " (sigma " + amount_of(found.what, found.sigma, cell) + ")";
}

std::string_view remedy(ChangeKind kind) {
  switch (kind) {
    case ChangeKind::Base:
      return "fit the frame again";
    case ChangeKind::Reflector:
      return "fasten it and fit its place on the flange again";
    case ChangeKind::JointZero:
      return "check the axis's mastering, then calibrate again";
    case ChangeKind::Growth:
      return "measure when the arm is as warm as it was";
    case ChangeKind::Reading:
      return "measure that point again";
    default:
      return "calibrate again";
  }
}

}  // namespace truepose
