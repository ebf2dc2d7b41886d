#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>

#include "config/kuka_archive.hpp"
#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/krl/program_report.hpp"
#include "tools/truepose/offline/compensate.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;
using config::ArchiveFile;
using config::ConfigError;

bool has_folder(const fs::path& path, std::string_view folder) {
  return std::ranges::any_of(path,
                             [&](const fs::path& part) { return krl::in_capitals(part.string()) == folder; });
}

/// Machine data, and KUKA's own programs, have no positions of the customer's.
bool is_of_controller(const fs::path& path) {
  const bool is_program = krl::in_capitals(path.extension().string()) != ".DAT";
  return has_folder(path, "MADA") || has_folder(path, "STEU") || (has_folder(path, "SYSTEM") && is_program);
}

krl::SourceText source_of(const ArchiveFile& file) {
  using Role = krl::SourceText::Role;
  const fs::path path{file.path};
  const std::string name = krl::in_capitals(path.filename().string());
  const bool is_data = name.ends_with(".DAT");
  // Folders may have modules of one name.
  return {.role = name == "$CONFIG.DAT" ? Role::Config
                  : is_data             ? Role::Data
                                        : Role::Program,
          .module = krl::in_capitals((path.parent_path() / path.stem()).string()),
          .text = file.text};
}

/// What became of one file.
struct FileCount {
  std::size_t changed = 0;  ///< positions that it writes
  std::size_t left = 0;     ///< motions to a fixed place that stay uncorrected
};

std::map<std::size_t, FileCount> counts_by_file(const ProgramCompensation& done) {
  std::map<std::size_t, FileCount> counts;
  for (const PointChange& change : done.changes) ++counts[change.spot.file].changed;
  for (const krl::LeftAlone& left : done.left) {
    if (left.absolute) ++counts[left.spot.file].left;
  }
  return counts;
}

/// Programs whose motions go to corrected and to uncorrected positions: between these the arm is as wrong as
/// it was.
std::vector<std::size_t> mixed_files(const krl::Program& program, const ProgramCompensation& done) {
  std::map<std::size_t, FileCount> counts;
  std::map<std::pair<std::size_t, std::size_t>, bool> changed;
  for (const PointChange& change : done.changes) changed[{change.spot.file, change.spot.at}] = true;
  for (const krl::Step& step : program.steps) {
    if (!step.point) continue;
    const krl::Spot& spot = program.points[*step.point].position.spot;
    if (changed.contains({spot.file, spot.at})) ++counts[step.spot.file].changed;
  }
  for (const krl::LeftAlone& left : done.left) {
    if (left.absolute) ++counts[left.spot.file].left;
  }
  std::vector<std::size_t> mixed;
  for (const auto& [file, count] : counts) {
    if (count.changed > 0 && count.left > 0) mixed.push_back(file);
  }
  return mixed;
}

std::string archive_summary(const std::string& archive, const krl::Program& program,
                            const ProgramCompensation& done, const ProgramPlaces& places) {
  std::string text = program_summary(archive, done, places);
  text += "Files:\n";
  for (const auto& [file, count] : counts_by_file(done))
    text +=
        fmt::format("  {}: {} changed, {} uncorrected\n", places.file({file, 0}), count.changed, count.left);
  for (const std::size_t file : mixed_files(program, done))
    text += fmt::format(
        "  {}: goes to corrected and to uncorrected positions; between them the arm is as wrong "
        "as before\n",
        places.file({file, 0}));
  for (const krl::ProgramFault& fault : program.unread)
    text += fmt::format("  {}: not read: {}\n", places.line_and_column(fault.spot), fault.what);
  return text;
}

struct FileChange {
  std::string file;
  FileCount count;
};
void layout(record::Io& io, FileChange& x) {
  io("file", x.file);
  io("changed", x.count.changed);
  io("left", x.count.left);
}

struct ArchiveDocument {
  krl::Program program;
  ProgramDocument compensated;
};
void layout(record::Io& io, ArchiveDocument& x) {
  const auto& [done, places] = x.compensated;
  layout(io, x.compensated);
  std::vector<FileChange> files;
  for (const auto& [file, count] : counts_by_file(done)) files.push_back({places.file({file, 0}), count});
  io("files", files);
  std::vector<std::string> mixed;
  for (const std::size_t file : mixed_files(x.program, done)) mixed.push_back(places.file({file, 0}));
  io("mixed", mixed);
  io("unread", x.program.unread, InFiles{places});
}

void write_archive(const fs::path& folder, const std::vector<ArchiveFile>& files,
                   const ProgramCompensation& done) {
  std::vector<config::TextFile> written;
  for (const auto& [file, edits] : done.edits) {
    const fs::path place = folder / files[file].path;
    std::error_code failed;
    fs::create_directories(place.parent_path(), failed);
    if (failed) throw ConfigError{place.parent_path().string() + ": cannot be made: " + failed.message()};
    written.push_back({place, krl::rewritten(files[file].text, edits)});
  }
  config::write_together(written);
}

}  // namespace

int run_compensate_archive(const CompensateOptions& options, const RobotModel& nominal,
                           const config::ModelFile& model) {
  const auto inverse = StatusTurnInverse::by_search(nominal);
  if (!inverse) throw ConfigError(options.arm.robot.string() + ": " + inverse.error());
  std::vector<ArchiveFile> files = config::read_kuka_archive(options.archive);
  std::erase_if(files, [](const ArchiveFile& file) { return is_of_controller(file.path); });
  krl::ProgramText text{.is_archive = true};
  std::vector<std::string> names;
  for (const ArchiveFile& file : files) {
    text.files.push_back(source_of(file));
    names.push_back(file.path);
  }
  const ProgramPlaces places(text, std::move(names));
  // Of an archive no fault is an error: what cannot be read or corrected is said file by file.
  const krl::Program program = krl::read_program(text, {}).value();
  const ProgramCompensation done =
      compensate_program(program, nominal, *inverse, model.cell.robot, options.bounds, {}, true).value();
  if (!options.out_file.empty()) write_archive(options.out_file, files, done);
  if (options.as_json) {
    std::cout << control::json_text(record::to_json(ArchiveDocument{program, {done, places}})) << '\n';
  } else {
    std::cout << archive_summary(options.archive.string(), program, done, places);
    if (!done.edits.empty()) note_written({options.out_file});
  }
  const auto uncorrected = std::ranges::count_if(done.left, &krl::LeftAlone::absolute);
  if (uncorrected == 0 && program.unread.empty()) return kDone;
  throw CommandError{kFailed, fmt::format("{}: {} targets stay uncorrected, {} files were not read",
                                          options.archive.string(), uncorrected, program.unread.size())};
}

}  // namespace truepose::tools
