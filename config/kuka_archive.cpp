#include "config/kuka_archive.hpp"

#include <zip.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>

#include "config/text_file.hpp"

namespace truepose::config {
namespace {

namespace fs = std::filesystem;

std::string in_small_letters(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool is_krl(const std::string& path) {
  constexpr std::array<std::string_view, 3> kEndings = {".src", ".sub", ".dat"};
  const std::string small = in_small_letters(path);
  return std::ranges::any_of(kEndings, [&](std::string_view ending) { return small.ends_with(ending); });
}

/// What an archive holds, before anything of it is read.
struct Entry {
  std::string path;
  std::function<std::string()> read;
};

/// Those of the robot, where the archive shows which they are: it has templates and options of Windows too.
std::vector<Entry> of_robot(std::vector<Entry> entries) {
  for (const std::string_view home : {"krc/", ""}) {
    const auto is_of = [&](const Entry& entry) {
      const std::string small = in_small_letters(entry.path);
      if (!small.starts_with(home)) return false;
      const std::string_view below = std::string_view{small}.substr(home.size());
      return below.starts_with("r1/") || below.starts_with("steu/");
    };
    if (std::ranges::none_of(entries, is_of)) continue;
    std::erase_if(entries, [&](const Entry& entry) { return !is_of(entry); });
    break;
  }
  return entries;
}

std::vector<Entry> entries_of_folder(const fs::path& folder) {
  std::vector<Entry> entries;
  for (const auto& entry : fs::recursive_directory_iterator{folder}) {
    if (!entry.is_regular_file()) continue;
    entries.push_back({entry.path().lexically_relative(folder).generic_string(),
                       [path = entry.path()] { return read_bytes(path); }});
  }
  return entries;
}

using Zip = std::unique_ptr<zip_t, decltype(&zip_discard)>;
using ZipFile = std::unique_ptr<zip_file_t, decltype(&zip_fclose)>;

Zip open_zip(const fs::path& file) {
  int code = 0;
  Zip zip{zip_open(file.c_str(), ZIP_RDONLY, &code), &zip_discard};
  if (zip) return zip;
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  const std::string why = zip_error_strerror(&error);
  zip_error_fini(&error);
  throw ConfigError{file.string() + ": no archive: " + why +
                    ". Give the folder that holds KRC, or its .zip."};
}

std::string read_of_zip(zip_t* zip, const zip_stat_t& stat, const std::string& place) {
  const ZipFile file{zip_fopen_index(zip, stat.index, 0), &zip_fclose};
  std::string text(stat.size, '\0');
  if (!file || zip_fread(file.get(), text.data(), stat.size) != static_cast<zip_int64_t>(stat.size))
    throw ConfigError{place + ": cannot be read: " + zip_strerror(zip)};
  return text;
}

std::vector<Entry> entries_of_zip(zip_t* zip, const fs::path& archive) {
  std::vector<Entry> entries;
  const auto count = static_cast<zip_uint64_t>(zip_get_num_entries(zip, 0));
  for (zip_uint64_t i = 0; i < count; ++i) {
    zip_stat_t stat;
    if (zip_stat_index(zip, i, ZIP_FL_ENC_RAW, &stat) != 0) continue;
    std::string path = stat.name;
    std::ranges::replace(path, '\\', '/');
    if (path.ends_with('/')) continue;
    const std::string place = archive.string() + "/" + path;
    if (stat.size > kMostBytesOfFile) throw ConfigError{place + ": is too large"};
    entries.push_back({path, [zip, stat, place] { return read_of_zip(zip, stat, place); }});
  }
  return entries;
}

std::vector<ArchiveFile> read_entries(std::vector<Entry> entries, const fs::path& archive) {
  std::erase_if(entries, [](const Entry& entry) { return !is_krl(entry.path); });
  entries = of_robot(std::move(entries));
  if (entries.empty())
    throw ConfigError{archive.string() +
                      ": no KRL file (.src, .dat). Give the folder that holds KRC, or the archive's .zip."};
  std::vector<ArchiveFile> files;
  std::size_t bytes = 0;
  for (const Entry& entry : entries) {
    files.push_back({entry.path, entry.read()});
    bytes += files.back().text.size();
    if (bytes > kMostBytesOfFile) throw ConfigError{archive.string() + ": its KRL files are too large"};
  }
  std::ranges::sort(files, {}, &ArchiveFile::path);
  return files;
}

}  // namespace

std::vector<ArchiveFile> read_kuka_archive(const fs::path& archive) {
  if (fs::is_directory(archive)) return read_entries(entries_of_folder(archive), archive);
  const Zip zip = open_zip(archive);
  return read_entries(entries_of_zip(zip.get(), archive), archive);
}

}  // namespace truepose::config
