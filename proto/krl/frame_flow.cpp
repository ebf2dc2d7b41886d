#include "proto/krl/frame_flow.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace truepose::krl {
namespace {

/// A statement that may set a frame, or from which or to which the program jumps.
struct Entry {
  std::size_t routine = 0, at = 0;
  bool is_interrupt = false;
  FrameSettings in_order, later;   ///< by the statement itself, and by what it carries out later
  std::vector<std::string> calls;  ///< these and the following names in capitals
  std::string label, jumps_to;
};

bool declares_interrupt(Tokens statement) {
  if (statement[0].is("GLOBAL")) statement = statement.subspan(1);
  return statement.size() > 1 && statement[0].is("INTERRUPT") && statement[1].is("DECL");
}

Entry entry_of(const ProgramStatement& statement, std::size_t file) {
  const Tokens tokens = statement.tokens;
  Entry entry{.routine = statement.routine, .at = tokens[0].at, .is_interrupt = declares_interrupt(tokens)};
  (statement.is_later() ? entry.later : entry.in_order) = settings_of(statement, file);
  for (const Expression& call : statement.calls) {
    if (call.name != "BAS") entry.calls.push_back(call.name);
  }
  if (tokens.size() == 2 && tokens[0].kind == TokenKind::Name) {
    if (tokens[1].is(":")) entry.label = tokens[0].word();
    if (tokens[0].is("GOTO")) entry.jumps_to = tokens[1].word();
  }
  return entry;
}

bool matters(const Entry& entry) {
  return entry.in_order || entry.later || !entry.calls.empty() || !entry.label.empty() ||
         !entry.jumps_to.empty();
}

/// What a text has of such statements, and what its routines set.
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
  FrameSettings by_calls(const Entry& entry) const;
  std::vector<Stretch> stretches() const;
  FrameSettings within(const Stretch& stretch) const;

  const RoutineSettings& others_;
  std::vector<Entry> entries_;  // in the order of the text
  std::map<std::string, std::size_t> routine_of_;
  std::vector<FrameSettings> set_by_{1};  // by routine, the first: what stands before any
};

Flow::Flow(Statements statements, std::size_t file, const RoutineSettings& others) : others_{others} {
  for (const ProgramStatement& statement : statements) {
    if (statement.is_head) {
      if (!statement.calls.empty()) routine_of_.emplace(statement.calls[0].name, set_by_.size());
      set_by_.emplace_back();
    } else if (Entry entry = entry_of(statement, file); matters(entry)) {
      entries_.push_back(std::move(entry));
    }
  }
  settle_routines();
}

/// What a routine sets by another that it calls, it sets too.
void Flow::settle_routines() {
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (const Entry& entry : entries_) {
      if (entry.is_interrupt) continue;
      FrameSettings& set = set_by_[entry.routine];
      for (const FrameSettings& more : {entry.in_order, entry.later, by_calls(entry)})
        is_new = set.add(more) || is_new;
    }
  }
}

FrameSettings Flow::by_calls(const Entry& entry) const {
  FrameSettings set;
  for (const std::string& name : entry.calls) {
    if (const auto called = routine_of_.find(name); called != routine_of_.end()) {
      set.add(set_by_[called->second]);
    } else if (const auto other = others_.find(name); other != others_.end()) {
      set.add(other->second);
    }
  }
  return set;
}

bool Flow::add_to(RoutineSettings& settings) const {
  bool is_new = false;
  for (const auto& [name, routine] : routine_of_) is_new = settings[name].add(set_by_[routine]) || is_new;
  return is_new;
}

/// Jumps of a routine that overlap lead into each other, and are one stretch.
std::vector<Flow::Stretch> Flow::stretches() const {
  std::map<std::pair<std::size_t, std::string_view>, std::size_t> labels;
  for (const Entry& entry : entries_)
    if (!entry.label.empty()) labels.try_emplace({entry.routine, entry.label}, entry.at);
  std::vector<Stretch> jumps;
  for (const Entry& from : entries_) {
    const auto to = labels.find({from.routine, from.jumps_to});
    if (to == labels.end()) continue;
    const std::size_t label = to->second;
    jumps.push_back({std::min(from.at, label), std::max(from.at, label), {label}});
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
  auto entry = std::ranges::lower_bound(entries_, stretch.first, {}, &Entry::at);
  for (; entry != entries_.end() && entry->at <= stretch.last; ++entry) {
    if (entry->is_interrupt) continue;
    for (const FrameSettings& more : {entry->in_order, entry->later, by_calls(*entry)}) set.add(more);
  }
  return set;
}

FrameFlow Flow::found() const {
  FrameFlow flow;
  for (const Entry& entry : entries_) {
    FrameSettings set = entry.later;
    if (entry.is_interrupt) set.add(entry.in_order);
    set.add(by_calls(entry));
    if (!set) continue;
    if (entry.is_interrupt) {
      flow.interrupts.add(set);
    } else {
      flow.behind[entry.at].add(set);
    }
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
