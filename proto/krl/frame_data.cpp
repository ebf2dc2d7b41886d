#include "proto/krl/frame_data.hpp"

#include "core/math/angles.hpp"
#include "proto/krl/rewrite.hpp"

namespace truepose::krl {
namespace {

/// TOOL_DATA[n]=, BASE_DATA[n]= or MACHINE_FRAME_DAT[n]=.
void read_element(const Assignment& assignment, FrameData& data) {
  const auto& [variable, value] = assignment;
  const bool is_element = variable.kind == ExpressionKind::Element && variable.parts.size() == 2;
  const auto index = is_element ? index_of(variable.parts[1]) : std::nullopt;
  if (!index || value.kind != ExpressionKind::Aggregate) return;
  const std::string& table = variable.root().name;
  if (table == "TOOL_DATA" || table == "BASE_DATA") {
    const auto position = position_of(value, 0);
    if (position && position->form == PositionForm::Cartesian)
      (table == "TOOL_DATA" ? data.tools : data.bases)[*index] = pose_of(*position);
  } else if (const Expression* machine = value.find("MACH_DEF_INDEX");
             table == "MACHINE_FRAME_DAT" && machine && index_of(*machine).value_or(0) > 0) {
    data.moving_bases.insert(*index);
  }
}

}  // namespace

void FrameData::add(const FrameData& more) {
  tools.insert(more.tools.begin(), more.tools.end());
  bases.insert(more.bases.begin(), more.bases.end());
  moving_bases.insert(more.moving_bases.begin(), more.moving_bases.end());
}

std::string frame_statement(std::string_view table, int number, const Eigen::Isometry3d& X,
                            std::string_view member) {
  const Eigen::Vector3d p = X.translation(), abc = kuka_abc_deg(X.linear());
  return std::string(table) + '[' + std::to_string(number) + ']' + std::string(member) + "={X " +
         number_text(p.x()) + ",Y " + number_text(p.y()) + ",Z " + number_text(p.z()) + ",A " +
         number_text(abc.x()) + ",B " + number_text(abc.y()) + ",C " + number_text(abc.z()) + '}';
}

Eigen::Isometry3d pose_of(const Position& position) {
  const auto& v = position.values;
  return pose_from_kuka({v[0].value, v[1].value, v[2].value}, {v[3].value, v[4].value, v[5].value});
}

FrameData frame_data_of(const TextStatements& statements) {
  FrameData data;
  statements.uses.each([&](const ProgramStatement& statement) {
    if (const auto assignment = statement.assignment()) read_element(*assignment, data);
  });
  return data;
}

}  // namespace truepose::krl
