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
#include <utility>

#include "drivers/clock.hpp"
#include "tools/sim/machine.hpp"
#include "tools/sim/tracker/tracker_beam.hpp"

namespace truepose::sim {

inline constexpr double kSigma_mm = 0.01;

class StandingTarget final : public SimulatedTarget {
 public:
  TargetSight look() const override {
    if (on_look) on_look();
    return {.p_WS_mm = p_WS_mm, .R_WT = R_WT};
  }
  std::optional<Eigen::Vector3d> p_WS_mm = Eigen::Vector3d{2500, 1200, -300};
  Eigen::Matrix3d R_WT = Eigen::Matrix3d::Identity();
  std::function<void()> on_look;
};

/// What a simulated tracker and the driver before it need, over loopback.
class TrackerOverLoopback : public testing::Test {
 protected:
  explicit TrackerOverLoopback(unsigned seed) : random_{seed} {
    RecordProperty("seed", static_cast<int>(seed));
  }

  Eigen::Vector3d noisy(const Eigen::Vector3d& p_mm, double sigma_mm = kSigma_mm) {
    std::normal_distribution<double> error{0, sigma_mm};
    return p_mm + Eigen::Vector3d{error(random_), error(random_), error(random_)};
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

  std::mt19937 random_;
  drivers::SteadyClock clock;
  boost::asio::io_context io;
  const Machine machine{.io = io.get_executor(), .clock = clock};
  StandingTarget target;
  Eigen::Vector3d aim_mm = *target.p_WS_mm + Eigen::Vector3d{10, -5, 8};
};

}  // namespace truepose::sim
