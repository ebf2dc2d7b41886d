#include "tests/world/world.hpp"

#include <chrono>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "drivers/net/spawn.hpp"

namespace truepose::world {

namespace {

constexpr std::chrono::hours kBegin{490'000};  // in 2025, as UTC

}  // namespace

World::World(std::uint64_t seed) : clock{drivers::TimePoint{kBegin}}, random{seed} {
  network.on_bytes([this](std::uint16_t port, bool to_server, std::string_view bytes) {
    if (port == kWebPort) return;  // its metrics have memory and time of the real process
    history.add(std::to_string(port) + (to_server ? " in" : " out"), bytes);
  });
}

/// @param loop  0: of devices and people; else of a process
bool World::poll(std::size_t loop) {
  if (loop > 0) return processes_[loop - 1]->poll();
  outside.restart();
  return outside.poll() != 0;
}

bool World::run(const std::function<bool()>& done) {
  for (;;) {
    std::size_t loop = 0;
    // Until each has found nothing ready since the last one that did something.
    for (std::size_t idle = 0; idle <= processes_.size(); loop = (loop + 1) % (processes_.size() + 1)) {
      idle = poll(loop) ? 1 : idle + 1;
      if (done()) return true;
    }
    if (!clock.next_wake()) return false;
    clock.wake_first();
  }
}

void World::play(boost::asio::awaitable<void> script) {
  bool ended = false;
  std::exception_ptr thrown;
  net::spawn(outside.get_executor(), std::move(script), [&](std::exception_ptr failed) {
    thrown = std::move(failed);
    ended = true;
  });
  run([&] { return ended; });
  if (thrown) std::rethrow_exception(thrown);
}

boost::asio::awaitable<void> World::pass(drivers::Duration time) {
  const drivers::TimePoint then = clock.now() + time;
  co_await clock.sleep_until(then);
}

RandomBytes World::random_bytes() {
  return [this](std::span<unsigned char> bytes) {
    for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random.next());
  };
}

}  // namespace truepose::world
