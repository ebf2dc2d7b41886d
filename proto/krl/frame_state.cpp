#include "proto/krl/frame_state.hpp"

#include <algorithm>
#include <cmath>

namespace truepose::krl {
namespace {

using State = FrameValue::State;

/// What stands between the bracket at `open` and the statement's last token; none where that closes nothing.
Tokens bracketed(Tokens tokens, std::size_t open) {
  if (tokens.size() < open + 2 || !tokens[open].is('(') || !tokens.back().is(')')) return {};
  return tokens.subspan(open + 1, tokens.size() - open - 2);
}

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

FrameSettings settings_of(Tokens statement, std::size_t file) {
  if (statement.empty()) return {};
  const auto set = [spot = Spot{file, statement[0].at}](bool tool, bool base) {
    return FrameSettings{tool ? std::optional(spot) : std::nullopt,
                         base ? std::optional(spot) : std::nullopt};
  };
  const Token& first = statement[0];
  if (first.is("BAS")) {
    const Tokens arguments = bracketed(statement, 1);
    if (arguments.empty()) return {};
    const Token& what = arguments[0];
    const bool both = what.is("#INITMOV");
    return set(both || what.is("#TOOL"), both || what.is("#BASE") || what.is("#EX_BASE"));
  }
  const std::size_t end = end_of_variable(statement, 0);
  if (end >= statement.size() || !statement[end].is('=')) return {};
  const bool both = first.is("FDAT_ACT") || first.is("$IPO_MODE");
  return set(both || first.is("$TOOL"), both || first.is("$BASE"));
}

FrameState::FrameState(const Variables& variables, const FrameData& data, const StartFrames& start)
    : variables_{variables}, data_{data} {
  given_ = now_ = started_ = {.tool = add(started(start.tool)), .base = add(started(start.base))};
}

void FrameState::begin(std::size_t file, std::string_view module, const FrameSettings& interrupts) {
  file_ = file;
  module_ = module;
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

std::expected<void, Fault> FrameState::carry_out(Tokens statement, std::size_t routine) {
  if (statement.empty()) return {};
  if (statement[0].is("BAS")) {
    carry_out_bas(bracketed(statement, 1), routine);
    return {};
  }
  const bool tool = statement[0].is("$TOOL"), base = statement[0].is("$BASE"),
             data = statement[0].is("FDAT_ACT"), mode = statement[0].is("$IPO_MODE");
  if (!tool && !base && !data && !mode) return {};
  const std::size_t end = end_of_variable(statement, 0);
  if (end >= statement.size() || !statement[end].is('=')) return {};
  // A component alone ($BASE.X=, FDAT_ACT.TOOL_NO=) leaves a value that cannot be evaluated.
  const Tokens value = end == 1 ? statement.subspan(2) : Tokens{};
  const Spot spot = spot_of(statement);
  if (data) {
    set_motion_data(value, spot, routine);
  } else if (mode) {
    const Tokens argument = bracketed(value, 1);
    const auto of_data = motion_data(argument.first(std::min(argument.size(), 1UZ)), routine);
    now_.fixed_tool = of_data ? of_data->fixed_tool : value.size() == 1 && value[0].is("#TCP");
  } else {
    const Kind kind = tool ? Kind::Tool : Kind::Base;
    const auto frame = value.empty() ? numbered(kind, std::nullopt, spot) : value_of(kind, value, routine);
    if (!frame) return std::unexpected(frame.error());
    set(kind, *frame);
  }
  return {};
}

std::expected<void, Fault> FrameState::carry_out_list(Tokens assignments, std::size_t routine) {
  int depth = 0;
  std::size_t from = 0;
  for (std::size_t i = 0; i <= assignments.size(); ++i) {
    if (i < assignments.size()) {
      const Token& token = assignments[i];
      if (token.opens()) ++depth;
      if (token.closes()) --depth;
      if (depth > 0 || !token.is(',')) continue;
    }
    if (const auto done = carry_out(assignments.subspan(from, i - from), routine); !done) return done;
    from = i + 1;
  }
  return {};
}

void FrameState::carry_out_bas(Tokens arguments, std::size_t routine) {
  if (arguments.empty()) return;
  const Spot spot = spot_of(arguments);
  const Tokens value = arguments.size() > 2 ? arguments.subspan(2) : Tokens{};
  if (arguments[0].is("#INITMOV")) start();
  if (arguments[0].is("#TOOL"))
    set(Kind::Tool, numbered(Kind::Tool, number(Kind::Tool, value, routine), spot));
  if (arguments[0].is("#BASE"))
    set(Kind::Base, numbered(Kind::Base, number(Kind::Base, value, routine), spot));
  if (arguments[0].is("#EX_BASE")) set(Kind::Base, numbered(Kind::Base, std::nullopt, spot));
}

void FrameState::set_motion_data(Tokens expression, Spot spot, std::size_t routine) {
  const MotionData data = motion_data(expression, routine).value_or(MotionData{});
  set(Kind::Tool, numbered(Kind::Tool, data.tool, spot));
  set(Kind::Base, numbered(Kind::Base, data.base, spot));
  now_.fixed_tool = data.fixed_tool;
}

std::expected<std::size_t, Fault> FrameState::value_of(Kind kind, Tokens expression, std::size_t routine) {
  const Spot spot = spot_of(expression);
  const auto known = [&](const Position& position) {
    return add({.state = State::Known, .X = pose_of(position), .set = spot});
  };
  const Token& first = expression[0];
  if (first.is('{')) {
    std::size_t next = 0;
    const auto aggregate = read_aggregate(expression, next);
    if (!aggregate) return std::unexpected(aggregate.error());
    const auto position = position_of(*aggregate, file_);
    if (next == expression.size() && position && position->form == PositionForm::Cartesian)
      return known(*position);
  } else if (expression.size() == 1) {
    if (first.is("$NULLFRAME") || first.is("$WORLD")) return numbered(kind, 0, spot);
    const Variable* variable = find(first.text, routine);
    if (variable && variable->type == VariableType::Frame && !variable->hindrance) {
      const auto* position = std::get_if<Position>(&variable->value);
      if (position && position->form == PositionForm::Cartesian) return known(*position);
    }
  } else if (expression.size() == 4 && expression[1].is('[') &&
             (first.is("TOOL_DATA") || first.is("BASE_DATA"))) {
    const Kind table = first.is("TOOL_DATA") ? Kind::Tool : Kind::Base;
    return numbered(table, number(table, expression.subspan(2, 1), routine), spot);
  } else if (first.is("STOOL2") || first.is("STOOL") || first.is("SBASE")) {
    return numbered(kind, number(kind, bracketed(expression, 1), routine), spot);
  }
  return numbered(kind, std::nullopt, spot);
}

const Variable* FrameState::find(std::string_view name, std::size_t routine) const {
  const auto index = variables_.find(name, {module_, routine});
  return index ? &variables_.all()[*index] : nullptr;
}

std::optional<MotionData> FrameState::motion_data(Tokens expression, std::size_t routine) const {
  if (expression.empty()) return std::nullopt;
  if (expression[0].is('{')) {
    std::size_t next = 0;
    const auto aggregate = read_aggregate(expression, next);
    return aggregate && next == expression.size() ? std::optional(motion_data_of(*aggregate)) : std::nullopt;
  }
  const Variable* variable = expression.size() == 1 ? find(expression[0].text, routine) : nullptr;
  const auto* data = variable ? std::get_if<MotionData>(&variable->value) : nullptr;
  return data && !variable->hindrance ? std::optional(*data) : std::nullopt;
}

std::optional<int> FrameState::number(Kind kind, Tokens expression, std::size_t routine) const {
  // FP1.TOOL_NO says no more than FP1.
  const bool is_component = expression.size() == 3 && expression[1].is('.');
  if (is_component && !expression[2].is(kind == Kind::Tool ? "TOOL_NO" : "BASE_NO")) return std::nullopt;
  if (const auto data = motion_data(expression.first(is_component ? 1 : expression.size()), routine))
    return kind == Kind::Tool ? data->tool : data->base;
  const auto number = read_number(expression);
  if (!number || !*number || (*number)->value < 0 || (*number)->value > 1e6) return std::nullopt;
  const double value = (*number)->value;
  return value == std::trunc(value) ? std::optional(static_cast<int>(value)) : std::nullopt;
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
  } else if (const auto written =
                 variables_.frame_written(module_, kind == Kind::Tool ? "TOOL_DATA" : "BASE_DATA", *number)) {
    value.state = State::Written;
    value.set = *written;
  } else if (const auto found = table.find(*number); found != table.end()) {
    value.state = State::Known;
    value.X = found->second;
  }
  return add(value);
}

}  // namespace truepose::krl
