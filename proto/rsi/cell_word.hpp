#pragma once

#include <cstdint>
#include <optional>

namespace truepose::rsi {

/// What the submit program tells of the cell in one number (truepose_state.src, TP_TELL), as Tp.Cell.
struct CellSignals {
  bool emergency_stop = false;  ///< one is pressed
  bool gate_open = false;       ///< operator safety
  std::optional<int> tool;      ///< number of the one in effect, 1..255; none without
  int count = 0;                ///< 1..1000, continues in each of its cycles

  bool operator==(const CellSignals&) const = default;
};

/// @return nothing if the word was not written, or was written by something else
std::optional<CellSignals> cell_signals(std::int64_t word);

}  // namespace truepose::rsi
