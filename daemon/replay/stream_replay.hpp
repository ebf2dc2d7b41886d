#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>

#include "daemon/realtime/stream_cycle.hpp"
#include "daemon/realtime/stream_memory.hpp"
#include "daemon/replay/replay.hpp"
#include "proto/recording/record.hpp"
#include "proto/recording/recording.hpp"

namespace truepose::daemon {

/// Replays the datagrams of a recording to a stream of corrections. The stream gets the recorded commands at
/// the same times; the replies are compared byte by byte.
///
/// Where the recording begins within the life of a stream, the replayed one continues from the first
/// checkpoint as a restarted daemon would, and is compared from where its correction is ramped in as that
/// was.
class StreamReplay {
 public:
  /// Error: one sentence on why the header does not make a stream.
  static std::expected<StreamReplay, std::string> create(const recording::Header& header);

  void take(const recording::Record& record);
  /// Records are missing here.
  void miss();
  /// The stream ends here: what it has counted is reported.
  void end();
  const StreamReport& report() const { return report_; }

 private:
  using Models = std::map<std::uint64_t, CalibratedCell>;
  StreamReplay(RobotModel nominal, rsi::EthernetConfig ethernet, const StreamOptions& options, Models models)
      : nominal_{std::move(nominal)},
        ethernet_{std::move(ethernet)},
        options_{options},
        models_{std::move(models)} {}

  void begin(const recording::Record& record);
  void command(const recording::Record& record);
  void answer(const recording::Record& sent);
  void compare(const recording::Record& sent, std::string_view reply);
  void take_events(std::int64_t time_ns);
  void explain(const std::string& why_not_compared);

  RobotModel nominal_;
  rsi::EthernetConfig ethernet_;
  StreamOptions options_;
  Models models_;

  std::unique_ptr<StreamMemory> memory_;
  std::unique_ptr<StreamCycle> cycle_;
  recording::Commands commands_;
  bool model_known_ = true;
  bool caught_up_ = false;  ///< replies are those of the recorded stream
  std::optional<recording::Record> datagram_;
  StreamReport report_;
};

}  // namespace truepose::daemon
