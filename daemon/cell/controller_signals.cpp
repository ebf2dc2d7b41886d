#include "daemon/cell/controller_signals.hpp"

namespace truepose::daemon {

namespace {

using namespace std::chrono_literals;

// A submit interpreter comes round within some 10 to 100 ms.
constexpr drivers::Duration kOldWord = 1s;

}  // namespace

void ControllerSignals::take(std::optional<std::int64_t> word, drivers::TimePoint now) {
  signals_ = word ? rsi::cell_signals(*word) : std::nullopt;
  if (!signals_) {
    count_.reset();
    counted_.reset();
    return;
  }
  if (count_ && *count_ != signals_->count) counted_ = now;
  count_ = signals_->count;
  if (!counted_ || now - *counted_ >= kOldWord) signals_.reset();
}

}  // namespace truepose::daemon
