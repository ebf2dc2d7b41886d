#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace truepose::control {

/// Longest line either side may send, without its newline.
inline constexpr std::size_t kMaxLine = 64 * 1024;
/// Longest line before session.hello succeeded: strangers get little memory.
inline constexpr std::size_t kMaxLineBeforeHello = 4 * 1024;

/// Cuts a byte stream into lines. A trailing carriage return is dropped and empty lines are skipped.
class LineSplitter {
 public:
  explicit LineSplitter(std::size_t max_line) : max_line_{max_line} {}
  void set_max_line(std::size_t max_line) { max_line_ = max_line; }

  void push(std::string_view bytes) {
    buffer_.erase(0, begin_);
    begin_ = 0;
    buffer_.append(bytes);
  }
  /// The next whole line, without its newline; nothing when there is none yet or the line is too long.
  std::optional<std::string> next() {
    while (true) {
      const auto end = buffer_.find('\n', begin_);
      if (end == std::string::npos || end - begin_ > max_line_) return std::nullopt;
      std::string line = buffer_.substr(begin_, end - begin_);
      begin_ = end + 1;
      if (line.ends_with('\r')) line.pop_back();
      if (!line.empty()) return line;
    }
  }
  /// The line at the front is longer than allowed: there is no way to continue with this stream.
  bool overflowed() const {
    const auto end = buffer_.find('\n', begin_);
    return (end == std::string::npos ? buffer_.size() : end) - begin_ > max_line_;
  }
  /// Bytes of an unfinished line are waiting for their end.
  bool partial() const { return begin_ < buffer_.size(); }

 private:
  std::string buffer_;
  std::size_t begin_ = 0;  ///< first byte not yet given out
  std::size_t max_line_;
};

}  // namespace truepose::control
