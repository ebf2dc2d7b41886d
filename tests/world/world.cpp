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
    history.add(std::to_string(port) + (to_server ? " in" : " out"), bytes);
  });
}

bool World::run(const std::function<bool()>& done) {
  for (;;) {
    for (bool ran = true; ran;) {
      outside.restart();
      ran = outside.poll() != 0;
      for (Process* const process : processes_) ran |= process->poll();
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
