#pragma once

#include <cstdint>

#include "tests/world/cell.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges that only the controller is answered: a second sender of its address is not, where the controller
/// sent before it and goes on.
class SenderJudge {
 public:
  SenderJudge(const Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {}

  void see(const RsiCycle& cycle);

 private:
  const Cell& cell_;
  SoakLog& log_;
  drivers::TimePoint sends_since_{}, sent_{};  // the controller, without a silence
  std::uint64_t second_ = 0;                   // session of the second sender
  drivers::TimePoint second_since_{};
};

}  // namespace truepose::world
