#pragma once

#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/replay/driver_script.hpp"
#include "daemon/replay/replay.hpp"
#include "daemon/replay/replayed_driver.hpp"
#include "daemon/replay/replayed_stream.hpp"
#include "drivers/mock/virtual_clock.hpp"

namespace truepose::daemon {

/// A clock that is late by as much as a machine was that needed time for its own steps, of which a recording
/// says nothing.
class LateClock final : public drivers::Clock {
 public:
  LateClock(drivers::Clock& clock, drivers::Duration late) : clock_{clock}, late_{late} {}
  drivers::TimePoint now() const override { return clock_.now() + late_; }
  boost::asio::awaitable<void> sleep_until(drivers::TimePoint when) override {
    return clock_.sleep_until(when);
  }

 private:
  drivers::Clock& clock_;
  drivers::Duration late_;
};

/// Does to a driver, in virtual time, what was done to the recorded one, and compares what it does: what it
/// sends, byte by byte, when it closes a connection or asks for the air, and how its calls end.
///
/// The order of the records holds: a driver that owes something is given its timers first, and otherwise what
/// came is put in before a timer that is due within half a second of it. So a timer that was late when it was
/// recorded changes nothing.
class DriverRun {
 public:
  /// @param script  outlives the run. @param late  by how much the driver's clock is
  DriverRun(const DriverScript& script, drivers::Duration late);
  ~DriverRun();

  /// Up to the end of the script, or to the first difference.
  void run();

  std::uint64_t made() const { return made_; }            ///< calls
  std::uint64_t same() const { return same_; }            ///< of these, that ended as they had
  std::uint64_t cancelled() const { return cancelled_; }  ///< by who had made them
  std::uint64_t unended() const { return unended_; }      ///< when the script ends
  const std::optional<ReplayNote>& difference() const { return difference_; }
  /// Why the run ended before the script, without a difference; empty: it did not.
  const std::string& why_left() const { return why_left_; }
  /// The steps that it came to.
  std::size_t end() const { return cursor_; }

 private:
  struct Channel {
    ReplayedStream* stream = nullptr;  // the driver's
    std::deque<std::size_t> expected;
    bool connected = false, write_fails = false;
  };
  using Kind = recording::Kind;
  using Wire = recording::Wire;

  bool step();
  void come_to_next();
  void do_next();
  void call(const DriverScript::Step& step);
  void cancel(std::uint64_t number);
  bool is_awaited(const DriverScript::Step& step) const;
  void settle();

  void hear(Wire wire, Kind kind, std::string_view bytes);
  void hear_done(std::deque<std::size_t>& expected, Wire wire, Kind kind, std::string_view bytes);
  void hear_outcome(Wire wire, std::string_view bytes);
  ToldAir tell_air();
  void mark(std::size_t step);
  void surprise(std::optional<std::size_t> expected, Wire wire, const std::string& now);
  void differ(std::optional<std::size_t> expected, Wire wire, const std::string& now);
  void miss_what_is_owed();
  const DriverScript::Step* next_done_to() const;
  bool is_over() const { return difference_ || !why_left_.empty(); }

  const DriverScript& script_;
  std::map<Wire, Channel> channels_;
  std::deque<std::size_t> air_;
  std::size_t cursor_ = 0;       // the steps before it are done, but for what is owed
  std::set<std::size_t> owed_;   // that the driver should have done
  std::set<std::size_t> early_;  // that it has done before the cursor came there
  std::map<std::uint64_t, std::unique_ptr<boost::asio::cancellation_signal>> under_way_;
  std::uint64_t made_ = 0, same_ = 0, cancelled_ = 0, unended_ = 0;
  std::optional<ReplayNote> difference_;
  std::string why_left_;

  drivers::VirtualClock clock_;
  LateClock late_;
  boost::asio::io_context io_;
  std::unique_ptr<ReplayedDriver> driver_;
};

}  // namespace truepose::daemon
