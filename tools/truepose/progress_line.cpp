#include "tools/truepose/progress_line.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <utility>

#include "core/formatted.hpp"
#include "tools/truepose/terminal.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

using namespace std::chrono_literals;

std::string progress_text(std::string_view doing, double share, std::chrono::duration<double> since) {
  const std::string what{doing};
  if (share <= 0) return what + ": " + duration_text(since.count());
  return formatted("%.0f %% of the %s, %s left", 100 * share, what.c_str(),
                   duration_text(since.count() * (1 - share) / share).c_str());
}

ProgressLine::ProgressLine(std::string doing) : doing_{std::move(doing)} {
  if (!is_terminal(STDERR_FILENO) || manner().quiet) return;
  drawing_ = std::jthread{[this](const std::stop_token& stop) { draw_until_stopped(stop); }};
}

ProgressLine::~ProgressLine() = default;

void ProgressLine::show(double share) {
  const std::lock_guard lock{mutex_};
  share_ = share;
}

void ProgressLine::show(double share, std::string_view doing) {
  const std::lock_guard lock{mutex_};
  if (doing != doing_) begun_ = Clock::now();
  doing_ = doing;
  share_ = share;
}

void ProgressLine::draw_until_stopped(const std::stop_token& stop) {
  constexpr std::chrono::milliseconds kUnshown = 2s, kBetween = 500ms;
  std::unique_lock lock{mutex_};
  changed_.wait_for(lock, stop, kUnshown, [] { return false; });
  while (!stop.stop_requested()) {
    const std::string text = progress_text(doing_, share_, Clock::now() - begun_);
    std::fprintf(stderr, "\r\x1b[K%s\r", text.c_str());
    std::fflush(stderr);
    changed_.wait_for(lock, stop, kBetween, [] { return false; });
    std::fputs("\x1b[K", stderr);
  }
}

}  // namespace truepose::tools
