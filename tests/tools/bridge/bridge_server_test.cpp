// The simulated tracker behind a bridge: the driver before it, and the check of what a bridge promises.
#include "tools/sim/bridge_server.hpp"

#include <gmock/gmock.h>

#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <random>
#include <regex>

#include "drivers/bridge/bridge_tracker.hpp"
#include "proto/bridge/messages.hpp"
#include "proto/control/line_splitter.hpp"
#include "tools/truepose/bridge/conformance.hpp"

namespace truepose::sim {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using drivers::TrackerFault;
using testing::Contains;
using tools::BridgeVerdict, tools::Conformance;

constexpr unsigned kSeed = 20261124;
constexpr double kSigma_mm = 0.01;

class StandingTarget final : public SimulatedTarget {
 public:
  TargetSight look() const override { return {p_WS_mm, false, std::chrono::steady_clock::now()}; }
  std::optional<Eigen::Vector3d> p_WS_mm = Eigen::Vector3d{2500, 1200, -300};
};

/// A connection on which each line that comes may be changed, or left out where the change is empty.
class SpoiltStream final : public drivers::ByteStream {
 public:
  using Spoil = std::function<std::string(std::string line)>;
  SpoiltStream(std::unique_ptr<drivers::ByteStream> stream, Spoil spoil)
      : stream_{std::move(stream)}, spoil_{std::move(spoil)} {}

  asio::awaitable<boost::system::error_code> connect(std::string host, std::uint16_t port) override {
    return stream_->connect(std::move(host), port);
  }
  asio::awaitable<Received> read(std::span<char> into) override {
    while (ready_.empty()) {
      std::array<char, 4096> bytes;
      const auto [error, size] = co_await stream_->read(bytes);
      if (error) co_return Received{error, 0};
      lines_.push({bytes.data(), size});
      while (const auto line = lines_.next()) {
        const std::string spoilt = spoil_(*line);
        if (!spoilt.empty()) ready_ += spoilt + "\n";
      }
    }
    const std::size_t size = std::min(into.size(), ready_.size());
    std::copy_n(ready_.begin(), size, into.begin());
    ready_.erase(0, size);
    co_return Received{{}, size};
  }
  asio::awaitable<boost::system::error_code> write(std::string_view bytes) override {
    return stream_->write(bytes);
  }
  void close() noexcept override {
    stream_->close();
    ready_.clear();
  }
  bool is_open() const override { return stream_->is_open(); }

 private:
  std::unique_ptr<drivers::ByteStream> stream_;
  Spoil spoil_;
  control::LineSplitter lines_{bridge::kMaxLine};
  std::string ready_;
};

class SimulatedBridge : public testing::Test {
 protected:
  SimulatedBridge() { RecordProperty("seed", kSeed); }

  Eigen::Vector3d noisy(const Eigen::Vector3d& p_mm) {
    std::normal_distribution<double> error{0, kSigma_mm};
    return p_mm + Eigen::Vector3d{error(random_), error(random_), error(random_)};
  }
  template <class T>
  T run(asio::awaitable<T> call) {
    std::optional<T> result;
    std::exception_ptr thrown;
    asio::co_spawn(io, std::move(call), [&](std::exception_ptr error, T value) {
      thrown = error;
      result = std::move(value);
    });
    while (!result) io.run_one();
    if (thrown) std::rethrow_exception(thrown);
    return *std::move(result);
  }
  static drivers::TimePoint soon() { return std::chrono::steady_clock::now() + 60s; }
  auto aim(double radius_mm = 50) { return run(tracker.aim(aim_mm, radius_mm, soon())); }
  auto measure() { return run(tracker.measure(soon())); }
  void expect_point(double within_mm = 5 * kSigma_mm) {
    const auto point = measure();
    ASSERT_TRUE(point) << point.error().detail;
    EXPECT_LT((point->p_WS_mm - *target.p_WS_mm).norm(), within_mm);
    EXPECT_GT(point->std_mm.minCoeff(), 0);
  }
  /// What the check finds; each line from the bridge may be spoilt.
  std::vector<BridgeVerdict> examined(SpoiltStream::Spoil spoil = {}, bool at = true) {
    tools::BridgeCheckOptions options{.host = "127.0.0.1", .port = server.port(), .measure = 500ms};
    if (at) options.reflector_mm = aim_mm;
    if (spoil)
      options.stream = [spoil](asio::any_io_executor executor) {
        return std::make_unique<SpoiltStream>(drivers::tcp_stream(std::move(executor)), spoil);
      };
    auto verdicts = run(tools::check_bridge(io.get_executor(), clock, std::move(options)));
    EXPECT_TRUE(verdicts) << verdicts.error();
    return verdicts.value_or(std::vector<BridgeVerdict>{});
  }
  static std::vector<std::string> failed(const std::vector<BridgeVerdict>& verdicts) {
    std::vector<std::string> promises;
    for (const BridgeVerdict& one : verdicts) {
      if (one.outcome != Conformance::Failed) continue;
      promises.push_back(one.promise);
      EXPECT_FALSE(one.found.empty());
      EXPECT_FALSE(one.next.empty());
    }
    return promises;
  }

