#include "config/target_file.hpp"

#include <algorithm>
#include <initializer_list>

#include "config/measurement_file.hpp"
#include "core/arm/joint_units.hpp"

namespace truepose::config {
namespace {

bool has_any(const CsvHeader& header, std::initializer_list<const char*> names) {
  return std::ranges::any_of(names, [&header](const char* name) { return header.has(name); });
}

TargetForm form_of(const CsvHeader& header, const TargetRules& rules) {
  if (rules.of_joints.value_or(header.has("q1"))) return TargetForm::Joints;
  if (rules.whole_poses_alone || has_any(header, {"a", "b", "c", "s", "t"})) return TargetForm::Poses;
  return TargetForm::Positions;
}

std::vector<std::string> joint_columns(const CsvHeader& header, const RobotModel* arm) {
  if (arm) return joint_column_names("q", *arm);
  std::size_t count = 1;
  while (header.has("q" + std::to_string(count + 1))) ++count;
  return joint_column_names("q", count);
}

/// What a file of targets may have.
TableForm table_form(const TargetRules& rules) {
  const std::vector<std::string> joints =
      rules.arm ? joint_column_names("q", *rules.arm) : joint_column_names("q", kMaxJoints);
  std::vector<std::string> pose{"x", "y", "z"};
  if (rules.whole_poses_alone) pose.insert(pose.end(), {"a", "b", "c"});
  TableForm form{.known = {}, .needed = {}, .robot = rules.arm};
  if (rules.of_joints.value_or(true)) {
    form.known = joints;
    form.known.insert(form.known.end(), kReachColumns.begin(), kReachColumns.end());
    form.needed.push_back(rules.arm ? joints : std::vector<std::string>{"q1"});
  }
  if (!rules.of_joints.value_or(false)) {
    form.known.insert(form.known.end(), {"x", "y", "z", "a", "b", "c", "s", "t"});
    form.needed.push_back(pose);
  }
  const std::vector<std::string> turns =
      rules.table ? joint_column_names("e", *rules.table) : std::vector<std::string>{};
  form.known.insert(form.known.end(), turns.begin(), turns.end());
  return form;
}

std::optional<std::size_t> column_if_there(const CsvHeader& header, std::string_view name) {
  return header.has(name) ? std::optional{header.column(name)} : std::nullopt;
}

}  // namespace

TargetReader::TargetReader(std::istream& in, const std::string& file, const TargetRules& rules)
    : table_(rules.table),
      text_(in, file, table_form(rules), rules.reading),
      rows_(text_.stream(), file, text_.first_line(), text_.taken()),
      form_(form_of(rows_.header(), rules)) {
  const CsvHeader& header = rows_.header();
  std::vector<std::string> names{"x", "y", "z"}, known{"x", "y", "z", "a", "b", "c", "s", "t"};
  if (form_ == TargetForm::Joints) {
    known = names = joint_columns(header, rules.arm);
    known.insert(known.end(), kReachColumns.begin(), kReachColumns.end());
  } else if (form_ == TargetForm::Poses) {
    names.insert(names.end(), {"a", "b", "c"});
  }
  const std::vector<std::string> turns =
      table_ ? joint_column_names("e", *table_) : std::vector<std::string>{};
  known.insert(known.end(), turns.begin(), turns.end());
  header.expect_only(known);
  for (const std::string& name : names) columns_.push_back(header.column(name));
  for (const std::string& name : turns) table_columns_.push_back(header.column(name));
  status_ = column_if_there(header, "s");
  turn_ = column_if_there(header, "t");
  // Passed over, the arm would come to the pose on another branch than the file says.
  if (rules.whole_poses_alone && (status_ || turn_))
    header.fail(
        "columns s and t: here the branch is the one nearest to the target before; leave them out, or give joints");
}

std::optional<TargetRow> TargetReader::next() {
  if (!rows_.next()) return std::nullopt;
  return TargetRow{.numbers = numbers(columns_),
                   .status = bits(status_, 255),
                   .turn = bits(turn_, 4095),
                   .e = table_ ? table_joints() : JointVector{}};
}

std::vector<double> TargetReader::numbers(const std::vector<std::size_t>& columns) const {
  std::vector<double> numbers;
  for (const std::size_t column : columns) numbers.push_back(rows_.number(column));
  return numbers;
}

std::optional<int> TargetReader::bits(std::optional<std::size_t> column, int most) const {
  if (!column) return std::nullopt;
  const double value = rows_.number(*column);
  if (!(value >= 0 && value <= most && value == static_cast<int>(value)))
    rows_.fail(*column, "expected a whole number from 0 to " + std::to_string(most));
  return static_cast<int>(value);
}

JointVector TargetReader::table_joints() const {
  const JointVector e = joints_from(numbers(table_columns_), *table_);
  for (std::size_t i = 0; i < table_columns_.size(); ++i) {
    const Joint& joint = table_->joints[i];
    const double at = e[static_cast<Eigen::Index>(i)];
    if (!(at >= joint.min && at <= joint.max))
      rows_.fail(table_columns_[i], "the positioner does not go there: expected " +
                                        joint_field(joint.min, joint) + ".." + joint_field(joint.max, joint));
  }
  return e;
}

}  // namespace truepose::config
