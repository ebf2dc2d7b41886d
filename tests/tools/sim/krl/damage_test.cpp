#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/tools/sim/krl/scripted_eki.hpp"
#include "tests/trials.hpp"

namespace truepose::sim::krl {
namespace {

/// Runs what still loads: it may stop with a fault, but not crash, and time continues.
/// @return whether it loads
bool survives(const std::vector<Source>& sources) {
  if (!load_error(sources).empty()) return false;
  ScriptedCell cell(sources);
  for (const auto& [name, kind] :
       {std::pair{"SPS", InterpreterKind::Submit}, std::pair{"TRUEPOSE_MOTION", InterpreterKind::Robot}}) {
    if (const auto at = cell.bench.program.find_routine(name);
        at && cell.bench.program.routines[*at].parameters.empty())
      cell.bench.start(name, kind);
  }
  cell.bench.host.motion_time = 5ms;
  cell.bench.run_for(10ms);
  cell.connect();
  cell.command(1, 1, 30);
  cell.bench.run_for(10ms);
  cell.bench.host.set("$FLAG[103]", true);
  cell.command(2, 3);
  cell.control(1, 5);
  cell.bench.run_for(20ms);
  EXPECT_EQ(cell.bench.host.now, 40ms);
  return true;
}

TEST(DamagedPrograms, OfEveryLengthAreRefusedOrRun) {
  int loaded = 0;
  const std::size_t step = all_trials() ? 1 : 10;
  for (std::size_t file = 0; file < shipped_sources().size(); ++file) {
    std::vector<Source> sources = shipped_sources();
    const std::string whole = sources[file].text;
    for (std::size_t length = 0; length <= whole.size(); length += step) {
      sources[file].text = whole.substr(0, length);
      loaded += load_error(sources).empty() ? 1 : 0;
    }
  }
  EXPECT_GT(loaded, 0) << "the end of a file is no more than a line";
}

TEST(DamagedPrograms, WithOtherBytesAreRefusedOrRun) {
  int loaded = 0;
  for (std::uint32_t seed = 1; seed <= static_cast<std::uint32_t>(trials(3000)); ++seed) {
    std::mt19937 random(seed);
    std::vector<Source> sources = shipped_sources();
    for (auto changes = 1 + random() % 3; changes > 0; --changes) {
      std::string& text = sources[random() % sources.size()].text;
      // Half of them printable, so that many still load.
      text[random() % text.size()] = static_cast<char>(random() % 2 ? ' ' + random() % 95 : random() % 256);
    }
    SCOPED_TRACE("seed " + std::to_string(seed));
    loaded += survives(sources) ? 1 : 0;
  }
  EXPECT_GT(loaded, trials(300));
}

TEST(DamagedPrograms, WithLinesLeftOutOrExchangedAreRefusedOrRun) {
  int loaded = 0;
  for (std::uint32_t seed = 1; seed <= static_cast<std::uint32_t>(trials(1000)); ++seed) {
    std::mt19937 random(seed);
    std::vector<Source> sources = shipped_sources();
    std::string& text = sources[random() % sources.size()].text;
    const std::size_t from = text.find('\n', random() % text.size());
    const std::size_t to = text.find('\n', std::min(from, text.size() - 1) + 1);
    if (from == std::string::npos || to == std::string::npos) continue;
    const std::string line = text.substr(from, to - from);
    text.erase(from, to - from);
    if (random() % 2) text.insert(text.find('\n', random() % (text.size() / 2)), line);
    SCOPED_TRACE("seed " + std::to_string(seed));
    loaded += survives(sources) ? 1 : 0;
  }
  EXPECT_GT(loaded, trials(100));
}

}  // namespace
}  // namespace truepose::sim::krl
