#include "proto/krl/frame_state.hpp"

namespace truepose::krl {
namespace {

using State = FrameValue::State;

FrameValue started(const std::optional<Eigen::Isometry3d>& X) {
  return X ? FrameValue{.state = State::Known, .X = *X, .set = {}} : FrameValue{};
}

}  // namespace

bool FrameSettings::add(const FrameSettings& others) {
  const bool is_new = (!tool && others.tool) || (!base && others.base);
  if (!tool) tool = others.tool;
  if (!base) base = others.base;
  return is_new;
}

FrameSettings settings_of(const ProgramStatement& statement, std::size_t file) {
  if (statement.action.empty()) return {};
  const Token& name = statement.action[0];
  const auto set = [spot = Spot{file, name.at}](bool tool, bool base) {
    return FrameSettings{tool ? std::optional(spot) : std::nullopt,
                         base ? std::optional(spot) : std::nullopt};
  };
  if (const auto bas = statement.bas()) {
    if (bas->parts.empty()) return {};
    const Token& what = bas->parts[0].token;
    return set(what.is_any_of({"#INITMOV", "#TOOL"}), what.is_any_of({"#INITMOV", "#BASE", "#EX_BASE"}));
  }
  const bool both = name.is_any_of({"FDAT_ACT", "$IPO_MODE"});
  const FrameSettings settings = set(both || name.is("$TOOL"), both || name.is("$BASE"));
  return settings && statement.assignment() ? settings : FrameSettings{};
}

FrameState::FrameState(const Variables& variables, const FrameData& data, const StartFrames& start)
    : variables_{variables}, data_{data} {
  given_ = now_ = started_ = {.tool = add(started(start.tool)), .base = add(started(start.base))};
}

void FrameState::begin(std::size_t file, std::string_view module, const FrameSettings& interrupts) {
  file_ = file;
  scope_ = {module};
  interrupts_ = interrupts;
  numbered_.clear();
  now_ = given_;
  unsettle(interrupts);
  started_ = now_;
}

void FrameState::unsettle(const FrameSettings& settings) {
  if (settings.tool) now_.tool = add({.state = State::Unordered, .set = *settings.tool});
  if (settings.base) now_.base = add({.state = State::Unordered, .set = *settings.base});
}

void FrameState::set(Kind kind, std::size_t frame) {
  const bool is_tool = kind == Kind::Tool;
  if (is_tool ? interrupts_.tool : interrupts_.base) return;
  (is_tool ? now_.tool : now_.base) = frame;
}

std::size_t FrameState::add(const FrameValue& value) {
  frames_.push_back(value);
  return frames_.size() - 1;
}

void FrameState::start_routine(std::size_t number) {
  scope_.routine = number;
  start();
}

/// What BAS(#INITMOV) sets is up to the cell's own BAS, so what was given for the start of a routine holds
/// again, and without it nothing is known.
void FrameState::start() { now_ = started_; }

void FrameState::carry_out(const ProgramStatement& statement) {
  if (statement.is_later()) return;
  if (const auto bas = statement.bas()) carry_out_bas(*bas);
  if (const auto assignment = statement.assignment()) carry_out(*assignment);
}

void FrameState::carry_out(const std::vector<Assignment>& settings) {
  for (const Assignment& setting : settings) carry_out(setting);
}

void FrameState::carry_out(const Assignment& assignment) {
  const auto& [variable, value] = assignment;
  // A component alone ($BASE.X=, FDAT_ACT.TOOL_NO=) leaves a value that cannot be evaluated.
  const bool is_whole = variable.kind == ExpressionKind::Name;
  const bool tool = variable.token.is("$TOOL"), base = variable.token.is("$BASE");
  if (tool || base) {
    const Kind kind = tool ? Kind::Tool : Kind::Base;
    set(kind, is_whole ? value_of(kind, value) : numbered(kind, std::nullopt, spot_of(variable)));
  } else if (variable.token.is("FDAT_ACT")) {
    set_motion_data(is_whole ? motion_data(value) : std::nullopt, spot_of(variable));
  } else if (variable.token.is("$IPO_MODE")) {
    const bool is_of_data =
        value.kind == ExpressionKind::Call && !value.parts.empty() && value.parts[0].is_variable();
    const auto data = is_of_data ? motion_data(value.parts[0].root()) : std::nullopt;
    now_.fixed_tool = data ? data->fixed_tool : value.token.is("#TCP");
  }
}

void FrameState::carry_out_bas(const Expression& call) {
  if (call.parts.empty()) return;
  const Expression& what = call.parts[0];
  const auto set_numbered = [&](Kind kind) {
    const bool has_number = call.parts.size() == 2 && !what.token.is("#EX_BASE");
    set(kind, numbered(kind, has_number ? number(kind, call.parts[1]) : std::nullopt, spot_of(what)));
  };
  if (what.token.is("#INITMOV")) start();
  if (what.token.is("#TOOL")) set_numbered(Kind::Tool);
  if (what.token.is_any_of({"#BASE", "#EX_BASE"})) set_numbered(Kind::Base);
}

void FrameState::set_motion_data(const std::optional<MotionData>& data, Spot spot) {
  const MotionData its = data.value_or(MotionData{});
  set(Kind::Tool, numbered(Kind::Tool, its.tool, spot));
  set(Kind::Base, numbered(Kind::Base, its.base, spot));
  now_.fixed_tool = its.fixed_tool;
}

std::size_t FrameState::value_of(Kind kind, const Expression& expression) {
  const Spot spot = spot_of(expression);
  const auto known = [&](const Position& position) {
    return add({.state = State::Known, .X = pose_of(position), .set = spot});
  };
  const Token& first = expression.token;
  if (expression.kind == ExpressionKind::Aggregate) {
    const auto position = position_of(expression, file_);
    if (position && position->form == PositionForm::Cartesian) return known(*position);
  } else if (expression.kind == ExpressionKind::Name) {
    if (first.is_any_of({"$NULLFRAME", "$WORLD"})) return numbered(kind, 0, spot);
    const Variable* variable = find(expression);
    if (variable && variable->type == VariableType::Frame && !variable->hindrance) {
      const auto* position = std::get_if<Position>(&variable->value);
      if (position && position->form == PositionForm::Cartesian) return known(*position);
    }
  } else if (expression.kind == ExpressionKind::Element && expression.parts.size() == 2 &&
             first.is_any_of({"TOOL_DATA", "BASE_DATA"})) {
    const Kind table = first.is("TOOL_DATA") ? Kind::Tool : Kind::Base;
    return numbered(table, number(table, expression.parts[1]), spot);
  } else if (expression.kind == ExpressionKind::Call && expression.parts.size() == 1 &&
             first.is_any_of({"STOOL2", "STOOL", "SBASE"})) {
    return numbered(kind, number(kind, expression.parts[0]), spot);
  }
  return numbered(kind, std::nullopt, spot);
}

const Variable* FrameState::find(const Expression& name) const {
  const auto index = variables_.find(name.name, scope_);
  return index ? &variables_.all()[*index] : nullptr;
}

std::optional<MotionData> FrameState::motion_data(const Expression& expression) const {
  if (expression.kind == ExpressionKind::Aggregate) return motion_data_of(expression);
  const Variable* variable = expression.kind == ExpressionKind::Name ? find(expression) : nullptr;
  const auto* data = variable ? std::get_if<MotionData>(&variable->value) : nullptr;
  return data && !variable->hindrance ? std::optional(*data) : std::nullopt;
}

std::optional<int> FrameState::number(Kind kind, const Expression& expression) const {
  // FP1.TOOL_NO says no more than FP1.
  const bool is_component = expression.kind == ExpressionKind::Component;
  if (is_component && expression.name != (kind == Kind::Tool ? "TOOL_NO" : "BASE_NO")) return std::nullopt;
  if (const auto data = motion_data(is_component ? expression.parts[0] : expression))
    return kind == Kind::Tool ? data->tool : data->base;
  return index_of(expression);
}

std::size_t FrameState::numbered(Kind kind, std::optional<int> number, Spot spot) {
  if (!number || *number < 0) return add({.state = State::Computed, .set = spot});
  const auto [entry, is_new] = numbered_.emplace(std::pair{kind, *number}, frames_.size());
  if (!is_new) return entry->second;
  const auto& table = kind == Kind::Tool ? data_.tools : data_.bases;
  FrameValue value{.state = State::NoData, .number = *number, .set = spot};
  if (*number == 0) {
    value.state = State::Known;
  } else if (kind == Kind::Base && data_.moving_bases.contains(*number)) {
    value.state = State::Moving;
  } else if (const auto written = variables_.frame_written(
                 scope_.module, kind == Kind::Tool ? "TOOL_DATA" : "BASE_DATA", *number)) {
    value.state = State::Written;
    value.set = *written;
  } else if (const auto found = table.find(*number); found != table.end()) {
    value.state = State::Known;
    value.X = found->second;
  }
  return add(value);
}

}  // namespace truepose::krl
