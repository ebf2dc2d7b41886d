#include "config/robot_fix.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "config/number_text.hpp"
#include "config/robot_file.hpp"
#include "config/robot_library.hpp"
#include "config/robot_text.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/angles.hpp"

namespace truepose::config {
namespace {

/// Of a value that was multiplied by the radians of a degree: less is rounding.
constexpr double kStep = 1e-9, kPerUnit = 1e9;

std::string number_text(double value) { return format_number(std::round(value * kPerUnit) / kPerUnit + 0.0); }

/// Changes of a text at places of its YAML, made from the last to the first.
class Edits {
 public:
  explicit Edits(std::string text) : text_{std::move(text)} {
    for (std::size_t at = 0; at != std::string::npos; at = text_.find('\n', at)) {
      if (at > 0) ++at;
      lines_.push_back(at);
    }
  }

  void replace(const YamlValue& value, const std::string& by) {
    edits_.insert_or_assign(offset(value.place()), Edit{value.text().size(), by});
  }
  /// "key: value" before the first member of a map.
  void insert(const YamlValue& map, const std::string& entry) {
    const std::size_t first = offset(map.values().front().key_place());
    const bool is_flow = text_[offset(map.place())] == '{';
    const std::size_t indent = first - text_.rfind('\n', first) - 1;
    add(first, entry + (is_flow ? ", " : "\n" + std::string(indent, ' ')));
  }
  /// A line of its own before a member of the file, or at its end.
  void insert_line(const YamlValue* before, const std::string& line) {
    if (before) return add(offset(before->key_place()), line + "\n");
    add(text_.size(), (text_.ends_with('\n') ? "" : "\n") + line + "\n");
  }
  void insert_element(const YamlValue& list, const std::string& element) {
    add(offset(list.list().front().place()), element + ", ");
  }

  std::string text() const {
    std::string edited = text_;
    for (auto edit = edits_.rbegin(); edit != edits_.rend(); ++edit)
      edited.replace(edit->first, edit->second.length, edit->second.by);
    return edited;
  }

 private:
  struct Edit {
    std::size_t length = 0;
    std::string by;
  };

  std::size_t offset(YamlPlace place) const {
    return lines_[static_cast<std::size_t>(place.line - 1)] + static_cast<std::size_t>(place.column - 1);
  }
  void add(std::size_t at, const std::string& text) { edits_[at].by += text; }

  std::string text_;
  std::vector<std::size_t> lines_;
  std::map<std::size_t, Edit> edits_;
};

/// The numbers of a joint's row, as the file says them.
std::vector<std::pair<std::string, double>> numbers_of(const Joint& joint) {
  return {{"a", joint.a_mm},
          {"alpha", joint.alpha_rad * kDegPerRad},
          {"d", joint.d_mm},
          {"theta", joint.theta_rad * kDegPerRad},
          {"beta", joint.beta_rad * kDegPerRad},
          {"sign", joint.sign},
          {"min", joint.min / unit_of(joint)},
          {"max", joint.max / unit_of(joint)}};
}

std::vector<std::pair<std::string, double>> numbers_of(const Eigen::Isometry3d& X) {
  const Eigen::Vector3d p = X.translation(), abc = kuka_abc_deg(X.linear());
  return {{"x", p.x()}, {"y", p.y()}, {"z", p.z()}, {"a", abc.x()}, {"b", abc.y()}, {"c", abc.z()}};
}

template <typename Part>
void change(Edits& edits, const YamlValue& map, const Part& from, const Part& to) {
  const auto before = numbers_of(from), after = numbers_of(to);
  for (std::size_t k = 0; k < after.size(); ++k) {
    const auto& [key, value] = after[k];
    if (std::abs(value - before[k].second) <= kStep) continue;
    if (const YamlValue* there = map.find(key)) {
      edits.replace(*there, number_text(value));
    } else {
      edits.insert(map, key + ": " + number_text(value));
    }
  }
}

std::string flange_text(const Eigen::Isometry3d& X) {
  std::string text;
  for (const auto& [key, value] : numbers_of(X))
    text += (text.empty() ? "flange: {" : ", ") + key + ": " + number_text(value);
  return text + "}";
}

void change_couplings(Edits& edits, const YamlValue& root, const RobotModel& from, const RobotModel& to) {
  for (const JointCoupling& each : to.coupling) {
    if (std::ranges::find(from.coupling, each) != from.coupling.end()) continue;
    if (const YamlValue* there = root.find("coupling")) {
      edits.insert_element(*there, coupling_text(each));
    } else {
      edits.insert_line(root.find("flange"), "coupling: [" + coupling_text(each) + "]");
    }
  }
}

bool is_same(const RobotModel& a, const RobotModel& b) {
  const auto close = [](const auto& x, const auto& y) {
    return std::ranges::equal(numbers_of(x), numbers_of(y), [](const auto& one, const auto& other) {
      return std::abs(one.second - other.second) <= 2 * kStep;
    });
  };
  return std::ranges::equal(a.joints, b.joints, close) && a.coupling == b.coupling &&
         a.X_flange.isApprox(b.X_flange, kStep);
}

}  // namespace

std::string robot_place(const std::filesystem::path& file, int joint, std::string_view key) {
  const YamlValue root = read_yaml(robot_file_of(file));
  if (const YamlValue* const own = root.find(key)) return own->where();
  const YamlValue* const joints = root.find("joints");
  if (!joints || joints->list().empty()) return root.where();
  const YamlValue& row = joints->list()[static_cast<std::size_t>(std::max(joint, 0))];
  if (const YamlValue* const there = row.find(key)) return there->where();
  return joint < 0 ? joints->where() : row.where();
}

std::string fixed_robot_text(const std::filesystem::path& file, const RobotModel& fixed) {
  const std::string text = read_text_file(robot_file_of(file), kMostBytesOfYaml);
  const RobotModel given = parse_robot(text, file.string());
  const YamlValue root = parse_yaml(text, file.string());
  Edits edits(text);
  const std::vector<YamlValue>& rows = root.find("joints")->list();
  for (std::size_t i = 0; i < rows.size(); ++i) change(edits, rows[i], given.joints[i], fixed.joints[i]);
  if (const YamlValue* flange = root.find("flange")) {
    change(edits, *flange, given.X_flange, fixed.X_flange);
  } else if (!given.X_flange.isApprox(fixed.X_flange, kStep)) {
    edits.insert_line(nullptr, flange_text(fixed.X_flange));
  }
  change_couplings(edits, root, given, fixed);
  std::string edited = edits.text();
  if (!is_same(parse_robot(edited, file.string()), fixed)) {
    throw ConfigError(file.string() +
                      ": cannot be changed in place: write out what it says by aliases, then try again");
  }
  return edited;
}

}  // namespace truepose::config
