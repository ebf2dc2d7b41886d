#include "config/field_yaml.hpp"

#include "config/number_text.hpp"
#include "config/ranges.hpp"
#include "config/yaml_poses.hpp"
#include "config/yaml_text.hpp"

namespace truepose::config {

namespace {

template <typename Numbers>
std::string row_text(const Numbers& numbers) {
  std::string text = "[";
  for (const double number : numbers) {
    if (text.size() > 1) text += ", ";
    text += format_number(number);
  }
  return text + "]";
}

std::string matrix_text(const Eigen::MatrixXd& A, const std::string& indent) {
  std::string text;
  for (Eigen::Index i = 0; i < A.rows(); ++i) text += indent + "  - " + row_text(A.row(i)) + "\n";
  return text;
}

std::string hyper_text(const std::map<std::string, double>& hyper) {
  std::string text;
  for (const auto& [name, number] : hyper) {
    if (!text.empty()) text += ", ";
    text += name + ": " + format_number(number);
  }
  return "{" + text + "}";
}

RegressorKind kind_value(const YamlValue& value) {
  if (const auto kind = regressor_kind(value.text())) return *kind;
  std::string all;
  for (const RegressorKind kind : kAllRegressors)
    all += (all.empty() ? "" : ", ") + std::string(name_of(kind));
  value.fail("expected one of " + all + ", found '" + value.text() + "'");
}

/// Rows of the same number of columns, which is one of `columns`.
Eigen::MatrixXd matrix_value(const YamlValue& value, std::initializer_list<int> columns) {
  const std::vector<YamlValue>& rows = value.list();
  if (rows.empty()) value.fail("expected at least one row");
  const std::size_t cols = rows.front().list().size();
  std::string expected;
  bool fits = false;
  for (const int count : columns) {
    fits = fits || cols == static_cast<std::size_t>(count);
    expected += (expected.empty() ? "" : " or ") + std::to_string(count);
  }
  if (!fits) rows.front().fail("expected " + expected + " numbers, found " + std::to_string(cols));

  Eigen::MatrixXd A(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(cols));
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const YamlValue& row = rows[static_cast<std::size_t>(i)];
    if (row.list().size() != cols) {
      row.fail("expected " + std::to_string(cols) + " numbers as in the first row, found " +
               std::to_string(row.list().size()));
    }
    for (Eigen::Index k = 0; k < A.cols(); ++k)
      A(i, k) = row.list()[static_cast<std::size_t>(k)].number(kAny);
  }
  return A;
}

}  // namespace

std::string field_text(const RegressionField& field, const std::string& indent) {
  const RegressorState state = field.regressor()->state();
  std::string text = indent + "kind: " + std::string(name_of(state.kind)) + "\n" + indent + "point: {" +
                     xyz_text(field.p_F_mm()) + "}\n" + indent + "hyper: " + hyper_text(state.hyper) + "\n";
  text += indent + "x:\n" + matrix_text(state.X, indent);
  text += indent + "y:\n" + matrix_text(state.Y, indent);
  if (!state.weights.empty()) text += indent + "weights: " + row_text(state.weights) + "\n";
  return text;
}

std::shared_ptr<const RegressionField> field_value(const YamlValue& value, const RobotModel& robot) {
  const YamlMap map(value, {"kind", "point", "hyper", "x", "y", "weights"});
  RegressorState state;
  state.kind = kind_value(map.at("kind"));
  const Eigen::Vector3d p_F_mm = point_value(map.at("point"));
  state.hyper = map.at("hyper").numbers(kAny);
  state.X = matrix_value(map.at("x"), {field_features(robot)});
  state.Y = matrix_value(map.at("y"), {3, 6});
  if (const YamlValue* weights = map.find("weights")) {
    for (const YamlValue& weight : weights->list()) state.weights.push_back(weight.number(kAny));
  }
  const auto regressor = restore_regressor(state);
  if (!regressor) value.fail(regressor.error());
  return std::make_shared<RegressionField>(robot, *regressor, p_F_mm);
}

}  // namespace truepose::config
