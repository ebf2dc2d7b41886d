#include "tools/truepose/target_reader.hpp"

#include "config/measurement_file.hpp"
#include "core/arm/joint_units.hpp"

namespace truepose::tools {

TargetReader::TargetReader(std::istream& in, const std::string& file, const RobotModel& robot, bool of_joints)
    : robot_(robot), rows_(in, file) {
  const config::CsvHeader& header = rows_.header();
  std::vector<std::string> names, known;
  if (of_joints) {
    form_ = TargetForm::Joints;
    known = names = config::joint_column_names("q", robot);
    known.insert(known.end(), config::kReachColumns.begin(), config::kReachColumns.end());
  } else {
    const bool turns =
        header.has("a") || header.has("b") || header.has("c") || header.has("s") || header.has("t");
    form_ = turns ? TargetForm::Poses : TargetForm::Positions;
    names = {"x", "y", "z"};
    if (turns) names.insert(names.end(), {"a", "b", "c"});
    known = {"x", "y", "z", "a", "b", "c", "s", "t"};
  }
  header.expect_only(known);
  for (const std::string& name : names) columns_.push_back(header.column(name));
  if (header.has("s")) status_ = header.column("s");
  if (header.has("t")) turn_ = header.column("t");
}

std::optional<Target> TargetReader::next() {
  if (!rows_.next()) return std::nullopt;
  Target target{.q = {}, .X = Eigen::Isometry3d::Identity(), .status = {}, .turn = {}};
  if (form_ == TargetForm::Joints) {
    target.q.resize(robot_.joint_count());
    for (std::size_t i = 0; i < columns_.size(); ++i)
      target.q[static_cast<Eigen::Index>(i)] = rows_.number(columns_[i]) * unit_of(robot_.joints[i]);
    return target;
  }
  Eigen::Vector<double, 6> v = Eigen::Vector<double, 6>::Zero();
  for (std::size_t i = 0; i < columns_.size(); ++i)
    v[static_cast<Eigen::Index>(i)] = rows_.number(columns_[i]);
  target.X = pose_from_kuka(v.head<3>(), v.tail<3>());
  if (status_) target.status = bits(*status_, 255);
  if (turn_) target.turn = bits(*turn_, 4095);
  return target;
}

int TargetReader::bits(std::size_t column, int most) const {
  const double value = rows_.number(column);
  if (!(value >= 0 && value <= most && value == static_cast<int>(value)))
    rows_.fail(column, "expected a whole number from 0 to " + std::to_string(most));
  return static_cast<int>(value);
}

}  // namespace truepose::tools
