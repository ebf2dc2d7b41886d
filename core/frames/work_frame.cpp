#include "core/frames/work_frame.hpp"

#include "core/arm/forward.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// Unknowns: each point in the robot base.
///
/// Both kinds of reading are taken where the tracker has them. Only a convention separates base and link 1,
/// and with few poses further parameters. The uncertainty of a touched point in the arm's own base would
/// include that convention. Neither the tracker nor a program sees it, since the program uses the same model.
std::vector<PointEquation> work_equations(const FrameReadings& data, const MeasuringCell& by,
                                          const CalibratedCell& cell, const Eigen::Vector3d& p_F_mm) {
  const Eigen::Isometry3d X_BW = inverse_of(by.cell.base.isometry());
  std::vector<PointEquation> result;
  for (const FrameReading& reading : data.readings) {
    const auto touched_mm = [&] {
      return cell.base.isometry() * (forward_kinematics(cell.robot, reading.q) * p_F_mm);
    };
    PointEquation equation{.A = Eigen::MatrixXd::Zero(3, 3 * static_cast<Eigen::Index>(data.points.size())),
                           .b = X_BW * (reading.p_WS_mm ? *reading.p_WS_mm : touched_mm()),
                           .covariance = covariance_in_base(reading, by)};
    equation.A.middleCols<3>(3 * static_cast<Eigen::Index>(reading.point)).setIdentity();
    result.push_back(equation);
  }
  return result;
}

/// A step's head is of the cell's parameters, its tail of the TCP.
Eigen::MatrixXd with_tcp(const MeasuringCell& by, const TouchingTool& tool) {
  const Eigen::Index parameters = by.covariance.cols();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(parameters + 3, parameters + 3);
  covariance.topLeftCorner(parameters, parameters) = by.covariance;
  if (tool.measured) covariance.bottomRightCorner<3, 3>() = tool.measured->by_readings.topLeftCorner<3, 3>();
  return covariance;
}

}  // namespace

std::expected<MeasuredFrame, std::string> work_frame(const FrameReadings& data, const MeasuringCell& by,
                                                     const TouchingTool& tool) {
  const Eigen::Index parameters = by.covariance.cols();
  const auto equations_of = [&](const Eigen::VectorXd& step) {
    const Eigen::VectorXd of_cell = step.head(parameters);
    Eigen::Vector3d p_F_mm = tool.p_F_mm + step.tail<3>();
    if (tool.measured) p_F_mm += times(tool.measured->by_parameters.topRows<3>(), of_cell);
    return work_equations(data, by, parameters > 0 ? moved(by.cell, of_cell) : by.cell, p_F_mm);
  };
  const Eigen::MatrixXd covariance = with_tcp(by, tool);
  auto frame = measured_frame(data, equations_of, covariance);
  if (!frame) return frame;
  const Eigen::Matrix<double, 6, 3> by_tcp = frame->by_parameters.rightCols<3>();
  frame->by_readings += by_tcp * covariance.bottomRightCorner<3, 3>() * by_tcp.transpose();
  frame->by_parameters.conservativeResize(6, parameters);
  return frame;
}

}  // namespace truepose
