#include "tools/truepose/offline/imported_robot.hpp"

#include <algorithm>
#include <cctype>

#include "config/robot_text.hpp"

namespace truepose::tools {

bool has_machine_data(const std::filesystem::path& source) {
  std::string extension = source.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::filesystem::is_directory(source) || extension == ".zip" || extension == ".dat";
}

std::string imported_robot_text(const config::ImportedArm& arm, const std::filesystem::path& source) {
  std::vector<std::string> comment{arm.robot.name + ", imported from " + source.filename().string()};
  for (const std::string& note : arm.notes) comment.push_back("  " + note);
  comment.push_back("Modified DH with Hayati's beta; mm, deg, deg/s: see docs/robot-files.md.");
  return config::robot_text(arm.robot, comment);
}

}  // namespace truepose::tools
