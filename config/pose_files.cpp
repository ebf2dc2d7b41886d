#include "config/pose_files.hpp"

#include "config/csv_reader.hpp"
#include "config/joint_columns.hpp"

namespace truepose::config {

std::vector<JointVector> load_joints(const std::filesystem::path& file, const RobotModel& robot) {
  const CsvTable table = CsvTable::read(file);
  table.expect_only(joint_column_names("q", robot));
  const JointColumns columns(table, robot);
  std::vector<JointVector> joints;
  for (std::size_t row = 0; row < table.row_count(); ++row) joints.push_back(columns.at(row));
  return joints;
}

std::vector<Eigen::Isometry3d> load_poses(const std::filesystem::path& file) {
  const CsvTable table = CsvTable::read(file);
  table.expect_only({"x", "y", "z", "a", "b", "c"});
  const std::size_t x = table.column("x"), y = table.column("y"), z = table.column("z");
  const std::size_t a = table.column("a"), b = table.column("b"), c = table.column("c");
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    poses.push_back(pose_from_kuka({table.number(row, x), table.number(row, y), table.number(row, z)},
                                   {table.number(row, a), table.number(row, b), table.number(row, c)}));
  }
  return poses;
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
