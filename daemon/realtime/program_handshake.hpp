#pragma once

#include <cstdint>
#include <optional>

#include "proto/recording/recording.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

/// The stream's state that a robot program gets.
struct StreamForProgram {
  bool faulted = false;
  bool wanted = false;    ///< on or armed
  bool modelled = false;  ///< a model is in effect
  bool complete = false;  ///< the correction is all that the model asks for
  bool zero = true;       ///< nothing is corrected
  double gain = 0;        ///< of the ramp, 0..1
};

/// For the program that waits until it is corrected, or is no more: percent, or why not (kGainNotArmed, ...).
std::int64_t gain_for_program(const StreamForProgram& stream) noexcept;

/// What a robot program says of itself. It is stopped and resumed: meanwhile its controller applies no
/// correction, or none in time, and nothing is concluded from that. One that is corrected while it works says
/// when it wants to be.
class ProgramHandshake {
 public:
  using Engagement = recording::Commands::Engagement;

  void listen(const rsi::ProgramSignals& program, Engagement engagement) noexcept;

  bool stopped() const noexcept { return stopped_; }    ///< the correction is held until it continues
  bool declines() const noexcept { return declines_; }  ///< it does not ask to be corrected
  /// It is one that was armed for, and not truepose_motion.
  bool production() const noexcept { return production_; }

 private:
  bool stopped_ = false, declines_ = false, production_ = false;
};

}  // namespace truepose::daemon
