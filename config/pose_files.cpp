#include "config/pose_files.hpp"

#include "config/csv_reader.hpp"
#include "config/joint_columns.hpp"

namespace truepose::config {

std::vector<JointVector> load_joints(const std::filesystem::path& file, const RobotModel& robot) {
  const CsvTable table = CsvTable::read(file);
  std::vector<std::string> known = joint_column_names("q", robot);
  known.insert(known.end(), kReachColumns.begin(), kReachColumns.end());
  table.expect_only(known);
  const JointColumns columns(table, robot);
  std::vector<JointVector> joints;
  for (std::size_t row = 0; row < table.row_count(); ++row) joints.push_back(columns.at(row));
  return joints;
}

void write_joints(std::ostream& out, const std::vector<JointVector>& joints, const RobotModel& robot) {
  const std::vector<std::string> names = joint_column_names("q", robot);
  for (std::size_t i = 0; i < names.size(); ++i) out << (i ? "," : "") << names[i];
  out << '\n';
  for (const JointVector& q : joints) {
    for (int i = 0; i < robot.joint_count(); ++i) {
      out << (i ? "," : "") << joint_field(q[i], robot.joints[static_cast<std::size_t>(i)]);
    }
    out << '\n';
  }
}

}  // namespace truepose::config
