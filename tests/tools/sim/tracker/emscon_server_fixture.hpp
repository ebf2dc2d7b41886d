#pragma once

#include <gtest/gtest.h>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <exception>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "drivers/clock.hpp"
#include "drivers/leica/emscon_tracker.hpp"
#include "tools/sim/tracker/emscon_server.hpp"

namespace truepose::sim {

inline constexpr unsigned kSeed = 20261121;
inline constexpr double kSigma_mm = 0.01;

class StandingTarget final : public SimulatedTarget {
 public:
  TargetSight look() const override {
    if (on_look) on_look();
    return {p_WS_mm};
  }
  std::optional<Eigen::Vector3d> p_WS_mm = Eigen::Vector3d{2500, 1200, -300};
  std::function<void()> on_look;
};

/// The real driver against the simulated tracker over loopback, a thousand times faster than life.
class EmsconServerTest : public testing::Test {
 protected:
  EmsconServerTest() { RecordProperty("seed", kSeed); }

  Eigen::Vector3d noisy(const Eigen::Vector3d& p_mm, double sigma_mm = kSigma_mm) {
    std::normal_distribution<double> error{0, sigma_mm};
    return p_mm + Eigen::Vector3d{error(random_), error(random_), error(random_)};
  }

  drivers::EmsconOptions options(std::string reflector = "CCR-1.5in") const {
    return {.host = "127.0.0.1",
            .port = server.port(),
            .reflector = std::move(reflector),
            .measure = std::chrono::milliseconds{2000}};
  }

  static drivers::TimePoint soon() { return std::chrono::steady_clock::now() + std::chrono::seconds{60}; }

  /// Runs one call of the driver to its end, concurrently with the server.
  template <class T>
  T run(boost::asio::awaitable<T> call) {
    std::optional<T> result;
    std::exception_ptr thrown;
    boost::asio::co_spawn(io, std::move(call), [&](std::exception_ptr error, T value) {
      thrown = error;
      result = std::move(value);
    });
    while (!result) io.run_one();
    if (thrown) std::rethrow_exception(thrown);
    return *std::move(result);
  }

  auto connect() { return run(tracker.connect(soon())); }
  auto aim(double radius_mm = 50) { return run(tracker.aim(aim_mm, radius_mm, soon())); }
  auto measure() { return run(tracker.measure(soon())); }

  std::mt19937 random_{kSeed};
  drivers::SteadyClock clock;
  boost::asio::io_context io;
  const Machine machine{.io = io.get_executor(), .clock = clock};
  StandingTarget target;
  EmsconServer server{
      machine, target, [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm); }, {.speedup = 1000}};
  drivers::EmsconTracker tracker{io.get_executor(), clock, options()};
  Eigen::Vector3d aim_mm = *target.p_WS_mm + Eigen::Vector3d{10, -5, 8};
};

}  // namespace truepose::sim
