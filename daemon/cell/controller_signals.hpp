#pragma once

#include "drivers/clock.hpp"
#include "proto/rsi/cell_word.hpp"

namespace truepose::daemon {

/// Signals of the submit program, sent by RSI while it runs. Its last word is still sent when the program has
/// ended.
class ControllerSignals {
 public:
  /// @param word  of the newest frame; none where the controller sends none
  void take(std::optional<std::int64_t> word, drivers::TimePoint now);
  /// @return nothing where the word has not been counted on within the last second
  const std::optional<rsi::CellSignals>& signals() const { return signals_; }

 private:
  std::optional<int> count_;
  std::optional<drivers::TimePoint> counted_;  ///< when the count was last seen to continue
  std::optional<rsi::CellSignals> signals_;
};

}  // namespace truepose::daemon
