#pragma once

#include <Eigen/Geometry>
#include <boost/json.hpp>
#include <string>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

/// The reference values of tests/golden (50-digit arithmetic; README.md there: their source).
namespace truepose::golden {

boost::json::object load(const std::string& name);

double number(const boost::json::value& value);
Eigen::VectorXd vector(const boost::json::value& value);
Eigen::MatrixXd matrix(const boost::json::value& value);

/// An arm from `links` (6 x 5: a, alpha, d, theta0, beta) and `sign`, with the limits of the KR 210 R2700-2.
RobotModel robot(const boost::json::value& links, const boost::json::value& sign);

/// The arm with a base [px, py, pz, rx, ry, rz] and one reflector.
CalibratedCell cell(const RobotModel& robot, const boost::json::value& base, const boost::json::value& tool);

/// One of the data sets of "identify" and what its fit must give.
struct DataSet {
  boost::json::object expected;
  MeasurementData data;
};
/// @param validation  key of the validation points: "measured", or "true" without noise
DataSet data_set(const boost::json::object& identify, std::size_t index, const char* validation);
RobotModel nominal(const boost::json::object& identify);  ///< the arm that the fits start from

}  // namespace truepose::golden
