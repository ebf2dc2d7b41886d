#include "proto/krl/program.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include "proto/krl/frame_flow.hpp"
#include "proto/krl/frame_state.hpp"
#include "proto/krl/variables.hpp"
#include "proto/text/kuka_names.hpp"

namespace truepose::krl {
namespace {

/// How deep a statement leads into branches and loops (1), or out of them (-1).
int nesting_of(const Token& first) {
  if (first.is_any_of({"IF", "LOOP", "FOR", "WHILE", "REPEAT", "SWITCH"})) return 1;
  return first.is_any_of({"ENDIF", "ENDLOOP", "ENDFOR", "ENDWHILE", "UNTIL", "ENDSWITCH"}) ? -1 : 0;
}

/// Whether a call may be one of a subprogram that moves the arm.
bool may_move(const Expression& call) {
  return !call.token.is_any_of({"BAS",   "PULSE",  "SWRITE",   "SREAD",   "MSGNOTIFY", "VARSTATE",
                                "ABS",   "SQRT",   "SIN",      "COS",     "TAN",       "ACOS",
                                "ATAN2", "STRLEN", "STRCLEAR", "STRCOPY", "STRADD",    "STRCOMP",
                                "FOR",   "SEC",    "IF",       "AND",     "OR",        "NOT"});
}

/// Whether the arm may stand elsewhere behind a statement that is no motion: it jumps, branches or calls.
bool may_move_on(const ProgramStatement& statement) {
  const Token& first = statement.tokens[0];
  const bool turns = first.is_any_of({"ELSE", "CASE", "DEFAULT", "GOTO", "RETURN", "RESUME"});
  return turns || statement.is_label() || nesting_of(first) != 0 ||
         std::ranges::any_of(statement.calls(), may_move);
}

/// X, Y, Z, A, B, C or A1..A6, all plain numbers or not given; nothing where it has anything else.
std::optional<std::array<std::optional<Number>, 6>> numbers_of(const Expression& aggregate) {
  std::array<std::optional<Number>, 6> numbers;
  const auto& names = form_of(aggregate) == PositionForm::Axes ? kAxisNames : kPoseNames;
  for (std::size_t i = 0; i < aggregate.names.size(); ++i) {
    const auto name = std::ranges::find(names, aggregate.names[i].word());
    const auto number = number_of(aggregate.parts[i]);
    if (name == names.end() || !number) return std::nullopt;
    numbers[static_cast<std::size_t>(name - names.begin())] = number;
  }
  return numbers;
}

/// A cell's home positions, which the controller declares for all programs.
bool is_home(std::string_view name) { return in_capitals(name).starts_with("XHOME"); }

Hindrance computed_target() { return hindrance<HindranceKind::Computed>("the target is"); }

std::vector<FrameActs> acts_of(const ProgramText& text, std::span<const TextStatements> statements) {
  std::vector<FrameActs> acts(statements.size());
  for (std::size_t file = 0; file < acts.size(); ++file) {
    if (text.files[file].role == SourceText::Role::Program) acts[file] = frame_acts(statements[file], file);
  }
  return acts;
}

class Reader {
 public:
  /// @param statements  of each file
  Reader(const ProgramText& text, std::span<const TextStatements> statements, const Variables& variables,
         FrameState& frames)
      : text_{text},
        statements_{statements},
        variables_{variables},
        frames_{frames},
        acts_{acts_of(text, statements)},
        routines_{routine_settings(text, acts_)},
        points_(variables.all().size()),
        used_(variables.all().size()) {
    program_.points.reserve(variables.all().size());
  }

  /// Reads the statements of a SRC. Throws Fault: a motion without a target.
  void read(std::size_t file);
  Program finish();

 private:
  void read_statement(const ProgramStatement& statement);
  void read_motion(const ProgramStatement& statement);
  void read_target(const Expression& target);
  void read_variable_target(const Expression& name);
  void read_element_target(const Expression& element);
  void go_to(std::size_t variable, std::string_view name, Spot spot);
  std::optional<std::size_t> point_of(std::size_t variable);
  void read_relative(const ProgramStatement& statement);
  bool read_shifted(const Expression& target);
  void add_offset(Offset offset, Spot spot);
  void note_change(const FrameState::InEffect& before, Spot spot);
  void add_step(Spot spot, std::optional<std::size_t> point);
  void leave_target(Spot spot, std::string_view name, Hindrance why);
  void leave(Spot spot, std::string_view name, Hindrance why, bool absolute);
  void leave_unused();
  const SourceText& source_of(const Variable& variable) const { return text_.files[variable.declared.file]; }
  Spot spot_of(const Token& token) const { return {file_, token.at}; }

