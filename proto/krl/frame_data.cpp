#include "proto/krl/frame_data.hpp"

#include "core/math/angles.hpp"
#include "proto/krl/rewrite.hpp"

namespace truepose::krl {
namespace {

/// `NAME[n]={...}` with a number n.
struct Element {
  int index = 0;
  Aggregate value;
};

std::expected<std::optional<Element>, Fault> read_element(Tokens statement) {
  std::optional<Element> none;
  if (statement.size() < 6 || !statement[1].is('[') || !statement[3].is(']') || !statement[4].is('=') ||
      !statement[5].is('{')) {
    return none;
  }
  const auto index = read_number(statement.subspan(2, 1));
  if (!index) return std::unexpected(index.error());
  if (!*index || (*index)->value < 0 || (*index)->value > 1e6) return none;
  std::size_t next = 5;
  auto value = read_aggregate(statement, next);
  if (!value) return std::unexpected(value.error());
  return Element{static_cast<int>((*index)->value), std::move(*value)};
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

std::expected<FrameData, Fault> read_frame_data(std::string_view text) {
  FrameData data;
  StatementReader reader(text);
  while (true) {
    const auto statement = reader.next();
    if (!statement) return std::unexpected(statement.error());
    if (statement->empty()) return data;
    const Token& name = statement->front();
    const bool is_tool = name.is("TOOL_DATA"), is_base = name.is("BASE_DATA");
    if (!is_tool && !is_base && !name.is("MACHINE_FRAME_DAT")) continue;
    const auto element = read_element(*statement);
    if (!element) return std::unexpected(element.error());
    if (!*element) continue;
    const auto& [index, value] = **element;
    if (is_tool || is_base) {
      const auto position = position_of(value, 0);
      if (position && position->form == PositionForm::Cartesian)
        (is_tool ? data.tools : data.bases)[index] = pose_of(*position);
    } else if (const Field* machine = value.find("MACH_DEF_INDEX");
               machine && machine->number && machine->number->value > 0) {
      data.moving_bases.insert(index);
    }
  }
}

}  // namespace truepose::krl
