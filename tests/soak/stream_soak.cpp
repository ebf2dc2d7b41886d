#include "tests/soak/stream_soak.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "core/math/random.hpp"
#include "daemon/cell/stream_report.hpp"
#include "tests/daemon/stream_cell.hpp"
#include "tests/soak/event_hash.hpp"

namespace truepose::soak {
namespace {

using daemon::StreamCell;
using daemon::StreamCellOptions;

constexpr double kHoursOfACell = 2;  // at most

struct Footprint {
  std::size_t heap_bytes, descriptors;

  static Footprint now() {
    using Folder = std::filesystem::directory_iterator;
    return {mallinfo2().uordblks, static_cast<std::size_t>(std::distance(Folder{"/proc/self/fd"}, Folder{}))};
  }
};

/// The first is of 4 ms and waits for a person after a silence; the next three are otherwise in one or both.
StreamCellOptions options_of(int cell) {
  return {.cycle_ms = cell % 2 == 0 ? 4 : 12,
          .rarity = 10,
          .longest_gap_cycles = 20'000,
          .longest_stall_cycles = 1000,
          .rearms = (cell + 1) / 2 % 2 == 1};
}

/// What an operator is shown, as the daemon makes it of the stream's own status.
std::string shown(const daemon::StreamStatus& status, drivers::TimePoint now) {
  daemon::StreamSurroundings around{.streaming = true, .age = {}, .refused = {}, .model_id = {}};
  if (status.heard) around.age = now - *status.heard;
  return daemon::stream_status(status, {}, around).state;
}

void expect_nothing_old_is_believed(const StreamCell& cell) {
  const auto status = cell.status();
  if (!status || cell.now() - cell.heard() < daemon::kSilence) return;
  EXPECT_NE(shown(*status, cell.now()), "correcting") << "by an old packet";
}

/// @return what it is to last, in virtual time
std::chrono::duration<double> run(StreamCell& cell, std::chrono::duration<double> lasts) {
  const drivers::TimePoint begin = cell.now();
  const auto passed = [&] { return std::chrono::duration<double>{cell.now() - begin}; };
  const auto run_until = [&](std::chrono::duration<double> end) {
    for (int cycle = 1; passed() < end || !cell.status(); ++cycle) {
      cell.cycle();
      if (cycle % 50 == 0) expect_nothing_old_is_believed(cell);
    }
  };
  run_until(lasts / 4);
  const Footprint early = Footprint::now();
  run_until(lasts);
  const Footprint late = Footprint::now();
  EXPECT_LE(late.heap_bytes, early.heap_bytes + 64 * 1024);
  EXPECT_EQ(late.descriptors, early.descriptors);
  return passed();
}

}  // namespace

StreamSoak soak_stream(std::uint64_t seed, double hours) {
  Random random{seed};
  EventHash hash;
  StreamSoak soak;
  const int cells = std::max(2, static_cast<int>(std::ceil(hours / kHoursOfACell)));
  for (int i = 0; i < cells && !testing::Test::HasFailure(); ++i) {
    StreamCell cell{random.next(), options_of(i)};
    cell.on_reply([&](std::string_view reply) { hash.add(reply); });
    soak.hours += run(cell, std::chrono::duration<double, std::ratio<3600>>{hours / cells}) /
                  std::chrono::duration<double, std::ratio<3600>>{1};
    const daemon::StreamHistory history = cell.history();
    EXPECT_LE(history.greatest_step, 1) << history.worst;
    EXPECT_EQ(history.broken, "") << history.worst;
    ++soak.cells;
    soak.add(history);
  }
  soak.hash = hash.value();
  return soak;
}

}  // namespace truepose::soak
