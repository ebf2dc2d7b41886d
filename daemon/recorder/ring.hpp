#pragma once

#include <array>
#include <boost/crc.hpp>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace truepose::daemon {

/// Texts in slots of a file of one size, which is mapped: when it is full, the oldest slot is emptied. What a
/// process leaves there when it is killed can be read by the next one.
class Ring {
 public:
  static constexpr std::size_t kLeastBytes = std::size_t{1} << 20;
  static constexpr std::size_t kSlotBytes = std::size_t{128} << 10;

  /// Empty, and as large as it will be: the disk cannot become too full for it later.
  /// @return the ring, or one sentence that names the file
  static std::expected<std::unique_ptr<Ring>, std::string> create(const std::filesystem::path& file,
                                                                  std::size_t bytes);
  /// In memory. Throws std::bad_alloc.
  static std::unique_ptr<Ring> in_process(std::size_t bytes);
  /// What another process left.
  static std::expected<std::unique_ptr<Ring>, std::string> open(const std::filesystem::path& file);
  ~Ring();
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;

  /// @param text  at most kSlotBytes: it stays whole
  void append(std::int64_t time_ns, std::string_view text);
  /// What was appended is there for who reads the file.
  void settle();

  struct Block {
    std::int64_t begin_ns = 0;  ///< time of its first text
    std::string_view texts;
  };
  /// From the oldest on. Views hold until the next append().
  std::vector<Block> blocks() const;
  /// Of all texts.
  std::size_t bytes() const { return bytes_; }
  /// Of the oldest text.
  std::optional<std::int64_t> begin_ns() const;

 private:
  struct Slot;
  Ring(void* mapped, std::size_t mapped_bytes);
  Slot& slot(std::uint64_t number) const;
  void begin_slot(std::int64_t time_ns);

  void* mapped_;
  std::size_t mapped_bytes_;
  std::size_t slots_;
  std::uint64_t number_ = 0;     // of the block that is written; the first is 1
  std::string fresh_;            // not settled yet
  boost::crc_32_type checksum_;  // of what is settled
  std::size_t bytes_ = 0;
};

}  // namespace truepose::daemon
