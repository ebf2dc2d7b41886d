#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

namespace truepose::tools {

/// Work that takes longer than two seconds, as a line on a terminal's standard error that is written over
/// and, at the end, wiped away: "calibration: 12 s", or, where it is known how much is done, "40 % of the
/// calibration, 18 s left". Nothing with --quiet and where standard error is no terminal.
class ProgressLine {
 public:
  explicit ProgressLine(std::string doing);
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine();

  /// From any thread.
  /// @param share  of the work that is done, 0 to 1
  void show(double share);
  /// The same of one part of the work after another, each with a time of its own.
  void show(double share, std::string_view doing);

 private:
  using Clock = std::chrono::steady_clock;
  void draw_until_stopped(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::string doing_;
  double share_ = 0;
  Clock::time_point begun_ = Clock::now();
  std::jthread drawing_;  ///< on a terminal; the last member, as it uses the others
};

/// "40 % of the calibration, 18 s left"; of a share that is not known yet, 0: "calibration: 12 s".
std::string progress_text(std::string_view doing, double share, std::chrono::duration<double> since);

}  // namespace truepose::tools
