#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "daemon/log/log.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "drivers/clock.hpp"

namespace truepose::daemon {

/// One event as a line for people.
std::string describe(const StreamEvent& event);

/// Puts the realtime thread's events into words for people. A bad network makes many events: after one of a
/// kind is said, what follows within kQuiet is added up and said in one line at its end. Changes of the state
/// and of the model come from people, and are all said.
class StreamLog {
 public:
  using Say = std::function<void(LogLevel level, const std::string& line)>;
  static constexpr std::chrono::seconds kQuiet{10};

  explicit StreamLog(Say say) : say_{std::move(say)} {}

  void take(const StreamEvent& event, drivers::TimePoint now);
  /// Says what was added up, once its time has come. Call often.
  /// @param dropped  events so far for which there was no room (StreamCycle::dropped_events())
  void pass(std::uint64_t dropped, drivers::TimePoint now);

 private:
  /// Of one kind, since the last line about it.
  struct Silence {
    bool begun = false;
    drivers::TimePoint end;
    std::uint64_t events = 0;
    std::uint64_t values = 0;
  };

  /// After kQuiet: says the sum, and is silent for as long again, or ends where there is none.
  void end_silence(StreamEventKind kind, drivers::TimePoint now);

  Say say_;
  std::array<Silence, kStreamEventKinds> silences_;
  std::uint64_t dropped_ = 0;
};

}  // namespace truepose::daemon
