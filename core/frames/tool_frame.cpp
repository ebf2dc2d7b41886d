#include "core/frames/tool_frame.hpp"

#include <algorithm>

#include "core/arm/forward.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/orientation_spread.hpp"
#include "core/fit/uncertainty.hpp"
#include "core/formatted.hpp"
#include "core/frames/tool_turn.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

bool is_touched(const FrameReadings& data) {
  return std::ranges::any_of(data.readings, [](const FrameReading& reading) { return !reading.p_WS_mm; });
}

/// Unknowns: each point in the flange frame, and the touched point in the base.
std::vector<PointEquation> tool_equations(const FrameReadings& data, const MeasuringCell& by,
                                          const CalibratedCell& cell) {
  const auto points = static_cast<Eigen::Index>(data.points.size());
  const Eigen::Index unknowns = 3 * points + (is_touched(data) ? 3 : 0);
  const Eigen::Isometry3d X_BW = inverse_of(cell.base.isometry());
  std::vector<PointEquation> result;
  for (const FrameReading& reading : data.readings) {
    const Eigen::Isometry3d X_BF = forward_kinematics(cell.robot, reading.q);
    PointEquation equation{.A = Eigen::MatrixXd::Zero(3, unknowns),
                           .b = -X_BF.translation(),
                           .covariance = covariance_in_base(reading, by)};
    equation.A.middleCols<3>(3 * static_cast<Eigen::Index>(reading.point)) = X_BF.linear();
    if (reading.p_WS_mm) {
      equation.b += X_BW * *reading.p_WS_mm;
    } else {
      equation.A.rightCols<3>() = -Eigen::Matrix3d::Identity();
    }
    result.push_back(equation);
  }
  return result;
}

/// Where the readings show that base or tracker moved since the model was made: the flange turns a TCP along,
/// and such a shift it does not.
std::optional<BaseShift> shift_of_base(const FrameReadings& data, const EquationsOf& equations_of,
                                       const MeasuringCell& by) {
  constexpr double kLeastTilt_rad = 1 * kRadPerDeg;
  std::vector<Eigen::Matrix3d> turns;
  for (const FrameReading& reading : data.readings)
    turns.push_back(forward_kinematics(by.cell.robot, reading.q).linear());
  const bool spare = data.readings.size() > data.points.size() + 1;
  if (!spare || orientation_spread(turns).tilt_rad < kLeastTilt_rad) return std::nullopt;

  const auto with_shift = [&](const Eigen::VectorXd& step) {
    std::vector<PointEquation> equations = equations_of(step);
    for (PointEquation& equation : equations) {
      equation.A.conservativeResize(Eigen::NoChange, equation.A.cols() + 3);
      equation.A.rightCols<3>() = -Eigen::Matrix3d::Identity();
    }
    return equations;
  };
  const PointFit fit = fit_points(with_shift(Eigen::VectorXd::Zero(by.covariance.cols())));
  if (std::ranges::max(fit.sigmas) > kDoubtful) return std::nullopt;
  BaseShift shift{fit.u.tail<3>(), fit.covariance.bottomRightCorner<3, 3>()};
  if (by.covariance.size() == 0) return shift;
  const Eigen::MatrixXd by_parameters = derivative_to_steps(with_shift, by.covariance).bottomRows<3>();
  shift.covariance += congruence(by_parameters, by.covariance);
  return shift;
}

/// Why orientations of readings do not say how the tool is turned; empty where they do.
std::string why_not_turned(const FrameReadings& data) {
  if (data.points.size() > 1 || data.points.front().name != kOrigin || data.points.front().p_mm)
    return "a reading with an orientation gives the whole tool: its point is \"origin\", and no other is read. "
           "Leave the other points out, or the orientations";
  if (!std::ranges::all_of(
          data.readings, [](const FrameReading& reading) { return reading.p_WS_mm && reading.orientation; }))
    return "some readings have an orientation and some do not: give it for all, or for none";
  return {};
}

/// Makes the tool's turn that of the readings.
void take_turn(MeasuredFrame& frame, const ToolTurn& turn, const Eigen::MatrixXd& covariance) {
  frame.is_orientation_known = true;
  frame.by_readings.bottomRightCorner<3, 3>() = turn.sigma_rad * turn.sigma_rad * Eigen::Matrix3d::Identity();
  if (covariance.size() > 0) frame.by_parameters.bottomRows<3>() = turn.by_parameters;
  frame.covariance = frame.by_readings + congruence(frame.by_parameters, covariance);
  frame.turn_error_rad = turn.error_rad;
  for (std::size_t i = 0; i < turn.sigmas.size(); ++i) {
    if (turn.sigmas[i] > kDoubtful) frame.doubtful.push_back(i);
  }
  std::ranges::sort(frame.doubtful);
  const auto twice = std::ranges::unique(frame.doubtful);
  frame.doubtful.erase(twice.begin(), twice.end());
}

