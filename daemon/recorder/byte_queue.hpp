#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace truepose::daemon {

/// Queue of texts of any size from one writing thread to one reading thread; neither waits, and push() does
/// not allocate. A text that finds no room is dropped and counted.
class ByteQueue {
 public:
  /// All of it is touched, so that who locks the memory of the process locks it.
  explicit ByteQueue(std::size_t bytes) : bytes_(bytes) {}

  /// Writer. @param parts  of one text. @return false where it was dropped
  bool push(std::initializer_list<std::string_view> parts) noexcept;

  /// Reader. @return false where the queue is empty
  bool pop(std::string& text);

  /// Texts lost so far. Any thread.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  using Size = std::uint32_t;
  std::uint64_t put(std::uint64_t at, std::string_view part) noexcept;
  void get(std::uint64_t at, char* to, std::size_t size) const noexcept;

  std::vector<char> bytes_;
  alignas(64) std::atomic<std::uint64_t> head_{0};
  alignas(64) std::atomic<std::uint64_t> tail_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace truepose::daemon
