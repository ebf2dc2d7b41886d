#include "tools/truepose/reached_target.hpp"

#include <boost/json.hpp>
#include <ostream>

#include "config/measurement_file.hpp"
#include "config/number_text.hpp"
#include "core/arm/joint_units.hpp"
#include "proto/record/arm_document.hpp"

namespace truepose::tools {

namespace json = boost::json;

void write_csv_header(std::ostream& out, const RobotModel& robot, const ReachColumns& columns) {
  for (const std::string& name : config::joint_column_names("q", robot)) out << name << ',';
  out << "residual_mm" << (columns.orientation ? ",residual_deg" : "") << (columns.sigma ? ",sigma_mm" : "")
      << '\n';
}

void write_csv_row(std::ostream& out, const RobotModel& robot, const ReachedTarget& target,
                   const ReachColumns& columns) {
  const CompensatedTarget& reached = target.compensated;
  for (std::size_t i = 0; i < robot.joints.size(); ++i)
    out << config::joint_field(reached.q[static_cast<Eigen::Index>(i)], robot.joints[i]) << ',';
  out << config::format_number(reached.residual_mm);
  if (columns.orientation) out << ',' << config::format_number(reached.residual_rad * kDegPerRad);
  if (target.sigma_mm) out << ',' << config::format_number(*target.sigma_mm);
  out << '\n';
}

json::object empty_document(const ReachColumns& columns) {
  json::object document{
      {"joints", json::array{}}, {"residual_mm", json::array{}}, {"iterations", json::array{}}};
  if (columns.orientation) {
    document["residual_deg"] = json::array{};
    document["damped"] = json::array{};
  }
  if (columns.sigma) document["sigma_mm"] = json::array{};
  return document;
}

void append(json::object& document, const RobotModel& robot, const ReachedTarget& target) {
  const CompensatedTarget& reached = target.compensated;
  const auto add = [&](const char* name, json::value value) {
    if (json::value* column = document.if_contains(name)) column->as_array().push_back(std::move(value));
  };
  add("joints", record::joints_json(reached.q, robot));
  add("residual_mm", reached.residual_mm);
  add("iterations", reached.iterations);
  add("residual_deg", reached.residual_rad * kDegPerRad);
  add("damped", reached.damped);
  if (target.sigma_mm) add("sigma_mm", *target.sigma_mm);
}

report::CompensationRow report_row(const RobotModel& robot, const ReachedTarget& target) {
  report::CompensationRow row{.residual_mm = target.compensated.residual_mm,
                              .residual_deg = target.compensated.residual_rad * kDegPerRad,
                              .sigma_mm = target.sigma_mm,
                              .damped = target.compensated.damped,
                              .corrections = in_deg_mm(target.compensated.q - target.q_nominal, robot)};
  return row;
}

}  // namespace truepose::tools
