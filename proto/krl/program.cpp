#include "proto/krl/program.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <unordered_map>

#include "proto/krl/frame_flow.hpp"
#include "proto/krl/frame_state.hpp"
#include "proto/krl/variables.hpp"
#include "proto/text/kuka_names.hpp"

namespace truepose::krl {
namespace {

enum class Motion { None, Absolute, Circular, Relative };

Motion motion_of(Tokens statement) {
  const auto is_any_of = [&](std::initializer_list<std::string_view> words) {
    return std::ranges::any_of(words, [&](std::string_view word) { return statement[0].is(word); });
  };
  if (is_any_of({"PTP", "LIN", "SPTP", "SLIN", "SPL"})) return Motion::Absolute;
  if (is_any_of({"CIRC", "SCIRC"})) return Motion::Circular;
  if (is_any_of({"PTP_REL", "LIN_REL", "CIRC_REL", "SPTP_REL", "SLIN_REL", "SCIRC_REL", "SPL_REL"}))
    return Motion::Relative;
  return Motion::None;
}

/// How deep a statement leads into branches and loops (1), or out of them (-1).
int nesting_of(const Token& first) {
  for (const std::string_view word : {"IF", "LOOP", "FOR", "WHILE", "REPEAT", "SWITCH"}) {
    if (first.is(word)) return 1;
  }
  for (const std::string_view word : {"ENDIF", "ENDLOOP", "ENDFOR", "ENDWHILE", "UNTIL", "ENDSWITCH"}) {
    if (first.is(word)) return -1;
  }
  return 0;
}

/// Where the target that starts at `from` ends: at a comma, or at a name that no operator ties to it
/// (approximation, WITH, CA).
std::size_t end_of_target(Tokens statement, std::size_t from) {
  int depth = 0;
  for (std::size_t i = from; i < statement.size(); ++i) {
    const Token& token = statement[i];
    if (i > from && depth <= 0) {
      const Token& before = statement[i - 1];
      const bool is_tied = before.kind == TokenKind::Symbol && !before.closes();
      if (token.is(',') || (token.kind == TokenKind::Name && !is_tied)) return i;
    }
    if (token.opens()) ++depth;
    if (token.closes()) --depth;
  }
  return statement.size();
}

/// The assignments behind WITH, without the approximation that may follow them; none without WITH.
Tokens assignments_of(Tokens statement) {
  const auto with = std::ranges::find_if(statement, [](const Token& token) { return token.is("WITH"); });
  if (with == statement.end()) return {};
  Tokens assignments(with + 1, statement.end());
  while (!assignments.empty() && in_capitals(assignments.back().text).starts_with("C_")) {
    assignments = assignments.first(assignments.size() - 1);
  }
  return assignments;
}

/// Subprograms that do not move the arm.
bool moves_nothing(const Token& called) {
  return std::ranges::any_of(
      std::array{"BAS",    "PULSE",   "SWRITE", "SREAD", "MSGNOTIFY", "VARSTATE", "ABS",      "SQRT",
                 "SIN",    "COS",     "TAN",    "ACOS",  "ATAN2",     "STRLEN",   "STRCLEAR", "STRCOPY",
                 "STRADD", "STRCOMP", "FOR",    "SEC",   "IF",        "AND",      "OR",       "NOT"},
      [&](const char* name) { return called.is(std::string_view(name)); });
}

/// Whether the arm may stand elsewhere behind a statement that is no motion: it jumps, branches or calls.
bool may_move_on(Tokens statement) {
  constexpr std::array<std::string_view, 6> kTurns = {"ELSE", "CASE", "DEFAULT", "GOTO", "RETURN", "RESUME"};
  const Token& first = statement[0];
  if (nesting_of(first) != 0 || std::ranges::any_of(kTurns, [&](auto word) { return first.is(word); }))
    return true;
  if (statement.size() > 1 && statement[1].is(':')) return true;  // a label
  for (std::size_t i = 0; i + 1 < statement.size(); ++i) {
    const bool is_call = statement[i].kind == TokenKind::Name && statement[i + 1].is('(');
    if (is_call && !moves_nothing(statement[i])) return true;
  }
  return false;
}

/// X, Y, Z, A, B, C or A1..A6, all plain numbers or not given; nothing where it has anything else.
std::optional<std::array<std::optional<Number>, 6>> numbers_of(const Aggregate& aggregate, bool of_axes) {
  std::array<std::optional<Number>, 6> numbers;
  const auto& names = of_axes ? kAxisNames : kPoseNames;
  for (const Field& field : aggregate.fields) {
    const auto name = std::ranges::find(names, in_capitals(field.name));
    if (name == names.end() || !field.number) return std::nullopt;
    numbers[static_cast<std::size_t>(name - names.begin())] = field.number;
  }
  return numbers;
}

/// A cell's home positions, which the controller declares for all programs.
bool is_home(std::string_view name) { return in_capitals(name).starts_with("XHOME"); }

Hindrance computed_target() { return hindrance<HindranceKind::Computed>("the target is"); }

ProgramFault in(std::size_t file, Fault fault) { return {{file, fault.at}, std::move(fault.what)}; }

class Reader {
 public:
  Reader(const ProgramText& text, const Variables& variables, FrameState& frames)
      : text_{text}, variables_{variables}, frames_{frames}, routines_{routine_settings(text)} {}