  std::mt19937 random_{kSeed};
  asio::io_context io;
  StandingTarget target;
  BridgeServer server{io.get_executor(),
                      target,
                      [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm); },
                      {.speedup = 20}};
  drivers::SteadyClock clock;
  drivers::BridgeTracker tracker{
      io.get_executor(), clock, {.host = "127.0.0.1", .port = server.port(), .reflector = "CCR-1.5in"}};
  Eigen::Vector3d aim_mm = *target.p_WS_mm + Eigen::Vector3d{10, -5, 8};
};

TEST_F(SimulatedBridge, IsConnectedAimedMeasuredAndTurnedOver) {
  const auto identity = run(tracker.connect(soon()));
  ASSERT_TRUE(identity) << identity.error().detail;
  EXPECT_EQ(identity->serial, "390793");
  ASSERT_TRUE(aim());
  expect_point();
  const auto turned = run(tracker.turn_over(soon()));
  ASSERT_TRUE(turned) << turned.error().detail;
  expect_point();
  ASSERT_TRUE(aim());
  target.p_WS_mm = Eigen::Vector3d{3000, -800, 700};
  expect_point();
  const auto missed = aim();
  ASSERT_FALSE(missed);
  EXPECT_EQ(missed.error().fault, TrackerFault::NoTarget) << missed.error().detail;
}

TEST_F(SimulatedBridge, EndsAMeasurementWhereTheBeamIsBroken) {
  ASSERT_TRUE(run(tracker.connect(soon())));
  ASSERT_TRUE(aim());
  asio::co_spawn(io, clock.sleep_until(std::chrono::steady_clock::now() + 20ms),
                 [this](std::exception_ptr) { server.beam_break(30ms); });
  const auto broken = measure();
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().fault, TrackerFault::BeamBroken) << broken.error().detail;
  run([](drivers::Clock& clock) -> asio::awaitable<int> {
    const auto later = clock.now() + 50ms;
    co_await clock.sleep_until(later);
    co_return 0;
  }(clock));
  ASSERT_TRUE(aim());
  expect_point();
}

TEST_F(SimulatedBridge, FindsAnotherReflectorWhereItIsToldTo) {
  ASSERT_TRUE(run(tracker.connect(soon())));
  server.disturb({.stray_mm = Eigen::Vector3d{0, 40, 0}});
  ASSERT_TRUE(aim());
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - *target.p_WS_mm - Eigen::Vector3d(0, 40, 0)).norm(), 5 * kSigma_mm);
  server.disturb({});
  ASSERT_TRUE(aim());
  expect_point();
}

TEST_F(SimulatedBridge, KeepsEveryPromise) {
  for (const BridgeVerdict& verdict : examined())
    EXPECT_EQ(verdict.outcome, Conformance::Ok) << verdict.promise << ": " << verdict.found;
}

TEST_F(SimulatedBridge, IsNotMovedWhereNoReflectorIsNamed) {
  const auto verdicts = examined({}, false);
  EXPECT_THAT(failed(verdicts), testing::IsEmpty());
  EXPECT_GT(std::ranges::count(verdicts, Conformance::Skipped, &BridgeVerdict::outcome), 5);
  EXPECT_EQ(server.measurements(), 0U);
}

/// Replaces what is found in a line.
SpoiltStream::Spoil replacing(const std::string& what, const std::string& by) {
  return
      [what = std::regex{what}, by](const std::string& line) { return std::regex_replace(line, what, by); };
}

TEST_F(SimulatedBridge, IsFoundOutWhereItBreaksAPromise) {
  struct Defect {
    SpoiltStream::Spoil spoil;
    const char* promise;
    bool of_the_tracker = true;
  };
  const std::vector<Defect> defects{
      {replacing("\"code\":\"bad-request\"", "\"code\":\"what\""),
       "a line that is no JSON is refused, with id null", false},
      {replacing("\"text\":\"there is no request[^}]*\"", "\"text\":\"\""), "an unknown request is refused",
       false},
      {replacing("\"reflectors\":\\[[^\\]]*\\]", "\"reflectors\":[]"), "status is told", false},
      {replacing("\"protocol\":1", "\"protocol\":2"), "hello is answered", false},
      {replacing("\"id\":[0-9]+,\"ok\":true,\"x\"", "\"id\":1,\"ok\":true,\"x\""), "a point is measured"},
      {replacing("\"x\":2[0-9.]+", "\"x\":2.5"), "a point is measured"},  // metres
      {replacing("\"age_ms\":0", "\"age_ms\":5000"), "a point is measured"},
      {replacing("\"averaged_ms\":[0-9]+", "\"averaged_ms\":10"), "a point is measured"},
      {replacing("\"std_mm\":\\{[^}]*\\},", ""), "a point is measured"},
      {replacing("\"face\":2", "\"face\":1"), "the tracker turns over"},
      {replacing("\"locked\":true", "\"locked\":false"), "a reflector is found where it stands"},
      {replacing("\"event\":\"beam-lost\"", "\"event\":\"oh\""), "a broken beam ends a measurement"},
      {replacing("\"code\":\"busy\"", "\"code\":\"failed\""), "a second measurement is refused as busy"},
  };
  for (const Defect& defect : defects) {
    SCOPED_TRACE(defect.promise);
    EXPECT_THAT(failed(examined(defect.spoil, defect.of_the_tracker)), Contains(defect.promise));
  }
}

}  // namespace
}  // namespace truepose::sim
