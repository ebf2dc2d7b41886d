#include "daemon/control/audit_files.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>
#include <utility>

#include "proto/text/digest.hpp"

namespace truepose::daemon {

namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using control::AuditHead;
using control::AuditLine;

AuditNotFollowed unreadable(const fs::path& file) {
  return {file.string() + " cannot be read: " + std::strerror(errno), false};
}

std::unexpected<AuditNotFollowed> changed(std::string why) {
  return std::unexpected(AuditNotFollowed{std::move(why)});
}

/// None where there is no such file.
std::expected<std::optional<std::ifstream>, AuditNotFollowed> open_to_read(const fs::path& file) {
  std::ifstream stream{file, std::ios::binary};
  if (stream.is_open()) return stream;
  if (errno == ENOENT) return std::nullopt;
  return std::unexpected(unreadable(file));
}

std::string text_of(const json::object& record, const char* key) {
  const json::value* const value = record.if_contains(key);
  return value && value->is_string() ? std::string{value->get_string()} : "";
}

/// Takes note of what was found at a start, and of who acknowledged it.
class Faults {
 public:
  void see(const AuditLine& line) {
    const json::object& record = line.record;
    if (const std::string text = text_of(record, "put_aside"); !text.empty())
      all.push_back({line.head.count, text});
    if (text_of(record, "method") == "audit.acknowledge") asked_[line.head.count] = name_in(record);
    const json::value* const of = record.if_contains("of");
    if (!of || !of->is_int64() || text_of(record, "result") != "ok") return;
    const auto asked = asked_.find(static_cast<std::uint64_t>(of->get_int64()));
    if (asked == asked_.end()) return;
    for (AuditFault& fault : all)
      if (fault.number < asked->first && fault.acknowledged_by.empty()) fault.acknowledged_by = asked->second;
  }

  std::vector<AuditFault> all;

 private:
  static std::string name_in(const json::object& record) {
    const json::value* const params = record.if_contains("params");
    const std::string name = params && params->is_object() ? text_of(params->get_object(), "name") : "";
    return name + " (" + text_of(record, "who") + ")";
  }
  std::map<std::uint64_t, std::string> asked_;
};

/// Behind a trail that was put aside: what stands before it is not there to be followed.
bool begins_with_a_fault(const FollowedAudit& file) {
  return !file.faults.empty() && file.faults.front().number == file.base.count + 1;
}

std::string missing_between(const AuditHead& end, const AuditHead& base) {
  if (base.count <= end.count)
    return "record " + std::to_string(base.count + 1) + " follows another one than was written before it";
  return "records " + std::to_string(end.count + 1) + " to " + std::to_string(base.count) + " are missing";
}

/// Where a full file ends, by its last line.
std::expected<AuditHead, AuditNotFollowed> end_of(const FullAuditFile& full) {
  constexpr std::streamoff kLongestLine = 64 * 1024;
  std::ifstream stream{full.file, std::ios::binary | std::ios::ate};
  const std::streamoff size = stream.tellg(), begin = std::max(std::streamoff{0}, size - kLongestLine);
  std::string text(static_cast<std::size_t>(std::max(std::streamoff{0}, size - begin)), '\0');
  stream.seekg(begin);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream) return std::unexpected(unreadable(full.file));
  if (text.empty() || text.back() != '\n') return changed(full.file.string() + " was cut");
  text.pop_back();
  const auto line = text.rfind('\n');
  return AuditHead{full.last, text::sha256_hex(line == std::string::npos ? text : text.substr(line + 1))};
}

std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc{} && read.ptr == text.data() + text.size() ? std::optional{number}
                                                                         : std::nullopt;
}

}  // namespace

fs::path audit_file_of(const fs::path& store) {
  fs::path file = store;
  return file += ".audit";
}

fs::path audit_head_of(fs::path trail) { return trail += ".head"; }

fs::path full_audit_file(const fs::path& trail, std::uint64_t first, std::uint64_t last) {
  fs::path file = trail;
  return file += "." + std::to_string(first) + "-" + std::to_string(last);
}

std::expected<std::vector<FullAuditFile>, std::string> full_audit_files(const fs::path& trail) {
  const std::string start = trail.filename().string() + ".";
  const fs::path folder = trail.has_parent_path() ? trail.parent_path() : fs::path{"."};
  std::vector<FullAuditFile> found;
  std::error_code error;
  fs::directory_iterator at{folder, error};
  for (; !error && at != fs::directory_iterator{}; at.increment(error)) {
    const std::string name = at->path().filename().string();
    const auto hyphen = name.find('-', start.size());
    if (!name.starts_with(start) || hyphen == std::string::npos) continue;
    const auto first = number_in(std::string_view{name}.substr(start.size(), hyphen - start.size()));
    const auto last = number_in(std::string_view{name}.substr(hyphen + 1));
    if (first && last) found.push_back({at->path(), *first, *last});
  }
  if (error == std::errc::no_such_file_or_directory) return found;
  if (error) return std::unexpected(folder.string() + " cannot be read: " + error.message());
  std::ranges::sort(found, {}, &FullAuditFile::first);
  return found;
}

