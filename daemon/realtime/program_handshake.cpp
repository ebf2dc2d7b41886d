#include "daemon/realtime/program_handshake.hpp"

#include <algorithm>
#include <cmath>

namespace truepose::daemon {

std::int64_t gain_for_program(const StreamForProgram& stream) noexcept {
  if (stream.faulted) return rsi::kGainFault;
  if (stream.wanted && stream.modelled && stream.complete) return 100;
  if (!stream.zero) return std::clamp(std::lround(100 * stream.gain), 1L, 99L);
  if (!stream.wanted) return rsi::kGainNotArmed;
  return stream.modelled ? 0 : rsi::kGainNoModel;
}

void ProgramHandshake::listen(const rsi::ProgramSignals& program, Engagement engagement) noexcept {
  const bool armed = engagement == Engagement::Armed;
  if (engagement >= Engagement::On) production_ = armed;
  constexpr std::int64_t kNotSent = 0;  // by a controller that has nothing wired there
  const std::int64_t state = program.state.value_or(kNotSent);
  stopped_ = engagement >= Engagement::On && state != kNotSent && state != rsi::kProgramActive;
  declines_ = armed && program.ask == 0;
}

}  // namespace truepose::daemon
