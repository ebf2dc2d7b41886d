#pragma once

#include <array>
#include <cstddef>
#include <expected>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "proto/recording/record.hpp"

namespace truepose::recording {

/// The most that a block has: each begins anew, so that one that is lost takes no other along.
inline constexpr std::size_t kMostBlockBytes = 128 * 1024;

/// What a record's bytes and time are told by: the record before it.
struct Before {
  std::int64_t time_ns = 0;
  std::optional<Peer> peer;
  std::map<std::pair<Wire, Kind>, std::string> bytes;
};

/// Puts records into a block, each as what differs from the one of its kind before it.
class BlockWriter {
 public:
  /// @param record  of at most kMostRecordBytes. @return false where the block is full; an empty one has room
  bool append(const Record& record);
  const std::string& bytes() const { return bytes_; }
  bool empty() const { return bytes_.empty(); }
  void clear();

 private:
  std::string bytes_;
  std::string record_;  // kept for its room
  Before before_;
};

/// Takes the records out again.
class BlockReader {
 public:
  /// @param bytes  of a block; outlive the reader
  explicit BlockReader(std::string_view bytes) : rest_{bytes} {}
  /// @return the next record; nothing at the end. Error: what is no record
  std::expected<std::optional<Record>, std::string> next();

 private:
  std::optional<Record> take();

  std::string_view rest_;
  Before before_;
};

}  // namespace truepose::recording
