#include "daemon/control/audit_trail.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "config/text_file.hpp"
#include "core/planted_bug.hpp"
#include "daemon/control/disk_advice.hpp"
#include "proto/control/access.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using control::AuditHead;

/// @return errno where it cannot be written
std::expected<void, int> write_at(int file, std::string_view bytes, std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t size = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return std::unexpected(errno);
    bytes.remove_prefix(static_cast<std::size_t>(size));
    offset += static_cast<std::uint64_t>(size);
  }
  if (planted("the audit trail is not synced")) return {};
  if (::fdatasync(file) != 0) return std::unexpected(errno);
  return {};
}

/// Whether the file at this path is the one that is open.
bool is_at(const fs::path& path, int file) {
  struct stat open {
  }, there{};
  return ::fstat(file, &open) == 0 && ::stat(path.c_str(), &there) == 0 && open.st_dev == there.st_dev &&
         open.st_ino == there.st_ino;
}

std::uint64_t size_of(int file) {
  struct stat found {};
  return ::fstat(file, &found) == 0 ? static_cast<std::uint64_t>(found.st_size) : 0;
}

std::string bytes_of(int file, std::uint64_t begin, std::uint64_t size) {
  std::string bytes(size, '\0');
  const ssize_t read = ::pread(file, bytes.data(), size, static_cast<off_t>(begin));
  bytes.resize(read < 0 ? 0 : static_cast<std::size_t>(read));
  return bytes;
}

}  // namespace

// Opening.

std::expected<void, std::string> AuditTrail::open_files(bool must_be_new) {
  constexpr mode_t kOursAlone = S_IRUSR | S_IWUSR;
  const int flags = O_RDWR | O_CREAT | O_CLOEXEC | (must_be_new ? O_EXCL : 0);
  last_.file = ::open(file_.c_str(), flags, kOursAlone);
  if (last_.file >= 0) head_ = ::open(audit_head_of(file_).c_str(), flags, kOursAlone);
  // Else a loss of power takes new files with all that is synced in them.
  const bool named = last_.file >= 0 && head_ >= 0 && config::synced(config::folder_of(file_));
  if (!named) return std::unexpected(std::strerror(errno));
  return {};
}

void AuditTrail::close_files() {
  if (last_.file >= 0) ::close(std::exchange(last_.file, -1));
  if (head_ >= 0) ::close(std::exchange(head_, -1));
}

std::expected<void, std::string> AuditTrail::put_aside(const std::string& time, std::string& aside) const {
  fs::path to = file_.string() + ".changed-" + time;
  std::error_code none;
  while (fs::exists(to, none) || fs::exists(audit_head_of(to), none)) to += "+";
  aside.clear();
  for (const auto& [from, kept] :
       std::array{std::pair{file_, to}, std::pair{audit_head_of(file_), audit_head_of(to)}}) {
    std::error_code error;
    fs::rename(from, kept, error);
    if (error == std::errc::no_such_file_or_directory) continue;
    if (error) return std::unexpected(from.string() + ": " + error.message());
    if (from == file_) aside = kept.string();
  }
  return {};
}

std::expected<void, std::string> AuditTrail::begin_behind(const AuditHead& end, const std::string& why,
                                                          const std::string& time) {
  std::string aside;
  if (auto moved = put_aside(time, aside); !moved) return moved;
  close_files();
  if (auto opened = open_files(true); !opened) return opened;
  end_ = end;
  if (const auto kept = write_at(head_, control::head_text(end_), 0); !kept)
    return std::unexpected(std::strerror(kept.error()) + ("; " + disk_advice(kept.error())));
  last_.first = end.count + 1;
  last_.ends = {0};
  fault_ = why + (aside.empty() ? "" : "; it is kept as " + aside);
  const auto said = write({{"time", time}, {"who", control::kDaemonName}, {"put_aside", fault_}});
  if (!said) return std::unexpected(said.error());
  return {};
}