  const ProgramText& text_;
  std::span<const TextStatements> statements_;
  const Variables& variables_;
  FrameState& frames_;
  std::vector<FrameActs> acts_;  // of each file
  RoutineSettings routines_;
  Program program_;
  std::size_t file_ = 0;
  Scope scope_;
  int nesting_ = 0;
  bool noted_change_ = false;
  bool knows_place_ = false;  // the arm comes from the step before, whatever happened between
  std::optional<FrameState::InEffect> before_spline_;
  std::vector<std::optional<std::size_t>> points_;  // of Program::points, by variable
  std::vector<bool> used_;                          // variables that motions go to
  std::set<std::string, std::less<>> left_names_;   // said once each
};

void Reader::read(std::size_t file) {
  const FrameFlow flow = frame_flow(acts_[file], routines_);
  file_ = file;
  scope_ = {text_.files[file].module};
  nesting_ = 0;
  noted_change_ = false;
  before_spline_.reset();
  knows_place_ = false;
  frames_.begin(file, scope_.module, flow.interrupts);
  statements_[file].steps.each([&](const ProgramStatement& statement) {
    read_statement(statement);
    const auto otherwise = flow.behind.find(statement.at());
    if (otherwise != flow.behind.end()) frames_.unsettle(otherwise->second);
  });
}

Program Reader::finish() {
  leave_unused();
  program_.frames = frames_.frames();
  return std::move(program_);
}

void Reader::read_statement(const ProgramStatement& statement) {
  const Token& first = statement.tokens[0];
  const Spot spot = spot_of(first);
  if (statement.is_head) {
    scope_.routine = statement.routine;
    nesting_ = 0;
    before_spline_.reset();
    frames_.start_routine(statement.routine);
    return add_step(spot, std::nullopt);
  }
  nesting_ = std::max(0, nesting_ + nesting_of(first));
  if (statement.moves())
    return first.word().ends_with("_REL") ? read_relative(statement) : read_motion(statement);

  if (may_move_on(statement)) knows_place_ = false;
  const auto before = frames_.in_effect();
  if (first.is_any_of({"SPLINE", "PTP_SPLINE"})) {
    before_spline_ = before;
    return frames_.carry_out(statement.settings());
  }
  if (first.is("ENDSPLINE") && before_spline_) {
    frames_.restore(*before_spline_);
    before_spline_.reset();
  }
  frames_.carry_out(statement);
  note_change(before, spot);
}

/// LIN_REL and the like: corrected where the text shows from where the arm comes.
void Reader::read_relative(const ProgramStatement& statement) {
  const Spot spot = spot_of(statement.tokens[0]);
  const auto motion = statement.motion();
  const bool has_numbers =
      motion && !motion->targets.empty() && motion->targets[0].kind == ExpressionKind::Aggregate;
  const auto numbers = has_numbers ? numbers_of(motion->targets[0]) : std::nullopt;
  const bool of_axes = numbers && form_of(motion->targets[0]) == PositionForm::Axes;
  const Token& word = statement.tokens[0];
  const bool is_known =
      word.is_any_of({"LIN_REL", "SLIN_REL"}) || (word.is_any_of({"PTP_REL", "SPTP_REL"}) && of_axes);
  if (!numbers || !is_known || !knows_place_) {
    leave(spot, {}, hindrance<HindranceKind::Relative>(word.text), false);
    knows_place_ = false;
    return;
  }
  const auto before = frames_.in_effect();
  frames_.carry_out(motion->settings);
  add_offset({.kind = of_axes                   ? Offset::Kind::Axes
                      : motion->frame == "TOOL" ? Offset::Kind::Tool
                                                : Offset::Kind::Base,
              .spot = spot_of(motion->targets[0].token),
              .numbers = *numbers,
              .closed_at = motion->targets[0].end - 1},
             spot);
  frames_.restore(before);
}

void Reader::add_offset(Offset offset, Spot spot) {
  program_.offsets.push_back(std::move(offset));
  add_step(spot, std::nullopt);
  program_.steps.back().offset = program_.offsets.size() - 1;
  knows_place_ = true;
}

/// `P:{..}` and `{..}:P`, where the text has the point. @return whether it is one of these
bool Reader::read_shifted(const Expression& target) {
  if (target.kind != ExpressionKind::Binary || target.name != ":") return false;
  const bool is_behind = target.parts[1].kind == ExpressionKind::Aggregate;
  const Expression &shift = target.parts[is_behind ? 1 : 0], &point = target.parts[is_behind ? 0 : 1];
  if (shift.kind != ExpressionKind::Aggregate) return false;
  const auto variable = point.kind == ExpressionKind::Name ? variables_.find(point.name, scope_)
                                                           : variables_.find_element(point, scope_);
  const auto its = variable ? point_of(*variable) : std::nullopt;
  if (!its || program_.points[*its].position.form != PositionForm::Cartesian) return false;
  const auto position = position_of(shift, file_);
  if (!position || position->form != PositionForm::Cartesian) return false;
  used_[*variable] = true;
  Offset offset{.kind = is_behind ? Offset::Kind::Behind : Offset::Kind::Before,
                .point = its,
                .spot = position->spot,
                .closed_at = shift.end - 1};
  std::ranges::copy(position->values, offset.numbers.begin());
  add_offset(offset, spot_of(target.token));
  return true;
}

void Reader::note_change(const FrameState::InEffect& before, Spot spot) {
  const FrameState::InEffect& now = frames_.in_effect();
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

void Reader::read_motion(const ProgramStatement& statement) {
  const Tokens tokens = statement.tokens;
  const auto motion = statement.motion();
  if (!motion) return leave_target(spot_of(tokens[tokens.size() > 1 ? 1 : 0]), {}, computed_target());
  if (motion->targets.size() < motion->target_count())
    throw Fault{tokens[0].at, std::string(tokens[0].text) + " has too few targets; it goes to " +
                                  std::to_string(motion->target_count())};
  const auto before = frames_.in_effect();
  frames_.carry_out(motion->settings);
  for (const Expression& target : motion->targets) read_target(target);
  if (motion->angle) leave_target(spot_of(tokens[0]), {}, hindrance<HindranceKind::Arc>());
  frames_.restore(before);
}

void Reader::read_target(const Expression& target) {
  const Spot spot = spot_of(target.token);
  if (read_shifted(target)) return;
  if (target.kind == ExpressionKind::Name) return read_variable_target(target);
  if (target.is_variable()) return read_element_target(target);
  if (target.kind != ExpressionKind::Aggregate) return leave_target(spot, {}, computed_target());
  const auto position = position_of(target, file_);
  if (!position) return leave_target(spot, {}, Hindrance{position.error()});
  program_.points.push_back({{}, *position});
  add_step(spot, program_.points.size() - 1);
}

void Reader::read_element_target(const Expression& element) {
  const Spot spot = spot_of(element.token);
  if (const auto variable = variables_.find_element(element, scope_))
    return go_to(*variable, element.text(), spot);
  leave_target(spot, element.text(), hindrance<HindranceKind::Element>());
}

void Reader::read_variable_target(const Expression& name) {
  const std::string_view text = name.token.text;
  const Spot spot = spot_of(name.token);
  const auto index = variables_.find(name.name, scope_);
  const bool is_system = text.starts_with('$');
  const bool is_elsewhere = !index || source_of(variables_.all()[*index]).role == SourceText::Role::Config;
  if (is_system || (is_elsewhere && is_home(text))) {
    leave(spot, text, is_system ? hindrance<HindranceKind::System>() : hindrance<HindranceKind::Home>(),
          false);
    return add_step(spot, index ? point_of(*index) : std::nullopt);
  }
  if (index) return go_to(*index, text, spot);
  leave_target(spot, text, hindrance<HindranceKind::Elsewhere>());
}

/// The point of a variable that has a position; none where it has not.
std::optional<std::size_t> Reader::point_of(std::size_t variable) {
  const Variable& its = variables_.all()[variable];
  const auto* position = std::get_if<Position>(&its.value);
  if (!position || its.hindrance) return std::nullopt;
  if (points_[variable]) return points_[variable];
  const SourceText& source = source_of(its);
  const bool is_of_cell = source.role == SourceText::Role::Config && is_home(its.name);
  program_.points.push_back({its.name, *position, source.is_changeable && !is_of_cell});
  return points_[variable] = program_.points.size() - 1;
}

void Reader::go_to(std::size_t index, std::string_view name, Spot spot) {
  used_[index] = true;
  const Variable& variable = variables_.all()[index];
  const auto point = point_of(index);
  if (!point) {
    leave(spot, name, variable.hindrance ? *variable.hindrance : hindrance<HindranceKind::Later>(), true);
  } else if (!source_of(variable).is_changeable) {
    leave(spot, name, hindrance<HindranceKind::Config>(), true);
  }
  add_step(spot, point);
}

void Reader::add_step(Spot spot, std::optional<std::size_t> point) {
  const auto& now = frames_.in_effect();
  program_.steps.push_back({.spot = spot,
                            .point = point,
                            .offset = {},
                            .tool = now.tool,
                            .base = now.base,
                            .fixed_tool = now.fixed_tool});
  knows_place_ = point.has_value();
}

/// Of a fixed place to which the arm goes.
void Reader::leave_target(Spot spot, std::string_view name, Hindrance why) {
  leave(spot, name, std::move(why), true);
  add_step(spot, std::nullopt);
}

void Reader::leave(Spot spot, std::string_view name, Hindrance why, bool absolute) {
  const std::string key = std::to_string(file_) + ":" + std::to_string(scope_.routine) + in_capitals(name);
  if (!name.empty() && !left_names_.insert(key).second) return;
  program_.left.push_back({spot, std::string(name), std::move(why), absolute});
}

void Reader::leave_unused() {
  for (std::size_t i = 0; i < variables_.all().size(); ++i) {
    const Variable& variable = variables_.all()[i];
    if (variable.type != VariableType::Position || variable.array || used_[i]) continue;
    if (variable.is_element || source_of(variable).role == SourceText::Role::Config) continue;
    if (!std::holds_alternative<Position>(variable.value)) continue;
    program_.left.push_back(
        {variable.declared, std::string(variable.name), hindrance<HindranceKind::Unused>(), false});
  }
}

/// The files of a text that have no fault so far.
class GoodFiles {
 public:
  explicit GoodFiles(const ProgramText& text) : text_{text}, files_(text.files.size()) {
    std::iota(files_.begin(), files_.end(), 0UZ);
    // The data lists come first: where a name is declared twice, the SRC is wrong.
    std::ranges::stable_partition(
        files_, [&](std::size_t file) { return text.files[file].role != SourceText::Role::Program; });
  }

  template <typename Read>
  void each(Read read) {
    std::erase_if(files_, [&](std::size_t file) { return !is_read(file, read); });
  }

  std::vector<ProgramFault> faults;

 private:
  template <typename Read>
  bool is_read(std::size_t file, Read& read) {
    try {
      read(file, text_.files[file]);
      return true;
    } catch (const Fault& fault) {
      faults.push_back({{file, fault.at}, fault.what});
      return false;
    }
  }

  const ProgramText& text_;
  std::vector<std::size_t> files_;
};

}  // namespace

std::expected<Program, ProgramFault> read_program(const ProgramText& text, const StartFrames& start) {
  GoodFiles files(text);
  std::vector<TextStatements> statements(text.files.size());
  Variables variables;
  files.each([&](std::size_t file, const SourceText& source) {
    auto read = read_statements(source.text);
    if (!read) throw read.error();
    variables.read_declarations(source, file, *read);
    statements[file] = *std::move(read);
  });
  FrameData data;
  files.each([&](std::size_t file, const SourceText& source) {
    variables.read_uses(source, file, statements[file]);
    if (source.role == SourceText::Role::Config) data.add(frame_data_of(statements[file]));
  });
  data.tools.insert(start.tools.begin(), start.tools.end());
  data.bases.insert(start.bases.begin(), start.bases.end());

  FrameState frames(variables, data, start);
  Reader reader(text, statements, variables, frames);
  files.each([&](std::size_t file, const SourceText& source) {
    if (source.role == SourceText::Role::Program) reader.read(file);
  });
  if (!text.is_archive && !files.faults.empty()) return std::unexpected(files.faults.front());
  Program program = reader.finish();
  program.unread = std::move(files.faults);
  return program;
}

}  // namespace truepose::krl
