#include "daemon/recorder/recording_folder.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <system_error>
#include <utility>

#include "config/text_file.hpp"
#include "daemon/recorder/folder_access.hpp"

namespace truepose::daemon {

namespace fs = std::filesystem;

namespace {

constexpr const char* kExtension = ".pcapng";

/// Which of its folder a recording is, from 1, as its name "DATE_NUMBER.pcapng" says: a clock may be set
/// back. 0: its name has none.
std::uint64_t number_of(const RecordingFolder::Entry& entry) {
  const std::string stem = fs::path{entry.name}.stem();
  const char* const end = stem.data() + stem.size();
  std::uint64_t number = 0;
  const std::size_t digits = stem.rfind('_') + 1;  // from the start where there is none
  const auto [read, error] = std::from_chars(stem.data() + digits, end, number);
  return error == std::errc{} && read == end ? number : 0;
}

/// What a daemon that was killed has left of a recording, "NAME.pcapng.PID": of a process that is not this
/// one.
bool is_left_over(const fs::path& file) {
  const std::string pid = file.extension();
  return file.stem().extension() == kExtension && pid.size() > 1 &&
         pid.find_first_not_of("0123456789", 1) == std::string::npos &&
         pid != "." + std::to_string(::getpid()) && config::is_own_file(file);
}

}  // namespace

std::string RecordingFolder::why_unusable() const {
  // Where it is not there yet, the daemon makes it.
  std::error_code unknown;
  const bool is_there = fs::exists(config_.folder, unknown) || unknown;
  const std::string why =
      why_not_writable(is_there ? config_.folder : fs::absolute(config_.folder).parent_path());
  if (why.empty()) return {};
  return "recording.folder: " + config_.folder.string() + " cannot be written by this user (" + why +
         "): give a folder that can be";
}

// Without colons, which some file systems do not take.
fs::path RecordingFolder::file(const std::string& date) const {
  const std::vector<Entry> made = list();
  const std::uint64_t number = made.empty() ? 1 : number_of(made.front()) + 1;
  std::string name = date + "_" + std::to_string(number);
  std::ranges::replace(name, ':', '-');
  return config_.folder / (name + kExtension);
}

std::vector<RecordingFolder::Entry> RecordingFolder::list() const {
  std::vector<Entry> entries;
  std::error_code unread;
  // What is removed meanwhile is not listed, and what cannot be read ends the list.
  for (fs::directory_iterator each{config_.folder, unread}, end; each != end; each.increment(unread)) {
    std::error_code gone;
    if (each->path().extension() != kExtension || !config::is_own_file(each->path())) continue;
    const std::uintmax_t bytes = each->file_size(gone);
    if (!gone) entries.push_back({each->path().filename(), bytes});
  }
  const auto order = [](const Entry& entry) { return std::pair{number_of(entry), entry.name}; };
  std::ranges::sort(entries, std::ranges::greater{}, order);
  return entries;
}

fs::path RecordingFolder::find(const std::string& name) const {
  const auto entries = list();
  const bool there = std::ranges::find(entries, name, &Entry::name) != entries.end();
  return there ? config_.folder / name : fs::path{};
}

std::vector<std::string> RecordingFolder::remove_left_over() const {
  std::error_code ignored;
  std::vector<fs::path> left_over;
  for (fs::directory_iterator each{config_.folder, ignored}, end; each != end; each.increment(ignored))
    if (is_left_over(each->path())) left_over.push_back(each->path());
  std::vector<std::string> removed;
  for (const fs::path& file : left_over)
    if (fs::remove(file, ignored)) removed.push_back(file.filename());
  return removed;
}

std::vector<std::string> RecordingFolder::prune() const {
  std::vector<std::string> removed;
  std::size_t count = 0;
  std::uintmax_t bytes = 0;
  for (const Entry& entry : list()) {
    ++count;
    bytes += entry.bytes;
    const bool too_much = count > config_.max_files || bytes > std::uintmax_t{config_.max_mb} << 20U;
    std::error_code failed;
    if (count > 1 && too_much && fs::remove(config_.folder / entry.name, failed))
      removed.push_back(entry.name);
  }
  return removed;
}

}  // namespace truepose::daemon
