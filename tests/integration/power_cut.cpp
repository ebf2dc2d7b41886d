#include "tests/integration/power_cut.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <ranges>
#include <stdexcept>
#include <string_view>

#include "tests/integration/power_cut_log.hpp"
#include "tests/process.hpp"

namespace truepose::test {
namespace {

namespace fs = std::filesystem;

struct Write {
  UnsyncedWrite what;
  std::string old_bytes, new_bytes;
};

/// All that were noted whole: the last may be cut off where the daemon was killed, and was not made then.
std::vector<Write> writes_of(std::string_view log) {
  std::vector<Write> writes;
  while (log.size() >= sizeof(UnsyncedWrite)) {
    Write write;
    std::memcpy(&write.what, log.data(), sizeof write.what);
    log.remove_prefix(sizeof write.what);
    const auto old_bytes = static_cast<std::size_t>(write.what.old_bytes);
    const auto new_bytes = static_cast<std::size_t>(write.what.new_bytes);
    if (log.size() < old_bytes + new_bytes) break;
    write.old_bytes = log.substr(0, old_bytes);
    write.new_bytes = log.substr(old_bytes, new_bytes);
    log.remove_prefix(old_bytes + new_bytes);
    writes.push_back(std::move(write));
  }
  return writes;
}

void put(std::string& file, std::size_t at, std::string_view bytes) {
  if (file.size() < at + bytes.size()) file.resize(at + bytes.size());
  std::ranges::copy(bytes, file.begin() + static_cast<std::ptrdiff_t>(at));
}

void undo(std::string& file, const Write& write) {
  file.resize(static_cast<std::size_t>(write.what.before));
  put(file, static_cast<std::size_t>(write.what.offset), write.old_bytes);
}

void make(std::string& file, const Write& write, std::size_t bytes) {
  const auto at = static_cast<std::size_t>(write.what.offset);
  if (write.what.is_truncation != 0) {
    file.resize(at);
  } else {
    put(file, at, std::string_view{write.new_bytes}.substr(0, bytes));
  }
}

void take_from(const fs::path& file, const std::vector<Write>& writes, std::mt19937_64& random) {
  constexpr std::size_t kSector = 512;
  std::string bytes = text_of(file);
  for (const Write& write : std::views::reverse(writes)) undo(bytes, write);
  const bool in_order = random() % 2 == 0;
  const std::size_t first_lost = random() % (writes.size() + 1);
  const std::size_t torn = random() % writes.size();
  for (std::size_t i = 0; i < writes.size(); ++i) {
    const bool stays = in_order ? i < first_lost : random() % 2 == 0;
    const bool is_torn = in_order ? i == first_lost : i == torn && !stays;
    const std::size_t size = writes[i].new_bytes.size();
    if (stays) make(bytes, writes[i], size);
    if (is_torn && size > kSector) make(bytes, writes[i], kSector * (random() % (size / kSector)));
  }
  std::ofstream{file, std::ios::binary | std::ios::trunc} << bytes;
}

}  // namespace

std::vector<std::string> power_may_be_cut(const fs::path& store) {
  return {std::string{"LD_PRELOAD="} + TRUEPOSE_POWER_CUT_PRELOAD,
          std::string{kWatchedFiles} + "=" + store.string()};
}

int cut_power(const fs::path& store, std::mt19937_64& random) {
  int count = 0;
  std::vector<fs::path> logs;
  for (const auto& entry : fs::directory_iterator{store.parent_path()}) {
    const std::string name = entry.path().string();
    // Memory, which is gone.
    if (name == store.string() + "-shm") fs::remove(entry.path());
    if (name.starts_with(store.string()) && name.ends_with(kLogSuffix)) logs.push_back(entry.path());
  }
  if (logs.empty()) throw std::runtime_error{"nothing was noted of " + store.string()};
  for (const fs::path& log : logs) {
    const std::vector<Write> writes = writes_of(text_of(log));
    const fs::path file = fs::path{log}.replace_extension();
    if (!writes.empty()) take_from(file, writes, random);
    count += static_cast<int>(writes.size());
    fs::resize_file(log, 0);
  }
  return count;
}

}  // namespace truepose::test
