#include "proto/krl/program.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>

#include "proto/krl/frame_flow.hpp"
#include "proto/krl/frame_state.hpp"
#include "proto/krl/variables.hpp"

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

/// A cell's home positions, which the controller declares for all programs.
bool is_home(std::string_view name) { return in_capitals(name).starts_with("XHOME"); }

ProgramFault in(File file, Fault fault) { return {{file, fault.at}, std::move(fault.what)}; }

class Reader {
 public:
  Reader(const Variables& variables, const Variables& config, const FrameFlow& flow, FrameState& frames)
      : variables_{variables}, config_{config}, flow_{flow}, frames_{frames} {}

  std::expected<Program, Fault> read(std::string_view src);

 private:
  std::expected<void, Fault> read_statement(Tokens statement);
  std::expected<void, Fault> read_motion(Tokens statement, int targets);
  std::expected<void, Fault> read_target(Tokens target, Spot spot);
  void read_variable_target(const Token& name, Spot spot);
  void note_change(const FrameState::InForce& before, Spot spot);
  void add_step(Spot spot, std::optional<std::size_t> point);
  void leave(Spot spot, std::string_view name, Hindrance hindrance, bool absolute);
  void leave_unused();

  const Variables& variables_;
  const Variables& config_;
  const FrameFlow& flow_;
  FrameState& frames_;
  Program program_;
  std::size_t routine_ = 0;
  int nesting_ = 0;
  bool noted_change_ = false;
  std::optional<FrameState::InForce> before_spline_;
  std::unordered_map<std::size_t, std::size_t> point_of_variable_;
  std::unordered_map<std::size_t, std::size_t> point_of_config_;
  std::set<std::size_t> used_;                     // variables that motions go to
  std::set<std::string, std::less<>> left_names_;  // said once each
};

std::expected<Program, Fault> Reader::read(std::string_view src) {
  StatementReader reader(src);
  while (true) {
    const auto statement = reader.next();
    if (!statement) return std::unexpected(statement.error());
    if (statement->empty()) break;
    if (const auto done = read_statement(*statement); !done) return std::unexpected(done.error());
    const auto otherwise = flow_.behind.find(statement->front().at);
    if (otherwise != flow_.behind.end()) frames_.unsettle(otherwise->second);
  }
  leave_unused();
  program_.frames = frames_.frames();
  return std::move(program_);
}

std::expected<void, Fault> Reader::read_statement(Tokens statement) {
  const Spot spot{File::Src, statement[0].at};
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
  if (motion == Motion::Relative) {
    leave(spot, {}, {std::string(statement[0].text) + " is relative to where the arm stands", {}}, false);
    return {};
  }
  if (motion != Motion::None) return read_motion(statement, motion == Motion::Circular ? 2 : 1);

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
    if (const auto done = read_target(target, {File::Src, target[0].at}); !done) return done;
    if (i < statement.size() && statement[i].is(',')) ++i;
  }
  frames_.restore(before);
  return {};
}

std::expected<void, Fault> Reader::read_target(Tokens target, Spot spot) {
  if (target[0].is('{')) {
    std::size_t next = 0;
    const auto aggregate = read_aggregate(target, next);
    if (!aggregate) return std::unexpected(aggregate.error());
    const auto position = position_of(*aggregate, File::Src);
    if (next == target.size() && position) {
      program_.points.push_back({{}, *position});
      add_step(spot, program_.points.size() - 1);
      return {};
    }
    leave(spot, {}, {next == target.size() ? position.error() : "the target is computed by the program", {}},
          true);
  } else if (target.size() == 1 && target[0].kind == TokenKind::Name) {
    read_variable_target(target[0], spot);
    return {};
  } else {
    const std::size_t end = end_of_variable(target, 0);
    const bool is_element = target[0].kind == TokenKind::Name && end == target.size();
    leave(
        spot, is_element ? std::string_view(target[0].text.data(), target.back().end() - target[0].at) : "",
        {is_element ? "is an element of an array or structure" : "the target is computed by the program", {}},
        true);
  }
  add_step(spot, std::nullopt);
  return {};
}

void Reader::read_variable_target(const Token& name, Spot spot) {
  const auto index = variables_.find(name.text, routine_);
  if (!index) {
    const auto of_config = config_.find(name.text, 0);
    const auto* position = of_config ? std::get_if<Position>(&config_.all()[*of_config].value) : nullptr;
    const bool is_system = name.text.starts_with('$');
    leave(spot, name.text,
          {is_system            ? "is a variable of the controller"
           : is_home(name.text) ? "is a home position of the cell"
           : position           ? "is declared in $config.dat, for all programs"
                                : "is declared in none of the files",
           {}},
          !is_system && !is_home(name.text));
    if (!position) return add_step(spot, std::nullopt);
    const auto [entry, is_new] = point_of_config_.emplace(*of_config, program_.points.size());
    if (is_new) program_.points.push_back({name.text, *position});
    return add_step(spot, entry->second);
  }
  used_.insert(*index);
  const Variable& variable = variables_.all()[*index];
  const auto* position = std::get_if<Position>(&variable.value);
  if (position && !variable.hindrance) {
    const auto [entry, is_new] = point_of_variable_.emplace(*index, program_.points.size());
    if (is_new) program_.points.push_back({variable.name, *position});
    return add_step(spot, entry->second);
  }
  leave(spot, name.text, variable.hindrance.value_or(Hindrance{"gets its value while the program runs", {}}),
        true);
  add_step(spot, std::nullopt);
}

void Reader::add_step(Spot spot, std::optional<std::size_t> point) {
  const auto& now = frames_.in_force();
  program_.steps.push_back({spot, point, now.tool, now.base, now.fixed_tool});
}

void Reader::leave(Spot spot, std::string_view name, Hindrance hindrance, bool absolute) {
  if (!name.empty() && !left_names_.insert(std::to_string(routine_) + in_capitals(name)).second) return;
  program_.left.push_back({spot, std::string(name), std::move(hindrance.why), hindrance.because, absolute});
}

void Reader::leave_unused() {
  for (std::size_t i = 0; i < variables_.all().size(); ++i) {
    const Variable& variable = variables_.all()[i];
    if (variable.type != VariableType::Position || variable.array || used_.contains(i)) continue;
    if (!std::holds_alternative<Position>(variable.value)) continue;
    program_.left.push_back(
        {variable.declared, std::string(variable.name), "no motion goes to it", {}, false});
  }
}

}  // namespace

std::expected<Program, ProgramFault> read_program(const ProgramText& text, const StartFrames& start) {
  Variables variables, config;
  for (const auto& [content, file] : {std::pair{text.dat, File::Dat}, std::pair{text.src, File::Src}}) {
    if (const auto done = variables.read(content, file); !done)
      return std::unexpected(in(file, done.error()));
  }
  if (const auto done = config.read(text.config, File::Config); !done)
    return std::unexpected(in(File::Config, done.error()));
  auto data = read_frame_data(text.config);
  if (!data) return std::unexpected(in(File::Config, data.error()));
  data->tools.insert(start.tools.begin(), start.tools.end());
  data->bases.insert(start.bases.begin(), start.bases.end());

  const auto flow = read_frame_flow(text.src);
  if (!flow) return std::unexpected(in(File::Src, flow.error()));
  FrameState frames(variables, config, *data, start, flow->interrupts);
  auto program = Reader(variables, config, *flow, frames).read(text.src);
  if (!program) return std::unexpected(in(File::Src, program.error()));
  return std::move(*program);
}

}  // namespace truepose::krl
