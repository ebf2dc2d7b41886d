#pragma once

#include <chrono>
#include <string>

#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {

/// A cell that is ready, and a controller that sends every 4 ms until it stops.
struct AWatchedStream : CellTest {
  AWatchedStream() {
    rig.cycle = std::move(stream);  // which the cell refers to
    load();
    sends = false;
    play([this]() -> Wait { co_await connected(); });
    sends = true;
  }
  Wait surroundings() override {
    for (; !over; co_await pass(std::chrono::milliseconds{4})) {
      rig.set_time(clock.now());
      if (counts) count();
      if (!sends) {
        if (read) rig.cycle->on_no_datagram(clock.now());
      } else {
        garbled ? garble() : static_cast<void>(rig.tick());
        if (leaves && rig.stop) sends = false;
      }
    }
  }
  void count() {
    constexpr std::int64_t kOne = 1024, kRound = 1000 * kOne;
    *rig.program.cell += *rig.program.cell < kRound ? kOne : kOne - kRound;
  }
  void garble() {
    rig.ipoc += rig.step;
    rig.send("<Rob Type=\"KUKA\"><IPOC>" + std::to_string(rig.ipoc) + "</IPOC></Rob>");
  }
  Wait streaming() {
    const Answer started = co_await ask("stream.start");
    EXPECT_TRUE(started) << started.error().message;
    co_await pass(std::chrono::seconds{2});
  }
  StreamRig rig;
  bool sends = true, garbled = false;
  bool leaves = false;  // RSI, at the Stop bit
  bool read = true;     // by the realtime thread
  bool counts = false;  // the submit program, in the word that it tells by RSI
};

}  // namespace truepose::daemon
