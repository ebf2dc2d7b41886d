#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "daemon/realtime/stream_cycle.hpp"
#include "daemon/realtime/stream_memory.hpp"
#include "daemon/recorder/byte_queue.hpp"
#include "drivers/kuka/rsi_link.hpp"
#include "proto/recording/record.hpp"
#include "proto/recording/recording.hpp"

namespace truepose::daemon {

/// A stream of corrections whose datagrams and replies go into a queue, with all that the replies rest on.
/// Of strangers' datagrams ten a second: a flood must not wash away what the controller sent.
///
/// answer() and finish() belong to the realtime thread: no allocation, lock, log, exception or system call.
class RecordedStream final : public drivers::RsiResponder {
 public:
  /// @param memory  that the cycle began with and keeps up; all outlive the recorded stream
  RecordedStream(StreamCycle& cycle, const StreamMemory& memory, ByteQueue& queue);

  std::string_view answer(const drivers::Datagram& datagram) noexcept override;
  void finish(const drivers::CycleTimes& times) noexcept override;
  void on_no_datagram(drivers::TimePoint until) noexcept override { cycle_.on_no_datagram(until); }

 private:
  bool may_record_foreign(drivers::TimePoint received) noexcept;
  bool checkpoint_is_due(bool replied, StreamState state) noexcept;

  StreamCycle& cycle_;
  const StreamMemory& memory_;
  ByteQueue& queue_;
  drivers::Datagram datagram_;  // that is dealt with
  std::string_view reply_;
  drivers::TimePoint foreign_since_{};
  int foreign_ = 0;  // in this second
  int replies_ = 0;  // since the last checkpoint
};

/// Makes records of what such a queue holds.
class ExchangeReader {
 public:
  /// @param exchange  a text of the queue
  void read(std::string_view exchange, const std::function<void(recording::Record)>& take);

 private:
  std::optional<recording::Commands> commands_;  // recorded last
};

}  // namespace truepose::daemon
