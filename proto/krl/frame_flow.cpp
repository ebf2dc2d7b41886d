#include "proto/krl/frame_flow.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace truepose::krl {
namespace {

bool declares_interrupt(Tokens statement) {
  if (statement[0].is("GLOBAL")) statement = statement.subspan(1);
  return statement.size() > 1 && statement[0].is("INTERRUPT") && statement[1].is("DECL");
}

std::string label_of(Tokens statement) {
  const bool is_label = statement.size() == 2 && statement[0].kind == TokenKind::Name && statement[1].is(":");
  return is_label ? statement[0].word() : "";
}

std::string jump_of(Tokens statement) {
  return statement.size() == 2 && statement[0].is("GOTO") ? statement[1].word() : "";
}

/// What the statements of a text set out of its order, and what its routines set.
class Flow {
 public:
  Flow(Statements statements, std::size_t file, const RoutineSettings& others);
  FrameFlow found() const;
  /// Adds what the routines of the text set. @return whether something is new
  bool add_to(RoutineSettings& settings) const;

 private:
  /// Statements that jumps lead over, from the first to the last byte, and the labels that they lead to.
  struct Stretch {
    std::size_t first = 0, last = 0;
    std::vector<std::size_t> labels;
  };

  void settle_routines();
  FrameSettings by_calls(const ProgramStatement& statement) const;
  /// By itself or by what it calls, at once or later.
  FrameSettings set_by(const ProgramStatement& statement) const;
  std::vector<Stretch> stretches() const;
  FrameSettings within(const Stretch& stretch) const;

  Statements statements_;
  std::size_t file_;
  const RoutineSettings& others_;
  std::map<std::string, std::size_t> routine_of_;
  std::vector<FrameSettings> set_by_{1};  // by routine, the first: what stands before any
};

Flow::Flow(Statements statements, std::size_t file, const RoutineSettings& others)
    : statements_{statements}, file_{file}, others_{others} {
  for (const ProgramStatement& statement : statements_) {
    if (!statement.is_head) continue;
    if (!statement.calls.empty()) routine_of_.emplace(statement.calls[0].name, set_by_.size());
    set_by_.emplace_back();
  }
  settle_routines();
}

/// What a routine sets by another that it calls, it sets too.
void Flow::settle_routines() {
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (const ProgramStatement& statement : statements_) {
      if (!declares_interrupt(statement.tokens))
        is_new = set_by_[statement.routine].add(set_by(statement)) || is_new;
    }
  }
}

FrameSettings Flow::by_calls(const ProgramStatement& statement) const {
  FrameSettings set;
  if (statement.is_head) return set;
  for (const Expression& call : statement.calls) {
    if (call.name == "BAS") continue;
    if (const auto called = routine_of_.find(call.name); called != routine_of_.end()) {
      set.add(set_by_[called->second]);
    } else if (const auto other = others_.find(call.name); other != others_.end()) {
      set.add(other->second);
    }
  }
  return set;
}

FrameSettings Flow::set_by(const ProgramStatement& statement) const {
  FrameSettings set = settings_of(statement, file_);
  set.add(by_calls(statement));
  return set;
}

bool Flow::add_to(RoutineSettings& settings) const {
  bool is_new = false;
  for (const auto& [name, routine] : routine_of_) is_new = settings[name].add(set_by_[routine]) || is_new;
  return is_new;
}

/// Jumps of a routine that overlap lead into each other, and are one stretch.
std::vector<Flow::Stretch> Flow::stretches() const {
  std::map<std::pair<std::size_t, std::string>, std::size_t> labels;
  for (const ProgramStatement& statement : statements_) {
    if (const std::string label = label_of(statement.tokens); !label.empty())
      labels.try_emplace({statement.routine, label}, statement.tokens[0].at);
  }
  std::vector<Stretch> jumps;
  for (const ProgramStatement& statement : statements_) {
    const auto to = labels.find({statement.routine, jump_of(statement.tokens)});
    if (to == labels.end()) continue;
    const std::size_t from = statement.tokens[0].at, label = to->second;
    jumps.push_back({std::min(from, label), std::max(from, label), {label}});
  }
  std::ranges::sort(jumps, {}, &Stretch::first);
  std::vector<Stretch> merged;
  for (Stretch& jump : jumps) {
    if (merged.empty() || jump.first > merged.back().last) {
      merged.push_back(std::move(jump));
      continue;
    }
    merged.back().last = std::max(merged.back().last, jump.last);
    merged.back().labels.push_back(jump.labels.front());
  }
  return merged;
}

FrameSettings Flow::within(const Stretch& stretch) const {
  FrameSettings set;
  for (const ProgramStatement& statement : statements_) {
    const std::size_t at = statement.tokens[0].at;
    if (at >= stretch.first && at <= stretch.last && !declares_interrupt(statement.tokens))
      set.add(set_by(statement));
  }
  return set;
}

FrameFlow Flow::found() const {
  FrameFlow flow;
  for (const ProgramStatement& statement : statements_) {
    const FrameSettings set = statement.is_later() ? set_by(statement) : by_calls(statement);
    if (!set) continue;
    (declares_interrupt(statement.tokens) ? flow.interrupts : flow.behind[statement.tokens[0].at]).add(set);
  }
  for (const Stretch& stretch : stretches()) {
    const FrameSettings set = within(stretch);
    if (!set) continue;
    for (const std::size_t label : stretch.labels) flow.behind[label].add(set);
  }
  return flow;
}

}  // namespace

RoutineSettings routine_settings(const ProgramText& text,
                                 std::span<const std::vector<ProgramStatement>> statements) {
  RoutineSettings settings;
  // Routines call routines of other files: until nothing new is found.
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (std::size_t file = 0; file < text.files.size(); ++file) {
      if (text.files[file].role != SourceText::Role::Program) continue;
      is_new = Flow(statements[file], file, settings).add_to(settings) || is_new;
    }
  }
  return settings;
}

FrameFlow frame_flow(Statements statements, std::size_t file, const RoutineSettings& others) {
  return Flow(statements, file, others).found();
}

}  // namespace truepose::krl
