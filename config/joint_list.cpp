#include "config/joint_list.hpp"

namespace truepose::config {

std::vector<Joint> joints_value(const YamlValue& joints, Joint (*joint)(const YamlValue&)) {
  if (joints.list().empty() || joints.list().size() > kMaxJoints) {
    joints.fail("expected 1.." + std::to_string(kMaxJoints) + " joints, found " +
                std::to_string(joints.list().size()));
  }
  std::vector<Joint> result;
  for (const YamlValue& value : joints.list()) result.push_back(joint(value));
  return result;
}

}  // namespace truepose::config
