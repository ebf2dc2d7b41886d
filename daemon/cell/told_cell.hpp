#pragma once

#include "drivers/clock.hpp"
#include "proto/rsi/cell_word.hpp"

namespace truepose::daemon {

/// What the submit program tells by RSI, as long as it runs: its word stays on the wire when it has ended.
class ToldCell {
 public:
  /// @param word  of the newest frame; none where the controller sends none
  void take(std::optional<std::int64_t> word, TimePoint now);
  /// @return nothing where the word has not been counted on within the last second
  const std::optional<rsi::CellSignals>& signals() const { return signals_; }

 private:
  std::optional<int> count_;
  std::optional<TimePoint> counted_;  ///< when the count was last seen to go on
  std::optional<rsi::CellSignals> signals_;
};

}  // namespace truepose::daemon
