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
  std::vector<std::string> calls;  ///< all names as in the following in capitals
  std::string label, jumps_to;
};

std::vector<std::string> calls_in(Tokens statement) {
  std::vector<std::string> calls;
  for (std::size_t i = 0; i + 1 < statement.size(); ++i) {
    const bool is_call = statement[i].kind == TokenKind::Name && statement[i + 1].is('(');
    if (is_call && !statement[i].is("BAS")) calls.push_back(in_capitals(statement[i].text));
  }
  return calls;
}

bool declares_interrupt(Tokens statement) {
  if (statement[0].is("GLOBAL")) statement = statement.subspan(1);
  return statement.size() > 1 && statement[0].is("INTERRUPT") && statement[1].is("DECL");
}

Entry entry_of(Tokens statement, std::size_t file, std::size_t routine) {
  Entry entry{.routine = routine, .at = statement[0].at, .is_interrupt = declares_interrupt(statement)};
  const Tokens action = action_of(statement);
  const bool is_later = action.data() != statement.data();
  (is_later ? entry.later : entry.in_order) = settings_of(action, file);
  entry.calls = calls_in(action);
  if (statement.size() == 2 && statement[0].kind == TokenKind::Name) {
    if (statement[1].is(':')) entry.label = in_capitals(statement[0].text);
    if (statement[0].is("GOTO")) entry.jumps_to = in_capitals(statement[1].text);
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
  explicit Flow(const RoutineSettings& others) : others_{others} {}
  std::expected<void, Fault> read(std::string_view src, std::size_t file);
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

std::expected<void, Fault> Flow::read(std::string_view src, std::size_t file) {
  StatementReader reader(src);
  while (true) {
    const auto statement = reader.next();
    if (!statement) return std::unexpected(statement.error());
    if (statement->empty()) break;
    if (starts_routine(*statement)) {
      const auto calls = calls_in(*statement);  // it looks like a call of itself
      if (!calls.empty()) routine_of_.emplace(calls.front(), set_by_.size());
      set_by_.emplace_back();
    } else if (Entry entry = entry_of(*statement, file, set_by_.size() - 1); matters(entry)) {
      entries_.push_back(std::move(entry));
    }
  }
  settle_routines();
  return {};
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

RoutineSettings routine_settings(const ProgramText& text) {
  RoutineSettings settings;
  // Routines call routines of other files: until nothing new is found.
  for (bool is_new = true; is_new;) {
    is_new = false;
    for (std::size_t file = 0; file < text.files.size(); ++file) {
      if (text.files[file].role != SourceText::Role::Program) continue;
      Flow flow(settings);
      if (flow.read(text.files[file].text, file)) is_new = flow.add_to(settings) || is_new;
    }
  }
  return settings;
}

std::expected<FrameFlow, Fault> read_frame_flow(std::string_view src, std::size_t file,
                                                const RoutineSettings& others) {
  Flow flow(others);
  if (const auto done = flow.read(src, file); !done) return std::unexpected(done.error());
  return flow.found();
}

}  // namespace truepose::krl
