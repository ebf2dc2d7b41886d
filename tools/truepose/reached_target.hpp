#pragma once

#include <boost/json/fwd.hpp>
#include <iosfwd>
#include <optional>

#include "core/compensate/target_compensation.hpp"
#include "tools/report/report.hpp"

namespace truepose::tools {

/// What became of a target.
struct ReachedTarget {
  JointVector q_nominal;
  CompensatedTarget compensated;
  std::optional<double> sigma_mm;  ///< of the position where the arm will stand
};

/// Which columns there are beside the joints and residual_mm.
struct ReachColumns {
  bool orientation = true, sigma = false;
};

void write_csv_header(std::ostream& out, const RobotModel& robot, const ReachColumns& columns);
void write_csv_row(std::ostream& out, const RobotModel& robot, const ReachedTarget& target,
                   const ReachColumns& columns);

/// {"joints","residual_mm","residual_deg","sigma_mm","iterations","damped"}, an array each, deg and mm.
boost::json::object empty_document(const ReachColumns& columns);
void append(boost::json::object& document, const RobotModel& robot, const ReachedTarget& target);

/// A row of the report, deg and mm.
report::CompensationRow report_row(const RobotModel& robot, const ReachedTarget& target);

}  // namespace truepose::tools
