#include "daemon/control/audit_trail.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

#include "daemon/control/disk_advice.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using control::AuditHead;

fs::path head_file_of(fs::path trail) { return trail += ".head"; }

struct Followed {
  AuditHead end{};
  std::vector<std::uint64_t> ends{0};  ///< as AuditTrail keeps them
  bool is_there = false;
};

struct NotFollowed {
  std::string why;
  bool was_read = true;  ///< and is not what was written; else nothing is known of it
};

NotFollowed unreadable(const fs::path& file) {
  return {file.string() + " cannot be read: " + std::strerror(errno), false};
}

/// None where there is no such file.
std::expected<std::optional<std::ifstream>, NotFollowed> open_to_read(const fs::path& file) {
  std::ifstream stream{file, std::ios::binary};
  if (stream.is_open()) return stream;
  if (errno == ENOENT) return std::nullopt;
  return std::unexpected(unreadable(file));
}

/// The end that was kept; none where none was.
std::expected<std::optional<AuditHead>, NotFollowed> kept_head(const fs::path& trail) {
  const fs::path file = head_file_of(trail);
  auto stream = open_to_read(file);
  if (!stream) return std::unexpected(stream.error());
  if (!*stream) return std::nullopt;
  std::array<char, 256> text{};  // longer than any head
  (*stream)->read(text.data(), text.size());
  if ((*stream)->bad()) return std::unexpected(unreadable(file));
  const auto size = static_cast<std::size_t>((*stream)->gcount());
  if (size == 0) return std::nullopt;
  auto head = control::read_head({text.data(), size});
  if (!head) return std::unexpected(NotFollowed{file.string() + " " + head.error()});
  return *std::move(head);
}

/// Follows a trail to its end, past the end that was kept: a process may have ended between the two writes.
std::expected<Followed, NotFollowed> follow(const fs::path& file) {
  const auto read = kept_head(file);
  if (!read) return std::unexpected(read.error());
  auto opened = open_to_read(file);
  if (!opened) return std::unexpected(opened.error());
  const AuditHead kept = read->value_or(AuditHead{});
  std::ifstream stream = *opened ? **std::move(opened) : std::ifstream{};
  Followed followed{.is_there = *read || *opened};
  bool has_kept_end = kept.count == 0;
  const auto end = control::follow_audit(stream, [&](const control::AuditLine& line) {
    // Each line tells the hash of the one before.
    if (followed.ends.size() == kept.count + 1)
      has_kept_end = line.record.at("before") == json::value(kept.hash);
    followed.ends.push_back(line.end);
  });
  if (stream.bad()) return std::unexpected(unreadable(file));
  if (!end) return std::unexpected(NotFollowed{end.error()});
  if (end->count == kept.count) has_kept_end = end->hash == kept.hash;
  if (!*read && end->count > 1)
    return std::unexpected(NotFollowed{head_file_of(file).string() + " is missing"});
  if (!has_kept_end)
    return std::unexpected(NotFollowed{"it has " + std::to_string(end->count) + " records, and had " +
                                       std::to_string(kept.count) + " others: lines are missing at its end"});
  followed.end = *end;
  return followed;
}

/// @return errno where it cannot be written
std::expected<void, int> write_at(int file, std::string_view bytes, std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t size = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return std::unexpected(errno);
    bytes.remove_prefix(static_cast<std::size_t>(size));
    offset += static_cast<std::uint64_t>(size);
  }
  if (::fdatasync(file) != 0) return std::unexpected(errno);
  return {};
}

}  // namespace

fs::path audit_file_of(const fs::path& store) {
  fs::path file = store;
  file += ".audit";
  return file;
}

std::expected<AuditHead, std::string> verify_audit(const fs::path& trail) {
  auto followed = follow(trail);
  if (!followed) return std::unexpected(followed.error().why);
  if (!followed->is_there) return std::unexpected("there is none; is this the daemon's store?");
  return followed->end;
}

std::expected<void, std::string> AuditTrail::open_files(const fs::path& file) {
  constexpr mode_t kOursAlone = S_IRUSR | S_IWUSR;
  trail_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kOursAlone);
  head_ = ::open(head_file_of(file).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kOursAlone);
  if (trail_ < 0 || head_ < 0) return std::unexpected(std::strerror(errno));
  return {};
}