/// Why the orientations in which the arm measured a point do not tell where it is on the flange.
///
/// @param measured        "the TCP touched the point"
/// @param too_alike_then  what comes of orientations that are, and what to do
std::string why_not_identifiable(const FrameReadings& data, const RobotModel& robot, const std::string& name,
                                 const std::string& measured, const std::string& too_alike_then) {
  constexpr std::size_t kFewest = kFewestOrientations;
  std::vector<Eigen::Matrix3d> turns;
  for (const FrameReading& reading : data.readings) {
    if (data.points[reading.point].name == name)
      turns.push_back(forward_kinematics(robot, reading.q).linear());
  }
  if (turns.size() < kFewest)
    return measured +
           formatted(" in %zu orientations; at least %zu are needed, better ten", turns.size(), kFewest);
  const std::string alike = too_alike(turns);
  return alike.empty() ? alike : alike + too_alike_then;
}

}  // namespace

std::string too_alike(std::span<const Eigen::Matrix3d> turns) {
  constexpr double kLeastTilt_rad = 5 * kRadPerDeg;
  const OrientationSpread spread = orientation_spread(turns);
  if (spread.tilt_rad >= kLeastTilt_rad) return {};
  return formatted("the orientations tilt the flange's direction (%.2f %.2f %.2f) by %.1f deg only",
                   spread.stiff_F.x(), spread.stiff_F.y(), spread.stiff_F.z(), spread.tilt_rad * kDegPerRad);
}

std::string why_not_identifiable(const FrameReadings& data, const RobotModel& robot) {
  if (is_touched(data))
    return why_not_identifiable(
        data, robot, kOrigin, "the TCP touched the point",
        ", which leaves the TCP's place along it open; touch the point with the tool tilted "
        "by 30 deg or more to several sides");
  for (const FramePoint& point : data.points) {
    std::string why =
        why_not_identifiable(data, robot, point.name, "the tracker read point \"" + point.name + '"',
                             ", so the arm's error along it would stay in point \"" + point.name +
                                 "\"; read it with the tool tilted by 30 deg or more to several sides");
    if (!why.empty()) return why;
  }
  return {};
}

std::expected<MeasuredFrame, std::string> tool_frame(const FrameReadings& data, const MeasuringCell& by,
                                                     const Eigen::Matrix3d& R_else) {
  if (is_touched(data)) {
    if (std::string why = why_not_identifiable(data, by.cell.robot); !why.empty())
      return std::unexpected(why);
  }
  std::optional<ToolTurn> turn;
  if (is_turned(data)) {
    if (std::string why = why_not_turned(data); !why.empty()) return std::unexpected(why);
    auto found = tool_turn(data, by);
    if (!found) return std::unexpected(found.error());
    turn = *std::move(found);
  }
  const auto equations_of = [&](const Eigen::VectorXd& step) {
    return tool_equations(data, by, step.size() > 0 ? moved(by.cell, step) : by.cell);
  };
  auto frame = measured_frame(data, equations_of, by.covariance, turn ? turn->R_FT : R_else);
  if (frame && !is_touched(data)) frame->shift = shift_of_base(data, equations_of, by);
  // With it no reading contradicts the others.
  if (frame && frame->shift && frame->shift->is_real()) frame->doubtful.clear();
  if (frame && turn) take_turn(*frame, *turn, by.covariance);
  return frame;
}

RobotModel with_tool(RobotModel calibrated, const Eigen::Isometry3d& X_FT,
                     const Eigen::Isometry3d& X_controller) {
  calibrated.X_flange = calibrated.X_flange * X_FT * inverse_of(X_controller);
  return calibrated;
}

Eigen::Matrix3d tcp_covariance(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                               const JointVector& q, const Eigen::Vector3d& p_F_mm,
                               const MeasuredFrame* tool) {
  CalibratedCell with_tcp = cell;
  with_tcp.reflectors.front().p_FS_mm = p_F_mm;
  PointJacobian J;
  predict_with_jacobian(with_tcp, q, 0, J);
  const Eigen::Index at = ParameterLayout::of(cell).reflector(0);
  const Eigen::Matrix3d R_WF = J.middleCols<3>(at);
  J.middleCols<3>(at).setZero();
  const Eigen::Matrix3d of_field = field_covariance(cell, q, p_F_mm);
  if (!tool) return congruence(J, covariance) + of_field;
  // A point off the tool's origin moves with the tool's rotations.
  Eigen::Matrix<double, 3, 6> by_tool;
  const Eigen::Vector3d off_origin_mm = p_F_mm - tool->X.translation();
  by_tool << R_WF, R_WF * Eigen::Matrix3d::Identity().colwise().cross(off_origin_mm);
  J += times(by_tool, tool->by_parameters);
  return congruence(J, covariance) + of_field + congruence(by_tool, tool->by_readings);
}

}  // namespace truepose
