#pragma once

#include <expected>
#include <filesystem>
#include <string>

#include "daemon/control/file_stamp.hpp"
#include "proto/control/access.hpp"

namespace truepose::daemon {

/// The path of a store's access file, in the store's folder.
std::filesystem::path access_file_of(const std::filesystem::path& store);
/// The entries of an access file; none where there is no file. The error is one sentence.
std::expected<control::AccessEntries, std::string> read_access_file(const std::filesystem::path& file);

/// The users of the access file, which may open sessions. It is read again when it has changed.
class AccessList {
 public:
  /// @param file  need not exist: then it admits no user
  explicit AccessList(std::filesystem::path file) : file_{std::move(file)} {}

  /// Looks at the file, and reads it where it is another than when it was read last.
  /// @return whether it was; or one sentence why it cannot be used, once: what was known before stays
  std::expected<bool, std::string> refresh();
  const control::AccessEntries& entries() const { return entries_; }
  /// Why the file as it is cannot be used; empty: it can.
  const std::string& complaint() const { return complaint_; }

 private:
  std::filesystem::path file_;
  FileStamp stamp_{};      ///< as it was read last
  std::string complaint_;  ///< why it could not be since
  control::AccessEntries entries_;
};

}  // namespace truepose::daemon
