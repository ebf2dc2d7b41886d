#include "tools/truepose/krl/program_report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "proto/record/io.hpp"

namespace truepose::tools {
namespace {

double mean(const std::vector<PointChange>& changes, double PointChange::*measure) {
  double sum = 0;
  for (const PointChange& change : changes) sum += change.*measure;
  return changes.empty() ? 0 : sum / static_cast<double>(changes.size());
}

const PointChange& largest(const std::vector<PointChange>& changes, double PointChange::*measure) {
  return *std::ranges::max_element(changes, {}, measure);
}

std::string named(const PointChange& change, const ProgramPlaces& places) {
  const std::string line = places.line(change.spot);
  return change.name.empty() ? line : change.name + ", " + line;
}

std::string described(const krl::LeftAlone& left, const ProgramPlaces& places, AnswerText& answer) {
  Message why = left.why.message;
  if (left.why.because) why.what += " (" + places.line(*left.why.because) + ")";
  const std::string name = left.name.empty() ? "" : left.name + ": ";
  return fmt::format("  {}: {}{}\n", places.line(left.spot), name, answer.add(std::move(why)));
}

std::string section(const char* title, const ProgramCompensation& done, const ProgramPlaces& places,
                    bool absolute, AnswerText& answer) {
  std::string text;
  for (const krl::LeftAlone& left : done.left) {
    if (left.absolute == absolute) text += described(left, places, answer);
  }
  return text.empty() ? text : std::string(title) + ":\n" + text;
}

void layout_place(record::Io& io, krl::Spot spot, const ProgramPlaces& places) {
  io("file", std::string{places.file(spot)});
  io("line", places.place(spot).line);
}

}  // namespace

ProgramPlaces::ProgramPlaces(const krl::ProgramText& text, std::vector<std::string> names)
    : names_{std::move(names)} {
  for (const krl::SourceText& source : text.files) places_.emplace_back(source.text);
}

std::string ProgramPlaces::line(krl::Spot spot) const {
  return fmt::format("{}:{}", file(spot), place(spot).line);
}

std::string ProgramPlaces::line_and_column(krl::Spot spot) const {
  return fmt::format("{}:{}", line(spot), place(spot).column);
}

std::string program_summary(const std::string& title, const ProgramCompensation& done,
                            const ProgramPlaces& places) {
  std::string text = fmt::format("{}: {} of {} positions changed\n", title, done.changes.size(), done.points);
  if (!done.changes.empty()) {
    const PointChange& mm = largest(done.changes, &PointChange::mm);
    const PointChange& deg = largest(done.changes, &PointChange::deg);
    text += fmt::format("  mean     {:.3f} mm, {:.4f} deg\n", mean(done.changes, &PointChange::mm),
                        mean(done.changes, &PointChange::deg));
    text += fmt::format("  largest  {:.3f} mm ({}), {:.4f} deg ({})\n", mm.mm, named(mm, places), deg.deg,
                        named(deg, places));
  }
  AnswerText answer;
  text += section("Left as they are, though the arm goes to a fixed place", done, places, true, answer);
  text += section("Left as they are", done, places, false, answer);
  if (!done.notes.empty()) text += "Note:\n";
  for (const krl::Note& note : done.notes)
    text += fmt::format("  {}: {}\n", places.line(note.spot), note.text);
  return text;
}

void layout(record::Io& io, Placed<krl::Spot>& x) { layout_place(io, x.item, x.places); }
void layout(record::Io& io, Placed<PointChange>& x) {
  layout_place(io, x.item.spot, x.places);
  io("name", x.item.name);
  io("mm", x.item.mm);
  io("deg", x.item.deg);
}
void layout(record::Io& io, Placed<krl::LeftAlone>& x) {
  layout_place(io, x.item.spot, x.places);
  io("name", x.item.name);
  io("code", x.item.why.message.code);
  io("why", x.item.why.message.what);
  io("what_to_do", x.item.why.message.what_to_do);
  io.optional("because", x.item.why.because, InFiles{x.places});
  io("absolute", x.item.absolute);
}
void layout(record::Io& io, Placed<krl::Note>& x) {
  layout_place(io, x.item.spot, x.places);
  io("text", x.item.text);
}
void layout(record::Io& io, Placed<krl::ProgramFault>& x) {
  layout_place(io, x.item.spot, x.places);
  io("why", x.item.what);
}
void layout(record::Io& io, ProgramDocument& x) {
  std::vector<PointChange>& changes = x.done.changes;
  io("points", x.done.points);
  io("changed", changes.size());
  io("mean_mm", mean(changes, &PointChange::mm));
  io("mean_deg", mean(changes, &PointChange::deg));
  if (!changes.empty()) {
    io("largest_mm", Placed{largest(changes, &PointChange::mm), x.places});
    io("largest_deg", Placed{largest(changes, &PointChange::deg), x.places});
  }
  io("changes", changes, InFiles{x.places});
  io("left", x.done.left, InFiles{x.places});
  io("notes", x.done.notes, InFiles{x.places});
}

}  // namespace truepose::tools
