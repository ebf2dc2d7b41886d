#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <iostream>

#include "config/text_file.hpp"
#include "core/math/angles.hpp"
#include "proto/control/json_text.hpp"
#include "proto/krl/places.hpp"
#include "tools/truepose/krl/program_compensation.hpp"
#include "tools/truepose/offline/compensate.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using config::ConfigError;
using config::TextFile;

// ---- What was done, as text and as a document ----

/// The files of a program as the operator named them, to say where something stands.
class ProgramPlaces {
 public:
  ProgramPlaces(const krl::ProgramText& text, const CompensateOptions& options)
      : names_{options.src.string(), options.dat.string(), options.config_dat.string()},
        places_{krl::Places(text.src), krl::Places(text.dat), krl::Places(text.config)} {}

  const std::string& file(krl::Spot spot) const { return names_[static_cast<std::size_t>(spot.file)]; }
  krl::Place place(krl::Spot spot) const { return places_[static_cast<std::size_t>(spot.file)].of(spot.at); }
  /// "P.src:12"
  std::string line(krl::Spot spot) const { return fmt::format("{}:{}", file(spot), place(spot).line); }
  /// "P.src:12:3"
  std::string line_and_column(krl::Spot spot) const {
    return fmt::format("{}:{}", line(spot), place(spot).column);
  }

 private:
  std::array<std::string, 3> names_;  // in the order of krl::File
  std::array<krl::Places, 3> places_;
};

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

std::string described(const krl::LeftAlone& left, const ProgramPlaces& places) {
  const std::string because = left.because ? " (" + places.line(*left.because) + ")" : "";
  const std::string name = left.name.empty() ? "" : left.name + ": ";
  return fmt::format("  {}: {}{}{}\n", places.line(left.spot), name, left.why, because);
}

