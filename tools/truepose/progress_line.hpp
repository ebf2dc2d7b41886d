#pragma once

#include <unistd.h>

#include <cstdio>
#include <string_view>

namespace truepose::tools {

/// One line on standard error that is written over and, at the end, wiped away; nothing where no one watches.
class ProgressLine {
 public:
  ProgressLine() = default;
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() {
    if (watched_) std::fputs("\r\x1b[K", stderr);
  }

  /// @param share  of `doing` that is done, 0 to 1
  void show(double share, std::string_view doing) {
    if (!watched_) return;
    std::fprintf(stderr, "\r\x1b[K%3.0f %% of the %.*s", 100 * share, static_cast<int>(doing.size()),
                 doing.data());
    std::fflush(stderr);
  }

 private:
  bool watched_ = isatty(STDERR_FILENO) == 1;
};

}  // namespace truepose::tools
