#include "tools/truepose/krl/program_report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <boost/json.hpp>
#include <utility>

namespace truepose::tools {
namespace {

namespace json = boost::json;

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

json::object placed(krl::Spot spot, const ProgramPlaces& places) {
  return {{"file", places.file(spot)}, {"line", places.place(spot).line}};
}

json::object entry(const PointChange& change, const ProgramPlaces& places) {
  json::object object = placed(change.spot, places);
  object["name"] = change.name;
  object["mm"] = change.mm;
  object["deg"] = change.deg;
  return object;
}

json::object entry(const krl::LeftAlone& left, const ProgramPlaces& places) {
  json::object object = placed(left.spot, places);
  object["name"] = left.name;
  object["code"] = left.why.message.code;
  object["why"] = left.why.message.what;
  object["what_to_do"] = left.why.message.what_to_do;
  if (left.why.because) object["because"] = placed(*left.why.because, places);
  object["absolute"] = left.absolute;
  return object;
}

json::object entry(const krl::Note& note, const ProgramPlaces& places) {
  json::object object = placed(note.spot, places);
  object["text"] = note.text;
  return object;
}

template <typename Item>
json::array entries(const std::vector<Item>& items, const ProgramPlaces& places) {
  json::array array;
  for (const Item& item : items) array.push_back(entry(item, places));
  return array;
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

json::object program_document(const ProgramCompensation& done, const ProgramPlaces& places) {
  json::object document{{"points", done.points},
                        {"changed", done.changes.size()},
                        {"mean_mm", mean(done.changes, &PointChange::mm)},
                        {"mean_deg", mean(done.changes, &PointChange::deg)}};
  if (!done.changes.empty()) {
    document["largest_mm"] = entry(largest(done.changes, &PointChange::mm), places);
    document["largest_deg"] = entry(largest(done.changes, &PointChange::deg), places);
  }
  document["changes"] = entries(done.changes, places);
  document["left"] = entries(done.left, places);
  document["notes"] = entries(done.notes, places);
  return document;
}

}  // namespace truepose::tools