std::expected<AuditTrail, std::string> AuditTrail::open(const fs::path& file, const std::string& time,
                                                        std::span<const AuditHead> known,
                                                        std::uint64_t full) {
  AuditTrail audit;
  audit.file_ = file;
  audit.full_ = full;
  const auto bad = [&](const std::string& why) {
    return std::unexpected("audit trail " + file.string() + ": " + why);
  };
  auto followed = follow_last_audit_file(file, known);
  if (!followed && !followed.error().was_changed) return bad(followed.error().why);
  if (!followed) {
    // Numbers continue after the last known record.
    std::vector<AuditHead> ends{known.begin(), known.end()};
    if (const auto kept = kept_audit_head(file); kept && *kept) ends.push_back(**kept);
    if (const auto files = full_audit_files(file); files && !files->empty())
      ends.push_back({files->back().last});
    const AuditHead end = ends.empty() ? AuditHead{} : std::ranges::max(ends, {}, &AuditHead::count);
    if (const auto begun = audit.begin_behind(end, followed.error().why, time); !begun)
      return bad(begun.error());
    return audit;
  }
  if (const auto opened = audit.open_files(false); !opened) return bad(opened.error());
  if (*followed) {
    audit.end_ = std::move((*followed)->end);
    audit.last_.first = (*followed)->base.count + 1;
    audit.last_.ends = std::move((*followed)->ends);
    for (const AuditFault& fault : (*followed)->faults)
      if (fault.acknowledged_by.empty()) audit.fault_ = fault.text;
  }
  // What a power cut left of a line that was never said to be there, and an end that was not yet kept.
  if (::ftruncate(audit.last_.file, static_cast<off_t>(audit.last_.ends.back())) != 0)
    return bad(std::strerror(errno));
  const std::string end = control::head_text(audit.end_);
  if (bytes_of(audit.head_, 0, end.size()) == end) return audit;
  if (const auto kept = write_at(audit.head_, end, 0); !kept) return bad(std::strerror(kept.error()));
  return audit;
}

AuditTrail::AuditTrail(AuditTrail&& other) noexcept
    : file_{std::move(other.file_)},
      full_{other.full_},
      last_{std::exchange(other.last_, {})},
      head_{std::exchange(other.head_, -1)},
      end_{std::move(other.end_)},
      is_taken_back_{other.is_taken_back_},
      fault_{std::move(other.fault_)},
      pending_{std::move(other.pending_)},
      read_{std::exchange(other.read_, std::nullopt)} {}

AuditTrail::~AuditTrail() {
  close_files();
  if (read_) ::close(read_->file);
}

// What may have become of its files.

std::expected<void, std::string> AuditTrail::in_place() const {
  const auto lost = [](const fs::path& file, const char* what) {
    return std::unexpected(file.string() + ": " + what +
                           " while the daemon writes to it: put it back, or acknowledge that by "
                           "`truepose audit acknowledge --name NAME`");
  };
  const fs::path head = audit_head_of(file_);
  if (!is_taken_back_)
    return std::unexpected(file_.string() + ": a record that failed cannot be taken back; check the disk");
  if (!is_at(file_, last_.file)) return lost(file_, "was deleted, moved away or replaced");
  if (!is_at(head, head_)) return lost(head, "was deleted, moved away or replaced");
  if (size_of(last_.file) != last_.ends.back()) return lost(file_, "was cut or written to");
  const std::string kept = control::head_text(end_);
  if (bytes_of(head_, 0, kept.size() + 1) != kept) return lost(head, "was changed");
  return {};
}

std::expected<void, std::string> AuditTrail::restore(const std::string& time) {
  if (!is_taken_back_) static_cast<void>(take_back());
  const auto there = in_place();
  if (there) return {};
  const std::string why = there.error().substr(0, there.error().find(" while the daemon"));
  const bool whole = size_of(last_.file) >= last_.ends.back();
  if (!whole) return begin_behind(end_, why, time);
  // Its records are still to be read by who has it open.
  const std::string records = bytes_of(last_.file, 0, last_.ends.back());
  if (records.size() != last_.ends.back()) return begin_behind(end_, why, time);
  std::string aside;
  if (auto moved = put_aside(time, aside); !moved) return moved;
  close_files();
  if (auto opened = open_files(true); !opened) return opened;
  auto written = write_at(last_.file, records, 0);
  if (written) written = write_at(head_, control::head_text(end_), 0);
  if (!written)
    return std::unexpected(std::strerror(written.error()) + ("; " + disk_advice(written.error())));
  fault_ = why + "; the daemon has put back what it had";
  const auto said = write({{"time", time}, {"who", control::kDaemonName}, {"put_aside", fault_}});
  if (!said) return std::unexpected(said.error());
  return {};
}

// Writing.

std::expected<std::uint64_t, std::string> AuditTrail::append(json::object record) {
  if (const auto paid = pay(); !paid) return std::unexpected(paid.error());
  return write(std::move(record));
}

AuditTrail::Taken AuditTrail::take(json::object record) {
  constexpr std::size_t kMaxPending = 200;
  const auto written = append(record);
  if (written) return {*written, {}};
  if (pending_.size() < kMaxPending) {
    record["written_later"] = true;
    pending_.push_back(std::move(record));
  } else {
    const json::value* const missed = pending_.back().if_contains("missed");
    // The last one is missed too.
    pending_.back() = {{"time", record["time"]}, {"missed", missed ? missed->as_int64() + 1 : 2}};
  }
  return {end_.count + pending_.size(), written.error()};
}

