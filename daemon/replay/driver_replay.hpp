#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "daemon/replay/driver_run.hpp"
#include "daemon/replay/replay.hpp"
#include "proto/recording/record.hpp"

namespace truepose::daemon {

/// Asks the driver of a robot or a tracker again what the recorded one was asked, from where the recording
/// tells how that stood. After a difference, and where records are missing, it begins anew with the next
/// driver that the recording tells of.
class DriverReplay {
 public:
  explicit DriverReplay(std::string name) { report_.name = std::move(name); }

  /// Of the driver or one of its wires.
  void take(const recording::Record& record) { records_.push_back(record); }
  /// Records are missing here.
  void miss();
  /// After the last record.
  DriverReport report();

 private:
  using Records = std::span<const recording::Record>;

  void replay_taken();
  std::size_t replay_from(Records records, std::string& why_next_is_not_judged);
  void count(const DriverRun& run);
  void pass_over(Records records, const std::string& why);

  std::vector<recording::Record> records_;  // since some were missing
  std::string why_not_yet_;                 // judged
  DriverReport report_;
};

}  // namespace truepose::daemon
