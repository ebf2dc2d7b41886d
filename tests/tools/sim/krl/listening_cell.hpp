#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/tools/sim/krl/scripted_eki.hpp"

namespace truepose::sim::krl {

using Said = std::vector<std::string>;

/// The motion program, past its first motion, greeted and listening.
struct Listening : ScriptedCell {
  explicit Listening(InterpreterKind with = InterpreterKind::Robot) {
    if (with == InterpreterKind::Submit) bench.start("SPS", InterpreterKind::Submit);
    motion = &bench.start("TRUEPOSE_MOTION");
    bench.run_for(1s);
    connect();
    said.clear();
    bench.host.log.clear();
  }

  std::string fault() const { return motion->fault() ? motion->fault()->text() : ""; }
  Said take_said() { return std::exchange(said, {}); }

  Interpreter* motion = nullptr;
};

}  // namespace truepose::sim::krl
