#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/math/random.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "proto/text/random_bytes.hpp"
#include "tests/drivers/memory_network.hpp"
#include "tests/world/history.hpp"
#include "tests/world/rsi_cable.hpp"

namespace truepose::world {

/// A program of the world, with an event loop of its own.
class Process {
 public:
  virtual ~Process() = default;
  /// Runs what is ready. @return whether anything was
  virtual bool poll() = 0;
};

/// Time, network and event loops of a cell, on one thread. Time stands still while anything is ready to run:
/// one seed gives one history.
class World {
 public:
  explicit World(std::uint64_t seed);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Runs until `done`. @return false where nothing is left to run or to wait for before
  bool run(const std::function<bool()>& done);
  /// Plays a person or a script until it returns. Throws what that throws.
  void play(boost::asio::awaitable<void> script);
  boost::asio::awaitable<void> pass(drivers::Duration time);

  void add(Process& process) { processes_.push_back(&process); }
  void remove(Process& process) { std::erase(processes_, &process); }

  /// For programs; drawn from the seed.
  RandomBytes random_bytes();

  static constexpr std::uint16_t kWebPort = 7280;

  drivers::VirtualClock clock;
  boost::asio::io_context outside{1};  ///< devices and people
  drivers::MemoryNetwork network{outside, clock};
  History history{clock};
  RsiCable rsi{clock, history, outside.get_executor()};
  Random random;

 private:
  bool poll(std::size_t loop);

  std::vector<Process*> processes_;
};

}  // namespace truepose::world