std::expected<std::optional<AuditHead>, AuditNotFollowed> kept_audit_head(const fs::path& trail) {
  const fs::path file = audit_head_of(trail);
  auto stream = open_to_read(file);
  if (!stream) return std::unexpected(stream.error());
  if (!*stream) return std::nullopt;
  std::array<char, 256> text{};  // longer than any head
  (*stream)->read(text.data(), text.size());
  if ((*stream)->bad()) return std::unexpected(unreadable(file));
  const auto size = static_cast<std::size_t>((*stream)->gcount());
  if (size == 0) return std::nullopt;
  auto head = control::read_head({text.data(), size});
  if (!head) return changed(file.string() + " " + head.error());
  return *std::move(head);
}

std::expected<FollowedAudit, AuditNotFollowed> follow_audit_file(const fs::path& file,
                                                                 const std::optional<AuditHead>& base,
                                                                 std::span<const AuditHead> known) {
  auto opened = open_to_read(file);
  if (!opened) return std::unexpected(opened.error());
  std::ifstream stream = *opened ? **std::move(opened) : std::ifstream{};
  const auto begins = control::audit_base(stream);
  FollowedAudit followed;
  followed.base = begins.value_or(base.value_or(AuditHead{}));
  Faults faults;
  std::string not_known;
  const auto end = control::follow_audit(stream, followed.base, [&](const AuditLine& line) {
    followed.ends.push_back(line.end);
    faults.see(line);
    for (const AuditHead& head : known) {
      if (head.count != line.head.count) continue;
      followed.known_to.insert(head.count);
      if (head.hash != line.head.hash && not_known.empty())
        not_known = "record " + std::to_string(head.count) + " is not the one that was written";
    }
  });
  if (stream.bad()) return std::unexpected(unreadable(file));
  if (!end) return changed(end.error());
  if (!not_known.empty()) return changed(not_known);
  followed.end = *end;
  followed.faults = std::move(faults.all);
  return followed;
}

std::expected<std::optional<FollowedAudit>, AuditNotFollowed> follow_last_audit_file(
    const fs::path& trail, std::span<const AuditHead> known) {
  const auto kept = kept_audit_head(trail);
  if (!kept) return std::unexpected(kept.error());
  const auto full = full_audit_files(trail);
  if (!full) return std::unexpected(AuditNotFollowed{full.error(), false});
  std::vector<AuditHead> ends{known.begin(), known.end()};
  if (*kept) ends.push_back(**kept);
  std::uint64_t had = ends.empty() ? 0 : std::ranges::max(ends, {}, &AuditHead::count).count;
  if (!full->empty()) had = std::max(had, full->back().last);
  std::error_code none;
  if (!fs::exists(fs::symlink_status(trail, none))) {
    // The power went as the next file was begun.
    const bool just_full = !full->empty() && had == full->back().last;
    if (had > 0 && !just_full)
      return changed("it is missing, and had " + std::to_string(had) + " records at least");
    if (!*kept) return std::nullopt;
  }
  auto before = AuditHead{};
  if (!full->empty()) {
    auto end = end_of(full->back());
    if (!end) return std::unexpected(end.error());
    before = *std::move(end);
  }
  auto followed = follow_audit_file(trail, before, ends);
  if (!followed) return std::unexpected(followed.error());
  if (followed->base != before && !begins_with_a_fault(*followed))
    return changed(missing_between(before, followed->base));
  const std::uint64_t count = followed->end.count;
  if (!*kept && count > followed->base.count + 1)
    return changed(audit_head_of(trail).string() + " is missing");
  if (count < had)
    return changed("it has " + std::to_string(count) + " records, and had " + std::to_string(had) +
                   ": records are missing at its end");
  if (*kept &&
      (count > (*kept)->count + 1 || ((*kept)->count == followed->base.count && **kept != followed->base)))
    return changed(audit_head_of(trail).string() + " is not its end");
  return *std::move(followed);
}

std::expected<AuditReport, std::string> verify_audit(const fs::path& trail,
                                                     std::span<const AuditHead> known) {
  const auto full = full_audit_files(trail);
  if (!full) return std::unexpected(full.error());
  AuditReport report;
  const auto add = [&](const FollowedAudit& followed) -> std::expected<void, std::string> {
    if (followed.base != report.end && !begins_with_a_fault(followed))
      return std::unexpected(missing_between(report.end, followed.base));
    report.end = followed.end;
    report.faults.insert(report.faults.end(), followed.faults.begin(), followed.faults.end());
    return {};
  };
  for (const FullAuditFile& file : *full) {
    const auto followed = follow_audit_file(file.file, std::nullopt, known);
    if (!followed) return std::unexpected(file.file.string() + ": " + followed.error().why);
    if (followed->base.count + 1 != file.first || followed->end.count != file.last)
      return std::unexpected(file.file.string() + ": has other records than its name says");
    if (const auto added = add(*followed); !added) return std::unexpected(added.error());
  }
  const auto last = follow_last_audit_file(trail, known);
  if (!last) return std::unexpected(last.error().why);
  if (!*last) return std::unexpected("there is none; is this the daemon's store?");
  if (const auto added = add(**last); !added) return std::unexpected(added.error());
  return report;
}

}  // namespace truepose::daemon
