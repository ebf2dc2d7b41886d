#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>

#include "drivers/clock.hpp"

namespace truepose::sim {

/// Calls back at moments of a clock. There are no callbacks after its destruction. One thread.
class Alarms {
 public:
  /// @param clock  outlives what runs on the executor
  Alarms(boost::asio::any_io_executor executor, drivers::Clock& clock);
  ~Alarms() { clear(); }
  Alarms(const Alarms&) = delete;
  Alarms& operator=(const Alarms&) = delete;

  /// @param ring  called once on the executor, never from within at(); those of one moment in the order of
  /// at()
  void at(drivers::TimePoint when, std::function<void()> ring);
  /// Cancels all that have not rung.
  void clear();

 private:
  struct Pending;

  std::shared_ptr<Pending> pending_;  ///< shared with the coroutines that sleep until the next
};

}  // namespace truepose::sim
