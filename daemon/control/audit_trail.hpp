#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <deque>
#include <expected>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/control/audit_files.hpp"

namespace truepose::daemon {

/// What was commanded, by whom, and what became of it: a trail that only grows, each line bound to the one
/// before by its hash. Blocks; used by one thread at a time. Errors are one phrase.
class AuditTrail {
 public:
  static constexpr std::uint64_t kFullFile = std::uint64_t{16}
                                             << 20U;  ///< bytes, from which on a new file is begun

  /// Goes on behind what is there. A trail that is not what was written is put aside, and a new file begun
  /// behind the last record that the head file, the store or the full files know. Its first record says so. A
  /// trail that cannot be read is left as it is.
  /// @param time   now, RFC 3339
  /// @param known  ends that the trail had, as the store knows
  /// @param full   bytes from which on a new file is begun
  static std::expected<AuditTrail, std::string> open(const std::filesystem::path& file,
                                                     const std::string& time,
                                                     std::span<const control::AuditHead> known = {},
                                                     std::uint64_t full = kFullFile);
  AuditTrail(AuditTrail&& other) noexcept;
  AuditTrail& operator=(AuditTrail&&) = delete;
  ~AuditTrail();

  /// Returns once the record is on the disk, after all that is pending. @return its number; else why it
  /// is not and what to do about that, and nothing of it is
  std::expected<std::uint64_t, std::string> append(boost::json::object record);
  /// The same of what is done in any case: where the disk does not take it, it is kept in memory, and written
  /// before anything that follows ("written_later"). Of so many that there is no room the last one counts the
  /// others.
  struct Taken {
    std::uint64_t number = 0;
    std::string why_pending;  ///< empty: it is on the disk
  };
  Taken take(boost::json::object record);
  /// Writes what is pending. @return why it still cannot be
  std::expected<void, std::string> pay();

  /// Whether its files are still those that it writes to, and as it has left them; else what to do.
  std::expected<void, std::string> in_place() const;
  /// Where they are not: puts aside what is there, and puts back what it still has, or begins a new file
  /// behind it. A record says so.
  /// @param time  now, RFC 3339
  std::expected<void, std::string> restore(const std::string& time);

  /// Records with numbers below `before`, newest first: at most `limit`, and of no more than 48 KiB together.
  std::expected<boost::json::array, std::string> records(std::uint64_t before, std::size_t limit);
  std::uint64_t count() const { return end_.count; }
  const control::AuditHead& end() const { return end_; }
  /// The change that a start has found, until it is acknowledged; empty: none.
  const std::string& fault() const { return fault_; }
  /// A record of the acknowledgement is in the trail.
  void acknowledge() { fault_.clear(); }

 private:
  /// One file of the trail and where its records are in it.
  struct Part {
    int file = -1;
    std::uint64_t first = 1;             ///< number of its first record
    std::vector<std::uint64_t> ends{0};  ///< offsets behind no line, the first, ... the last
  };

  AuditTrail() = default;
  std::expected<void, std::string> open_files(bool must_be_new);
  void close_files();
  std::expected<void, std::string> begin_behind(const control::AuditHead& end, const std::string& why,
                                                const std::string& time);
  std::expected<void, std::string> put_aside(const std::string& time, std::string& aside) const;
  std::expected<std::uint64_t, std::string> write(boost::json::object record);
  /// Takes back what is there of a record that failed. @return errno where it stays
  std::expected<void, int> take_back();
  std::expected<void, std::string> begin_next_file();
  /// The part that has a record.
  std::expected<const Part*, std::string> part_with(std::uint64_t number);

  std::filesystem::path file_;
  std::uint64_t full_ = kFullFile;
  Part last_;  ///< that is written to
  int head_ = -1;
  control::AuditHead end_;
  bool is_taken_back_ = true;  ///< what there was of a record that failed
  std::string fault_;
  std::deque<boost::json::object> pending_;
  std::optional<Part> read_;  ///< the full one that was read last
};

}  // namespace truepose::daemon