std::expected<AuditTrail, std::string> AuditTrail::open(const fs::path& file, const std::string& time) {
  AuditTrail audit;
  const auto bad = [&](const std::string& why) {
    return std::unexpected("audit trail " + file.string() + ": " + why);
  };
  auto followed = follow(file);
  if (!followed && !followed.error().was_read) return bad(followed.error().why);
  if (!followed) {
    fs::path aside = file;
    aside += ".changed-" + time;
    std::error_code error;
    fs::rename(file, aside, error);
    if (error && fs::exists(file)) return bad(error.message());
    fs::remove(head_file_of(file), error);
    audit.put_aside_ = followed.error().why + "; it is kept as " + aside.string();
    followed = Followed{};
  }
  if (const auto opened = audit.open_files(file); !opened) return bad(opened.error());
  audit.end_ = std::move(followed->end);
  audit.ends_ = std::move(followed->ends);
  // What a power cut left of a line that was never told to be there.
  if (::ftruncate(audit.trail_, static_cast<off_t>(audit.ends_.back())) != 0)
    return bad(std::strerror(errno));
  if (audit.put_aside_.empty()) return audit;
  const auto said = audit.append({{"time", time}, {"who", "trueposed"}, {"put_aside", audit.put_aside_}});
  if (!said) return bad(said.error());
  return audit;
}

AuditTrail::AuditTrail(AuditTrail&& other) noexcept
    : trail_{std::exchange(other.trail_, -1)},
      head_{std::exchange(other.head_, -1)},
      end_{std::move(other.end_)},
      ends_{std::move(other.ends_)},
      put_aside_{std::move(other.put_aside_)},
      owed_{std::move(other.owed_)} {}

AuditTrail::~AuditTrail() {
  if (trail_ >= 0) ::close(trail_);
  if (head_ >= 0) ::close(head_);
}

std::expected<std::uint64_t, std::string> AuditTrail::append(json::object record) {
  if (const auto paid = pay(); !paid) return std::unexpected(paid.error());
  return write(std::move(record));
}

AuditTrail::Taken AuditTrail::take(json::object record) {
  constexpr std::size_t kMostOwed = 200;
  const auto written = append(record);
  if (written) return {*written, {}};
  if (owed_.size() < kMostOwed) {
    record["owed"] = true;
    owed_.push_back(std::move(record));
  } else {
    const json::value* const missed = owed_.back().if_contains("missed");
    // The last one is missed too.
    owed_.back() = {{"time", record["time"]}, {"missed", missed ? missed->as_int64() + 1 : 2}};
  }
  return {end_.count + owed_.size(), written.error()};
}

std::expected<void, std::string> AuditTrail::pay() {
  for (; !owed_.empty(); owed_.pop_front()) {
    const auto written = write(owed_.front());
    if (!written) return std::unexpected(written.error());
  }
  return {};
}

std::expected<std::uint64_t, std::string> AuditTrail::write(json::object record) {
  AuditHead end = end_;
  const std::string line = control::audit_line(end, std::move(record));
  const std::uint64_t offset = ends_.back();
  auto written = write_at(trail_, line, offset);
  if (written) written = write_at(head_, control::head_text(end), 0);
  if (!written) {
    // Whatever of it is there must not look like a record, nor as if one had been taken away.
    const auto head_back = write_at(head_, control::head_text(end_), 0);
    const bool trail_back = ::ftruncate(trail_, static_cast<off_t>(offset)) == 0;
    const std::string left = head_back && trail_back ? "" : ", and what is there cannot be taken back";
    return std::unexpected(std::strerror(written.error()) + left + "; " + disk_advice(written.error()));
  }
  end_ = std::move(end);
  ends_.push_back(offset + line.size());
  return end_.count;
}

std::expected<json::array, std::string> AuditTrail::records(std::uint64_t before, std::size_t limit) const {
  constexpr std::uint64_t kMostBytes = 48 * 1024;
  json::array found;
  std::uint64_t bytes = 0;
  for (std::uint64_t n = std::min(before, end_.count + 1); n > 1 && found.size() < limit; --n) {
    const std::uint64_t begin = ends_[n - 2], size = ends_[n - 1] - begin;
    if (bytes + size > kMostBytes && !found.empty()) break;
    bytes += size;
    std::string line(size, '\0');
    if (::pread(trail_, line.data(), size, static_cast<off_t>(begin)) != static_cast<ssize_t>(size))
      return std::unexpected("the audit trail cannot be read: " + std::string{std::strerror(errno)});
    auto record = control::parse_json(std::string_view{line}.substr(0, size - 1));
    if (!record) return std::unexpected("record " + std::to_string(n - 1) + " was changed");
    found.push_back(*std::move(record));
  }
  return found;
}

}  // namespace truepose::daemon