  /// Reads the statements of a SRC.
  std::expected<void, Fault> read(std::size_t file);
  Program finish();

 private:
  std::expected<void, Fault> read_statement(Tokens statement);
  std::expected<void, Fault> read_motion(Tokens statement, int targets);
  std::expected<void, Fault> read_target(Tokens target, Spot spot);
  void read_variable_target(const Token& name, Spot spot);
  void read_part_target(Tokens target, Spot spot);
  void go_to(std::size_t variable, std::string_view name, Spot spot);
  std::optional<std::size_t> point_of(std::size_t variable);
  std::expected<void, Fault> read_relative(Tokens statement, Spot spot);
  std::expected<bool, Fault> read_shifted(Tokens target, Spot spot);
  void add_offset(Spot spot);
  void note_change(const FrameState::InForce& before, Spot spot);
  void add_step(Spot spot, std::optional<std::size_t> point);
  void leave(Spot spot, std::string_view name, Hindrance why, bool absolute);
  void leave_unused();
  const SourceText& source_of(const Variable& variable) const { return text_.files[variable.declared.file]; }

  const ProgramText& text_;
  const Variables& variables_;
  FrameState& frames_;
  RoutineSettings routines_;
  Program program_;
  std::size_t file_ = 0, routine_ = 0;
  int nesting_ = 0;
  bool noted_change_ = false;
  bool knows_place_ = false;  // the arm comes from the step before, whatever happened between
  std::optional<FrameState::InForce> before_spline_;
  std::unordered_map<std::size_t, std::size_t> point_of_variable_;
  std::set<std::size_t> used_;                     // variables that motions go to
  std::set<std::string, std::less<>> left_names_;  // said once each
};

std::expected<void, Fault> Reader::read(std::size_t file) {
  const SourceText& source = text_.files[file];
  const auto flow = read_frame_flow(source.text, file, routines_);
  if (!flow) return std::unexpected(flow.error());
  file_ = file;
  routine_ = 0;
  nesting_ = 0;
  noted_change_ = false;
  before_spline_.reset();
  knows_place_ = false;
  frames_.begin(file, source.module, flow->interrupts);
  StatementReader reader(source.text);
  while (true) {
    const auto statement = reader.next();
    if (!statement) return std::unexpected(statement.error());
    if (statement->empty()) return {};
    if (const auto done = read_statement(*statement); !done) return done;
    const auto otherwise = flow->behind.find(statement->front().at);
    if (otherwise != flow->behind.end()) frames_.unsettle(otherwise->second);
  }
}

Program Reader::finish() {
  leave_unused();
  program_.frames = frames_.frames();
  return std::move(program_);
}

std::expected<void, Fault> Reader::read_statement(Tokens statement) {
  const Spot spot{file_, statement[0].at};
  if (starts_routine(statement)) {
    ++routine_;
    nesting_ = 0;
    before_spline_.reset();
    frames_.start();
    add_step(spot, std::nullopt);
    return {};
  }
  nesting_ = std::max(0, nesting_ + nesting_of(statement[0]));
  // A variable may be called like a motion.
  const bool is_assignment = statement.size() > 1 && (statement[1].is('=') || statement[1].is('.'));
  const Motion motion = is_assignment ? Motion::None : motion_of(statement);
  if (motion == Motion::Relative) return read_relative(statement, spot);
  if (motion != Motion::None) return read_motion(statement, motion == Motion::Circular ? 2 : 1);

  if (may_move_on(statement)) knows_place_ = false;
  const auto before = frames_.in_force();
  if (statement[0].is("SPLINE") || statement[0].is("PTP_SPLINE")) {
    before_spline_ = before;
    return frames_.carry_out_list(assignments_of(statement), routine_);
  }
  if (statement[0].is("ENDSPLINE") && before_spline_) {
    frames_.restore(*before_spline_);
    before_spline_.reset();
  }
  const auto done = frames_.carry_out(statement, routine_);
  if (done) note_change(before, spot);
  return done;
}

/// LIN_REL and the like: corrected where the text shows from where the arm comes.
std::expected<void, Fault> Reader::read_relative(Tokens statement, Spot spot) {
  const auto leave_it = [&] {
    leave(spot, {}, hindrance<HindranceKind::Relative>(statement[0].text), false);
    knows_place_ = false;
    return std::expected<void, Fault>{};
  };
  if (statement.size() < 2 || !statement[1].is('{')) return leave_it();
  std::size_t next = 1;
  const auto aggregate = read_aggregate(statement, next);
  if (!aggregate) return std::unexpected(aggregate.error());
  const bool of_axes =
      std::ranges::any_of(kAxisNames, [&](auto name) { return aggregate->find(name) != nullptr; });
  const auto numbers = numbers_of(*aggregate, of_axes);
  const bool is_known = statement[0].is("LIN_REL") || statement[0].is("SLIN_REL") ||
                        ((statement[0].is("PTP_REL") || statement[0].is("SPTP_REL")) && of_axes);
  if (!numbers || !is_known || !knows_place_) return leave_it();
  const bool in_tool = next < statement.size() && statement[next].is("#TOOL");
  program_.offsets.push_back({.kind = of_axes   ? Offset::Kind::Axes
                                      : in_tool ? Offset::Kind::Tool
                                                : Offset::Kind::Base,
                              .spot = {file_, aggregate->at},
                              .numbers = *numbers,
                              .closed_at = aggregate->closed_at,
                              .is_empty = aggregate->fields.empty()});
  const auto before = frames_.in_force();
  if (const auto done = frames_.carry_out_list(assignments_of(statement), routine_); !done) return done;
  add_offset(spot);
  frames_.restore(before);
  return {};
}

void Reader::add_offset(Spot spot) {
  add_step(spot, std::nullopt);
  program_.steps.back().offset = program_.offsets.size() - 1;
  knows_place_ = true;
}

/// `P:{..}` and `{..}:P`, where the text has the point. @return whether it is one of these
std::expected<bool, Fault> Reader::read_shifted(Tokens target, Spot spot) {
  const auto colon = std::ranges::find_if(target, [depth = 0](const Token& token) mutable {
    if (token.opens()) ++depth;
    if (token.closes()) --depth;
    return depth == 0 && token.is(':');
  });
  if (colon == target.end()) return false;
  const Tokens left(target.begin(), colon), right(colon + 1, target.end());
  if (left.empty() || right.empty()) return false;
  const bool is_behind = right[0].is('{');
  const Tokens shift = is_behind ? right : left, point = is_behind ? left : right;
  if (!shift[0].is('{') || point[0].kind != TokenKind::Name) return false;
  if (end_of_variable(point, 0) != point.size()) return false;
  const Scope scope{text_.files[file_].module, routine_};
  const auto variable =
      point.size() == 1 ? variables_.find(point[0].text, scope) : variables_.find_element(point, scope);
  const auto its = variable ? point_of(*variable) : std::nullopt;
  if (!its || program_.points[*its].position.form != PositionForm::Cartesian) return false;
  std::size_t next = 0;
  const auto aggregate = read_aggregate(shift, next);
  if (!aggregate) return std::unexpected(aggregate.error());
  const auto position = position_of(*aggregate, file_);
  if (next != shift.size() || !position || position->form != PositionForm::Cartesian) return false;
  used_.insert(*variable);
  Offset offset{.kind = is_behind ? Offset::Kind::Behind : Offset::Kind::Before,
                .point = its,
                .spot = {file_, aggregate->at},
                .closed_at = aggregate->closed_at};
  std::ranges::copy(position->values, offset.numbers.begin());
  program_.offsets.push_back(offset);
  add_offset(spot);
  return true;
}

void Reader::note_change(const FrameState::InForce& before, Spot spot) {
  const FrameState::InForce& now = frames_.in_force();
  const auto differs = [&](std::size_t was, std::size_t is) {
    const FrameValue &a = frames_.frames()[was], &b = frames_.frames()[is];
    return a.state != FrameValue::State::Unset && (a.state != b.state || a.X.matrix() != b.X.matrix());
  };
  const bool tool = differs(before.tool, now.tool), base = differs(before.base, now.base);
  if (nesting_ == 0 || noted_change_ || (!tool && !base)) return;
  noted_change_ = true;
  program_.notes.push_back(
      {spot, std::string(tool ? "the tool" : "the base") +
                 " changes inside a branch or loop; motions were taken in the order of the text"});
}

std::expected<void, Fault> Reader::read_motion(Tokens statement, int targets) {
  const auto before = frames_.in_force();
  if (const auto done = frames_.carry_out_list(assignments_of(statement), routine_); !done) return done;
  std::size_t i = 1;
  for (int k = 0; k < targets; ++k) {
    if (i >= statement.size())
      return std::unexpected(Fault{
          statement[0].at,
          std::string(statement[0].text) + " has too few targets; it goes to " + std::to_string(targets)});
    const std::size_t from = i;
    i = end_of_target(statement, from);
    const Tokens target = statement.subspan(from, i - from);
    if (const auto done = read_target(target, {file_, target[0].at}); !done) return done;
    if (i < statement.size() && statement[i].is(',')) ++i;
  }
  if (targets == 2 && i < statement.size() && statement[i].is("CA")) {
    const Spot spot{file_, statement[0].at};
    leave(spot, {}, hindrance<HindranceKind::Arc>(), true);
    add_step(spot, std::nullopt);
  }
  frames_.restore(before);
  return {};
}

std::expected<void, Fault> Reader::read_target(Tokens target, Spot spot) {
  const auto is_shifted = read_shifted(target, spot);
  if (!is_shifted) return std::unexpected(is_shifted.error());
  if (*is_shifted) return {};
  if (target[0].is('{')) {
    std::size_t next = 0;
    const auto aggregate = read_aggregate(target, next);
    if (!aggregate) return std::unexpected(aggregate.error());
    const auto position = position_of(*aggregate, file_);
    if (next == target.size() && position) {
      program_.points.push_back({{}, *position});
      add_step(spot, program_.points.size() - 1);
      return {};
    }
    leave(spot, {}, next == target.size() ? Hindrance{position.error()} : computed_target(), true);
  } else if (target.size() == 1 && target[0].kind == TokenKind::Name) {
    read_variable_target(target[0], spot);
    return {};
  } else {
    read_part_target(target, spot);
    return {};
  }
  add_step(spot, std::nullopt);
  return {};
}

/// An element of an array, or what the program computes.
void Reader::read_part_target(Tokens target, Spot spot) {
  const bool is_part = target[0].kind == TokenKind::Name && end_of_variable(target, 0) == target.size();
  if (!is_part) {
    leave(spot, {}, computed_target(), true);
    return add_step(spot, std::nullopt);
  }
  const std::string_view name(target[0].text.data(), target.back().end() - target[0].at);
  if (const auto element = variables_.find_element(target, {text_.files[file_].module, routine_}))
    return go_to(*element, name, spot);
  leave(spot, name, hindrance<HindranceKind::Element>(), true);
  add_step(spot, std::nullopt);
}

void Reader::read_variable_target(const Token& name, Spot spot) {
  const auto index = variables_.find(name.text, {text_.files[file_].module, routine_});
  const bool is_system = name.text.starts_with('$');
  const bool is_elsewhere = !index || source_of(variables_.all()[*index]).role == SourceText::Role::Config;
  if (is_system || (is_elsewhere && is_home(name.text))) {
    leave(spot, name.text, is_system ? hindrance<HindranceKind::System>() : hindrance<HindranceKind::Home>(),
          false);
    if (!index) return add_step(spot, std::nullopt);
    return add_step(spot, point_of(*index));
  }
  if (index) return go_to(*index, name.text, spot);
  leave(spot, name.text, hindrance<HindranceKind::Elsewhere>(), true);
  add_step(spot, std::nullopt);
}

/// The point of a variable that has a position; none where it has not.
std::optional<std::size_t> Reader::point_of(std::size_t variable) {
  const Variable& its = variables_.all()[variable];
  const auto* position = std::get_if<Position>(&its.value);
  if (!position || its.hindrance) return std::nullopt;
  const auto [entry, is_new] = point_of_variable_.emplace(variable, program_.points.size());
  const SourceText& source = source_of(its);
  const bool is_of_cell = source.role == SourceText::Role::Config && is_home(its.name);
  if (is_new) program_.points.push_back({its.name, *position, source.is_changeable && !is_of_cell});
  return entry->second;
}

void Reader::go_to(std::size_t index, std::string_view name, Spot spot) {
  used_.insert(index);
  const Variable& variable = variables_.all()[index];
  const auto point = point_of(index);
  if (!point) {
    leave(spot, name, variable.hindrance.value_or(hindrance<HindranceKind::Later>()), true);
  } else if (!source_of(variable).is_changeable) {
    leave(spot, name, hindrance<HindranceKind::Config>(), true);
  }
  add_step(spot, point);
}

void Reader::add_step(Spot spot, std::optional<std::size_t> point) {
  const auto& now = frames_.in_force();
  program_.steps.push_back({.spot = spot,
                            .point = point,
                            .offset = {},
                            .tool = now.tool,
                            .base = now.base,
                            .fixed_tool = now.fixed_tool});
  knows_place_ = point.has_value();
}

void Reader::leave(Spot spot, std::string_view name, Hindrance why, bool absolute) {
  const std::string key = std::to_string(file_) + ":" + std::to_string(routine_) + in_capitals(name);
  if (!name.empty() && !left_names_.insert(key).second) return;
  program_.left.push_back({spot, std::string(name), std::move(why), absolute});
}

void Reader::leave_unused() {
  for (std::size_t i = 0; i < variables_.all().size(); ++i) {
    const Variable& variable = variables_.all()[i];
    if (variable.type != VariableType::Position || variable.array || used_.contains(i)) continue;
    if (variable.is_element || source_of(variable).role == SourceText::Role::Config) continue;
    if (!std::holds_alternative<Position>(variable.value)) continue;
    program_.left.push_back(
        {variable.declared, std::string(variable.name), hindrance<HindranceKind::Unused>(), false});
  }
}

}  // namespace

ProgramText program_text(std::string_view src, std::string_view dat, std::string_view config) {
  using Role = SourceText::Role;
  return {
      .files = {{Role::Program, "", src}, {Role::Data, "", dat}, {Role::Config, "$CONFIG", config, false}}};
}

std::expected<Program, ProgramFault> read_program(const ProgramText& text, const StartFrames& start) {
  Variables variables;
  FrameData data;
  std::vector<ProgramFault> unread;
  std::vector<bool> is_read(text.files.size(), true);
  const auto refused = [&](std::size_t file, const Fault& fault) {
    unread.push_back(in(file, fault));
    is_read[file] = false;
    return !text.is_archive;
  };
  // The data lists come first: where a name is declared twice, the SRC is wrong.
  std::vector<std::size_t> order(text.files.size());
  std::iota(order.begin(), order.end(), 0UZ);
  std::ranges::stable_partition(
      order, [&](std::size_t file) { return text.files[file].role != SourceText::Role::Program; });
  for (const std::size_t file : order) {
    const auto done = variables.read_declarations(text.files[file], file);
    if (!done && refused(file, done.error())) return std::unexpected(unread.front());
  }
  for (const std::size_t file : order) {
    if (!is_read[file]) continue;
    const auto done = variables.read_uses(text.files[file], file);
    if (!done && refused(file, done.error())) return std::unexpected(unread.front());
    if (text.files[file].role != SourceText::Role::Config) continue;
    auto frames = read_frame_data(text.files[file].text);
    if (!frames && refused(file, frames.error())) return std::unexpected(unread.front());
    if (frames) data.add(*std::move(frames));
  }
  data.tools.insert(start.tools.begin(), start.tools.end());
  data.bases.insert(start.bases.begin(), start.bases.end());

  FrameState frames(variables, data, start);
  Reader reader(text, variables, frames);
  for (std::size_t file = 0; file < text.files.size(); ++file) {
    if (text.files[file].role != SourceText::Role::Program || !is_read[file]) continue;
    const auto done = reader.read(file);
    if (!done && refused(file, done.error())) return std::unexpected(unread.front());
  }
  Program program = reader.finish();
  program.unread = std::move(unread);
  return program;
}

}  // namespace truepose::krl