std::expected<void, std::string> AuditTrail::pay() {
  for (; !pending_.empty(); pending_.pop_front()) {
    const auto written = write(pending_.front());
    if (!written) return std::unexpected(written.error());
  }
  return {};
}

std::expected<void, std::string> AuditTrail::begin_next_file() {
  const fs::path full = full_audit_file(file_, last_.first, end_.count);
  std::error_code error;
  fs::rename(file_, full, error);
  if (error) return std::unexpected(full.string() + ": " + error.message());
  const int next = ::open(file_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  // Where the power goes before, a start finds the one file or the two.
  if (next < 0 || !config::synced(config::folder_of(file_))) {
    const int why = errno;
    if (next >= 0) ::close(next);
    fs::rename(full, file_, error);
    return std::unexpected(std::strerror(why) + ("; " + disk_advice(why)));
  }
  ::close(std::exchange(last_.file, next));
  last_.first = end_.count + 1;
  last_.ends = {0};
  return {};
}

// It must not look like a record, nor as if one had been taken away: a start takes a trail that is one record
// longer than its end says, and none that is shorter.
std::expected<void, int> AuditTrail::take_back() {
  auto back = write_at(head_, control::head_text(end_), 0);
  if (back && ::ftruncate(last_.file, static_cast<off_t>(last_.ends.back())) != 0)
    back = std::unexpected(errno);
  is_taken_back_ = back.has_value();
  return back;
}

std::expected<std::uint64_t, std::string> AuditTrail::write(json::object record) {
  if (!is_taken_back_)
    if (const auto back = take_back(); !back)
      return std::unexpected(std::strerror(back.error()) + ("; " + disk_advice(back.error())));
  if (auto there = in_place(); !there) return std::unexpected(there.error());
  // A fault stays where a start looks for it.
  if (last_.ends.back() >= full_ && fault_.empty())
    if (auto begun = begin_next_file(); !begun) return std::unexpected(begun.error());
  AuditHead end = end_;
  const std::string line = control::audit_line(end, std::move(record));
  const std::uint64_t offset = last_.ends.back();
  auto written = write_at(last_.file, line, offset);
  if (written) written = write_at(head_, control::head_text(end), 0);
  if (!written) {
    const std::string left = take_back() ? "" : ", and what is there cannot be taken back";
    return std::unexpected(std::strerror(written.error()) + left + "; " + disk_advice(written.error()));
  }
  end_ = std::move(end);
  last_.ends.push_back(offset + line.size());
  return end_.count;
}

// Reading.

std::expected<const AuditTrail::Part*, std::string> AuditTrail::part_with(std::uint64_t number) {
  if (number >= last_.first) return &last_;
  const auto has_it = [number](const Part& part) {
    return number >= part.first && number < part.first + part.ends.size() - 1;
  };
  if (read_ && has_it(*read_)) return &*read_;
  const auto files = full_audit_files(file_);
  if (!files) return std::unexpected(files.error());
  const auto found = std::ranges::find_if(
      *files, [number](const FullAuditFile& full) { return number >= full.first && number <= full.last; });
  if (found == files->end()) return nullptr;
  auto followed = follow_audit_file(found->file, std::nullopt, {});
  if (!followed) return std::unexpected(found->file.string() + ": " + followed.error().why);
  const int file = ::open(found->file.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::unexpected(found->file.string() + ": " + std::strerror(errno));
  if (read_) ::close(read_->file);
  read_ = Part{file, followed->base.count + 1, std::move(followed->ends)};
  return has_it(*read_) ? &*read_ : nullptr;
}

std::expected<json::array, std::string> AuditTrail::records(std::uint64_t before, std::size_t limit) {
  constexpr std::uint64_t kMostBytes = 48 * 1024;
  json::array found;
  std::uint64_t bytes = 0;
  for (std::uint64_t n = std::min(before, end_.count + 1) - 1; n > 0 && found.size() < limit; --n) {
    const auto part = part_with(n);
    if (!part) return std::unexpected(part.error());
    if (!*part) break;  // it was put aside, or taken away
    const std::size_t at = n - (*part)->first;
    const std::uint64_t begin = (*part)->ends[at], size = (*part)->ends[at + 1] - begin;
    if (bytes + size > kMostBytes && !found.empty()) break;
    bytes += size;
    const std::string line = bytes_of((*part)->file, begin, size);
    if (line.size() != size)
      return std::unexpected("the audit trail cannot be read: " + std::string{std::strerror(errno)});
    auto record = control::parse_json(std::string_view{line}.substr(0, size - 1));
    if (!record) return std::unexpected("record " + std::to_string(n) + " was changed");
    found.push_back(*std::move(record));
  }
  return found;
}

}  // namespace truepose::daemon
