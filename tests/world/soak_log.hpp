#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/clock.hpp"

namespace truepose::world {

struct BrokenPromise {
  std::chrono::milliseconds at;  ///< since the begin
  std::string promise;
  std::vector<std::string> events;  ///< the last before
};

/// "3 04:57:24.093", with the day from 0.
std::string time_text(std::chrono::milliseconds since_begin);

/// What happens in a soak: the last events, the faults under way, and promises that broke.
class SoakLog {
 public:
  using Trace =
      std::function<void(const std::string& time, const std::string& topic, const std::string& text)>;

  SoakLog(const drivers::Clock& clock, Trace trace) : clock_{clock}, trace_{std::move(trace)} {}

  drivers::TimePoint now() const { return clock_.now(); }
  std::chrono::milliseconds since_begin() const;

  void trace(const std::string& topic, const std::string& text);
  void broken(const std::string& promise);
  /// All of them, which leaves none.
  void take_broken(std::vector<std::string>& promises);
  const std::vector<BrokenPromise>& broken_promises() const { return broken_; }

  void begin_fault(std::string_view name);
  void end_fault(std::string_view name);
  /// Whether a fault is under way, or its effects may last.
  bool is_disturbed() const;
  /// Whether one of these faults is under way, or was within this time.
  bool had_fault(std::initializer_list<std::string_view> names, drivers::Duration within) const;

  /// A person moves the arm by the pendant's keys.
  void jogged() { jogged_ = now(); }
  bool was_jogged(drivers::Duration within) const { return jogged_ && now() - *jogged_ < within; }

 private:
  const drivers::Clock& clock_;
  const Trace trace_;
  const drivers::TimePoint begin_ = clock_.now();
  std::deque<std::string> events_;  // the last
  std::vector<BrokenPromise> broken_;
  struct Fault {
    int under_way = 0;
    drivers::TimePoint last_end{};
  };
  std::map<std::string, Fault, std::less<>> faults_;
  std::optional<drivers::TimePoint> jogged_;
};

}  // namespace truepose::world
