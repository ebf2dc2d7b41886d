#include "proto/rsi/cell_word.hpp"

namespace truepose::rsi {

namespace {

constexpr std::int64_t kEmergencyStop = 1, kGateOpen = 2, kTool = 4, kTools = 256, kCount = kTool * kTools;
constexpr std::int64_t kLastCount = 1000;

}  // namespace

std::optional<CellSignals> cell_signals(std::int64_t word) {
  const std::int64_t count = word / kCount;
  if (word < 0 || count < 1 || count > kLastCount) return std::nullopt;
  const auto tool = static_cast<int>(word % kCount / kTool);
  return CellSignals{.emergency_stop = (word & kEmergencyStop) != 0,
                     .gate_open = (word & kGateOpen) != 0,
                     .tool = tool > 0 ? std::optional{tool} : std::nullopt,
                     .count = static_cast<int>(count)};
}

}  // namespace truepose::rsi
