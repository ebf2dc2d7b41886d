#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "proto/control/audit_chain.hpp"

namespace truepose::daemon {

/// Where the audit trail of a store is: next to it. It is written to one file, and where that is long
/// continues in a new one: the old one then has the numbers of its records behind its name, ".1-40000". Its
/// end is in a file of its own, ".head".
std::filesystem::path audit_file_of(const std::filesystem::path& store);
std::filesystem::path audit_head_of(std::filesystem::path trail);
/// The name of a file that is full.
std::filesystem::path full_audit_file(const std::filesystem::path& trail, std::uint64_t first,
                                      std::uint64_t last);

/// A file of a trail that is full.
struct FullAuditFile {
  std::filesystem::path file;
  std::uint64_t first = 0, last = 0;  ///< numbers of its records, by its name
};
/// In the order of their numbers. Error: the folder cannot be read.
std::expected<std::vector<FullAuditFile>, std::string> full_audit_files(const std::filesystem::path& trail);

/// That a daemon found at its start that the trail was changed, and put it aside.
struct AuditFault {
  std::uint64_t number = 0;       ///< of the record that says so
  std::string text;               ///< one phrase
  std::string acknowledged_by{};  ///< empty: not acknowledged
};

/// Why a trail is not followed to its end.
struct AuditNotFollowed {
  std::string why;  ///< one phrase
  bool was_changed =
      true;  ///< it is not what was written; else it cannot be read, and nothing is known of it
};

/// One file of a trail, from its beginning to its end.
struct FollowedAudit {
  control::AuditHead base, end;
  std::vector<std::uint64_t> ends{0};  ///< offsets behind no line, the first, ... the last
  std::vector<AuditFault> faults;
  std::set<std::uint64_t> known_to{};  ///< numbers of the known records that are in it
};
/// @param base   behind which record it begins, where that is known
/// @param known  earlier ends of the trail, by the store or the log: they must be in it
std::expected<FollowedAudit, AuditNotFollowed> follow_audit_file(
    const std::filesystem::path& file, const std::optional<control::AuditHead>& base,
    std::span<const control::AuditHead> known);

/// The end that was kept; none where there is none.
std::expected<std::optional<control::AuditHead>, AuditNotFollowed> kept_audit_head(
    const std::filesystem::path& trail);

/// The file that is written to, up to the end that was kept, or one record past it: a process may have ended
/// between the two writes. None: neither the file nor its end is there.
std::expected<std::optional<FollowedAudit>, AuditNotFollowed> follow_last_audit_file(
    const std::filesystem::path& trail, std::span<const control::AuditHead> known);

/// What a whole trail shows.
struct AuditReport {
  control::AuditHead end;
  std::vector<AuditFault> faults;
};
/// Whether a trail is what was written, in all its files: every record, and none missing at its end.
/// @param known  ends of which the store, or the log of the daemon, knows
/// @return where it ends, and what was found at starts of the daemon; else one phrase, also where it is not
/// there or
///   cannot be read
std::expected<AuditReport, std::string> verify_audit(const std::filesystem::path& trail,
                                                     std::span<const control::AuditHead> known = {});

}  // namespace truepose::daemon