std::string section(const char* title, const ProgramCompensation& done, const ProgramPlaces& places,
                    bool absolute) {
  std::string text;
  for (const krl::LeftAlone& left : done.left) {
    if (left.absolute == absolute) text += described(left, places);
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
  object["why"] = left.why;
  if (left.because) object["because"] = placed(*left.because, places);
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

/// What was done to a program, for a terminal.
std::string program_summary(const ProgramCompensation& done, const ProgramPlaces& places) {
  std::string text = fmt::format("{}: {} of {} positions changed\n", places.file({krl::File::Src, 0}),
                                 done.changes.size(), done.points);
  if (!done.changes.empty()) {
    const PointChange& mm = largest(done.changes, &PointChange::mm);
    const PointChange& deg = largest(done.changes, &PointChange::deg);
    text += fmt::format("  mean     {:.3f} mm, {:.4f} deg\n", mean(done.changes, &PointChange::mm),
                        mean(done.changes, &PointChange::deg));
    text += fmt::format("  largest  {:.3f} mm ({}), {:.4f} deg ({})\n", mm.mm, named(mm, places), deg.deg,
                        named(deg, places));
  }
  text += section("Left as they are, though the arm goes to a fixed place", done, places, true);
  text += section("Left as they are", done, places, false);
  if (!done.notes.empty()) text += "Note:\n";
  for (const krl::Note& note : done.notes)
    text += fmt::format("  {}: {}\n", places.line(note.spot), note.text);
  return text;
}

/// The same as one document: {"points", "changed", "mean_mm", "mean_deg", "largest_mm", "largest_deg",
/// "changes": [{file, line, name, mm, deg}], "left": [{file, line, name, why, because, absolute}],
/// "notes": [{file, line, text}]}.
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

// ---- The files ----

std::string bytes_of(const std::filesystem::path& file) {
  return file.empty() ? std::string{} : config::read_bytes(file);
}

void require_place(bool is_changed, const std::filesystem::path& in, const std::filesystem::path& out,
                   const char* option) {
  if (is_changed && out.empty())
    throw ConfigError(in.string() + ": positions in it change too; say where to write it with " + option);
}

void write(const CompensateOptions& options, const krl::ProgramText& text, const ProgramCompensation& done) {
  std::vector<TextFile> files;
  if (options.out_file.empty() && options.out_dat.empty()) return;
  require_place(!done.src_edits.empty(), options.src, options.out_file, "--out");
  require_place(!done.dat_edits.empty(), options.dat, options.out_dat, "--out-dat");
  if (!options.out_file.empty())
    files.push_back({options.out_file, krl::rewritten(text.src, done.src_edits)});
  if (!options.out_dat.empty()) files.push_back({options.out_dat, krl::rewritten(text.dat, done.dat_edits)});
  config::write_together(files);
}

// ---- Tools and bases that were measured ----

/// What is told by its numbers is in force where the program starts; what was measured is in the controller
/// as it was told.
krl::StartFrames start_of(const std::optional<Tool>& tool, const std::optional<Base>& base) {
  krl::StartFrames start;
  if (tool && tool->number == 0) start.tool = tool->X_told;
  if (tool && tool->number > 0) start.tools[tool->number] = tool->X_told;
  if (base && base->number == 0) start.base = base->X;
  if (base && base->number > 0) start.bases[base->number] = base->X;
  return start;
}

/// A frame that no motion uses was meant for another program, or has another number there.
void refuse_unused(const krl::Program& program, const char* option, const char* table, int number,
                   std::size_t krl::Step::*frame) {
  const auto uses = [&](const krl::Step& step) { return program.frames[step.*frame].number == number; };
  if (number == 0 || std::ranges::any_of(program.steps, uses)) return;
  throw ConfigError(
      fmt::format("{}: is of {}[{}], which no motion of the program uses", option, table, number));
}

RealFrames real_frames(const std::optional<Tool>& tool, const std::optional<Base>& base) {
  RealFrames real;
  if (tool && tool->number > 0) real.tools[tool->number] = tool->X_FT;
  if (base && base->number > 0) real.bases[base->number] = base->X;
  return real;
}

}  // namespace

int run_compensate_program(const CompensateOptions& options, const RobotModel& nominal,
                           const config::ModelFile& model) {
  const auto inverse = StatusTurnInverse::of(nominal);
  if (!inverse) throw ConfigError(options.arm.robot.string() + ": " + inverse.error());

  const std::string src = bytes_of(options.src), dat = bytes_of(options.dat),
                    config_dat = bytes_of(options.config_dat);
  const krl::ProgramText text{src, dat, config_dat};
  const ProgramPlaces places(text, options);
  const auto refuse = [&](const krl::ProgramFault& fault) -> ConfigError {
    return ConfigError(places.line_and_column(fault.spot) + ": " + fault.what);
  };
  const auto tool = tool_of(options.tool, "--tool", nominal, model);
  const auto base = base_of(options.base, "--base", model);
  const auto program = krl::read_program(text, start_of(tool, base));
  if (!program) throw refuse(program.error());
  refuse_unused(*program, "--tool", "TOOL_DATA", tool ? tool->number : 0, &krl::Step::tool);
  refuse_unused(*program, "--base", "BASE_DATA", base ? base->number : 0, &krl::Step::base);
  const auto done = compensate_program(*program, nominal, *inverse, model.cell.robot, options.bounds,
                                       real_frames(tool, base));
  if (!done) throw refuse(done.error());

  write(options, text, *done);
  if (options.as_json) {
    std::cout << control::json_text(program_document(*done, places)) << '\n';
  } else {
    std::cout << program_summary(*done, places);
  }
  const auto uncorrected = std::ranges::count_if(done->left, &krl::LeftAlone::absolute);
  if (uncorrected == 0) return kDone;
  throw CommandError{kFailed, fmt::format("{}: {} uncorrected", options.src.string(),
                                          uncorrected == 1 ? "1 target stays"
                                                           : fmt::format("{} targets stay", uncorrected))};
}

}  // namespace truepose::tools
