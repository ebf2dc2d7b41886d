#pragma once

#include <pty.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <stdexcept>
#include <string>
#include <utility>

namespace truepose::tools {

/// Standard output of this process as a terminal of 80 columns, while it lives.
class Terminal {
 public:
  Terminal() {
    const winsize size{.ws_row = 24, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
    if (::openpty(&outer_, &inner_, nullptr, nullptr, &size) != 0) throw std::runtime_error("no terminal");
    std::fflush(stdout);
    kept_ = ::dup(STDOUT_FILENO);
    ::dup2(inner_, STDOUT_FILENO);
    ::setenv("TZ", "Europe/Berlin", 1);
    ::tzset();
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal() {
    restore();
    ::close(outer_);
    ::unsetenv("TZ");
  }
  /// What was printed so far; ends it.
  std::string text() {
    std::fflush(stdout);
    restore();
    std::string text;
    std::array<char, 4096> bytes;
    for (ssize_t size = 0; (size = ::read(outer_, bytes.data(), bytes.size())) > 0;)
      text.append(bytes.data(), static_cast<std::size_t>(size));
    std::erase(text, '\r');
    return text;
  }

 private:
  void restore() {
    if (kept_ < 0) return;
    ::dup2(kept_, STDOUT_FILENO);
    ::close(std::exchange(kept_, -1));
    ::close(inner_);
  }
  int outer_ = -1, inner_ = -1, kept_ = -1;
};

}  // namespace truepose::tools
