#pragma once

#include "tests/world/cell.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges that only the controller is answered: a second sender of its address is not, as long as the one
/// that the daemon heard first goes on.
class SenderJudge {
 public:
  SenderJudge(const Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {}

  void see(const RsiCycle& cycle);

 private:
  const Cell& cell_;
  SoakLog& log_;
};

}  // namespace truepose::world
