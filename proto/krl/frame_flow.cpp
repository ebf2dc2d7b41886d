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

/// What BAS() sets is known without its text.
std::vector<std::string> called_by(const ProgramStatement& statement) {
  std::vector<std::string> names;
  for (const Expression& call : statement.calls()) {
    if (statement.is_head || call.name != "BAS") names.push_back(call.name);
  }
  return names;
}

FrameAct act_of(const ProgramStatement& statement, std::size_t file) {
  return {.at = statement.at(),
          .routine = statement.routine,
          .set = settings_of(statement, file),
          .calls = called_by(statement),
          .label = label_of(statement.tokens),
          .jump = jump_of(statement.tokens),
          .is_head = statement.is_head,
          .is_later = statement.is_later(),
          .is_interrupt = declares_interrupt(statement.tokens)};
}

bool says_nothing(const FrameAct& act) {
  return !act.is_head && !act.set && act.calls.empty() && act.label.empty() && act.jump.empty();
}

/// What the statements of a text set out of its order, and what its routines set.
class Flow {
 public:
  Flow(const FrameActs& acts, const RoutineSettings& others);
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
  FrameSettings by_calls(const FrameAct& act) const;
  /// By itself or by what it calls, at once or later.
  FrameSettings set_by(const FrameAct& act) const;
  std::vector<Stretch> stretches() const;
  FrameSettings within(const Stretch& stretch) const;

  const FrameActs& acts_;
  const RoutineSettings& others_;
  std::map<std::string, std::size_t> routine_of_;
  std::vector<FrameSettings> set_by_{1};  // by routine, the first: what stands before any
};

Flow::Flow(const FrameActs& acts, const RoutineSettings& others) : acts_{acts}, others_{others} {
  for (const FrameAct& act : acts_) {
    if (!act.is_head) continue;
    if (!act.calls.empty()) routine_of_.emplace(act.calls[0], set_by_.size());
    set_by_.emplace_back();
  }
  settle_routines();
}

/// What a routine sets by another that it calls, it sets too.
void Flow::settle_routines() {
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (const FrameAct& act : acts_) {
      if (!act.is_interrupt) is_new = set_by_[act.routine].add(set_by(act)) || is_new;
    }
  }
}

FrameSettings Flow::by_calls(const FrameAct& act) const {
  FrameSettings set;
  if (act.is_head) return set;
  for (const std::string& name : act.calls) {
    if (const auto called = routine_of_.find(name); called != routine_of_.end()) {
      set.add(set_by_[called->second]);
    } else if (const auto other = others_.find(name); other != others_.end()) {
      set.add(other->second);
    }
  }
  return set;
}

FrameSettings Flow::set_by(const FrameAct& act) const {
  FrameSettings set = act.set;
  set.add(by_calls(act));
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
  for (const FrameAct& act : acts_) {
    if (!act.label.empty()) labels.try_emplace({act.routine, act.label}, act.at);
  }
  std::vector<Stretch> jumps;
  for (const FrameAct& act : acts_) {
    const auto to = labels.find({act.routine, act.jump});
    if (to == labels.end()) continue;
    const std::size_t from = act.at, label = to->second;
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
  for (const FrameAct& act : acts_) {
    if (act.at >= stretch.first && act.at <= stretch.last && !act.is_interrupt) set.add(set_by(act));
  }
  return set;
}

FrameFlow Flow::found() const {
  FrameFlow flow;
  for (const FrameAct& act : acts_) {
    const FrameSettings set = act.is_later ? set_by(act) : by_calls(act);
    if (set) (act.is_interrupt ? flow.interrupts : flow.behind[act.at]).add(set);
  }
  for (const Stretch& stretch : stretches()) {
    const FrameSettings set = within(stretch);
    if (!set) continue;
    for (const std::size_t label : stretch.labels) flow.behind[label].add(set);
  }
  return flow;
}

}  // namespace

FrameActs frame_acts(const TextStatements& statements, std::size_t file) {
  FrameActs acts;
  statements.uses.each([&](const ProgramStatement& statement) {
    FrameAct act = act_of(statement, file);
    if (!says_nothing(act)) acts.push_back(std::move(act));
  });
  return acts;
}

RoutineSettings routine_settings(const ProgramText& text, std::span<const FrameActs> acts) {
  RoutineSettings settings;
  // Routines call routines of other files: until nothing new is found.
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (std::size_t file = 0; file < text.files.size(); ++file) {
      if (text.files[file].role != SourceText::Role::Program) continue;
      is_new = Flow(acts[file], settings).add_to(settings) || is_new;
    }
  }
  return settings;
}

FrameFlow frame_flow(const FrameActs& acts, const RoutineSettings& others) {
  return Flow(acts, others).found();
}

}  // namespace truepose::krl
