#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <deque>
#include <expected>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/control/audit_chain.hpp"

namespace truepose::daemon {

/// Where the audit trail of a store is: beside it. Its end is in a second file, ".head" behind its name.
std::filesystem::path audit_file_of(const std::filesystem::path& store);

/// Whether a trail is what was written: every line, and none missing at its end.
/// @return where it ends; else one phrase, also where it is not there or cannot be read
std::expected<control::AuditHead, std::string> verify_audit(const std::filesystem::path& trail);

/// What was commanded, by whom, and what became of it: a file that only grows, each line bound to the one
/// before by its hash. Blocks; used by one thread at a time. Errors are one phrase.
class AuditTrail {
 public:
  /// Goes on behind what is there. A trail that was changed is put aside and a new one begun, which says so;
  /// of one that cannot be read nobody knows that, and it is left as it is.
  /// @param time  now, RFC 3339
  static std::expected<AuditTrail, std::string> open(const std::filesystem::path& file,
                                                     const std::string& time);
  AuditTrail(AuditTrail&& other) noexcept;
  AuditTrail& operator=(AuditTrail&&) = delete;
  ~AuditTrail();

  /// Returns once the record is on the disk, behind all that is owed to it. @return its number; else why it
  /// is not and what to do about that, and nothing of it is
  std::expected<std::uint64_t, std::string> append(boost::json::object record);
  /// The same of what is done in any case: where the disk does not take it, it is kept in memory, and written
  /// before anything that follows ("owed"). Of so many that there is no room the last one counts the others.
  struct Taken {
    std::uint64_t number = 0;
    std::string why_owed;  ///< empty: it is on the disk
  };
  Taken take(boost::json::object record);
  /// Writes what is owed. @return why it still cannot be
  std::expected<void, std::string> pay();

  /// Records with numbers below `before`, newest first: at most `limit`, and of no more than 48 KiB together.
  std::expected<boost::json::array, std::string> records(std::uint64_t before, std::size_t limit) const;
  std::uint64_t count() const { return end_.count; }
  /// Why the trail before this one was put aside; empty: it was not.
  const std::string& put_aside() const { return put_aside_; }

 private:
  AuditTrail() = default;
  std::expected<void, std::string> open_files(const std::filesystem::path& file);
  std::expected<std::uint64_t, std::string> write(boost::json::object record);

  int trail_ = -1, head_ = -1;
  control::AuditHead end_;
  std::vector<std::uint64_t> ends_{0};  ///< offsets behind no line, the first, ... the last
  std::string put_aside_;
  std::deque<boost::json::object> owed_;
};

}  // namespace truepose::daemon
