#include "tests/world/viewers.hpp"

#include <chrono>

#include "tests/world/faults.hpp"

namespace truepose::world {

using namespace std::chrono_literals;

boost::asio::awaitable<void> show(Cell& cell, Client& viewer, Random random, drivers::TimePoint calm) {
  for (;;) {
    co_await cell.world.pass(lasting(random, 1min, 50min));
    const bool begins = !viewer.is_connected();
    if (begins) co_await viewer.connect();
    const double which = random.uniform();
    // Some read slowly what they missed, too.
    if (cell.world.clock.now() > calm || (begins && which < 0.7)) continue;
    if (which < 0.3) {
      viewer.disconnect();
    } else if (which < 0.5) {
      co_await viewer.disconnect_within_a_line();
    } else {
      viewer.read_again_at(cell.world.clock.now() + lasting(random, 10ms, 30min));
    }
  }
}

}  // namespace truepose::world
