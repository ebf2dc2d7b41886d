#include "tools/sim/emscon_server.hpp"

#include <gtest/gtest.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cmath>
#include <exception>
#include <optional>
#include <random>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "drivers/clock.hpp"
#include "drivers/leica/emscon_tracker.hpp"
#include "proto/emscon/packet_splitter.hpp"
#include "proto/emscon/packets.hpp"
#include "proto/emscon/status.hpp"
#include "tests/drivers/leica/alarm_clock.hpp"

namespace truepose::sim {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using drivers::TrackerFault;

constexpr unsigned kSeed = 20261121;
constexpr double kSigma_mm = 0.01;

class StandingTarget final : public SimulatedTarget {
 public:
  TargetSight look() const override {
    if (on_look) on_look();
    return {p_WS_mm, false, std::chrono::steady_clock::now()};
  }
  std::optional<Eigen::Vector3d> p_WS_mm = Eigen::Vector3d{2500, 1200, -300};
  std::function<void()> on_look;
};

/// The real driver against the simulated tracker over loopback, a thousand times faster than life.
class SimulatedTracker : public testing::Test {
 protected:
  SimulatedTracker() { RecordProperty("seed", kSeed); }

  Eigen::Vector3d noisy(const Eigen::Vector3d& p_mm, double sigma_mm = kSigma_mm) {
    std::normal_distribution<double> error{0, sigma_mm};
    return p_mm + Eigen::Vector3d{error(random_), error(random_), error(random_)};
  }

  drivers::EmsconOptions options(std::string reflector = "CCR-1.5in") const {
    return {.host = "127.0.0.1", .port = server.port(), .reflector = std::move(reflector), .measure = 2000ms};
  }

  static drivers::TimePoint soon() { return std::chrono::steady_clock::now() + 60s; }

  /// Runs one call of the driver to its end, the server beside it.
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

  auto connect() { return run(tracker.connect(soon())); }
  auto aim(double radius_mm = 50) { return run(tracker.aim(aim_mm, radius_mm, soon())); }
  auto measure() { return run(tracker.measure(soon())); }

  std::mt19937 random_{kSeed};
  asio::io_context io;
  StandingTarget target;
  EmsconServer server{io.get_executor(),
                      target,
                      [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm); },
                      {.speedup = 1000}};
  drivers::SteadyClock clock;
  drivers::EmsconTracker tracker{io.get_executor(), clock, options()};
  Eigen::Vector3d aim_mm = *target.p_WS_mm + Eigen::Vector3d{10, -5, 8};
};

TEST_F(SimulatedTracker, IsConnectedAimedAndMeasuredWithinItsNoise) {
  const auto identity = connect();
  ASSERT_TRUE(identity) << identity.error().detail;
  EXPECT_EQ(identity->serial, "390793");
  EXPECT_EQ(identity->firmware, "3.8.900");
  const auto aimed = aim();
  ASSERT_TRUE(aimed) << aimed.error().detail;
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - *target.p_WS_mm).norm(), 5 * kSigma_mm);
  EXPECT_GT(point->std_mm.minCoeff(), 0);
  EXPECT_LT(point->std_mm.maxCoeff(), 5 * kSigma_mm);
  EXPECT_NEAR(point->temperature_c, 20, 1e-9);
  EXPECT_NEAR(point->pressure_mbar, 1013.25, 1e-9);
  EXPECT_NEAR(point->humidity_percent, 50, 1e-9);
}

TEST_F(SimulatedTracker, FollowsTheTargetWhileItIsSeen) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  target.p_WS_mm = Eigen::Vector3d{3000, -800, 700};
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - *target.p_WS_mm).norm(), 5 * kSigma_mm);
}

TEST_F(SimulatedTracker, ReportsALargeSpreadWhileTheArmMoves) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  target.on_look = [this] { *target.p_WS_mm += Eigen::Vector3d{1, 0, 0}; };
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_GT(point->std_mm.x(), 0.5);
  EXPECT_LT(point->std_mm.y(), 5 * kSigma_mm);
}

TEST_F(SimulatedTracker, LosesThePointToABrokenBeamAndMeasuresAgainAfterAiming) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  int looks = 0;
  target.on_look = [&] {
    if (++looks != 5) return;
    target.p_WS_mm.reset();  // in the middle of the measurement
  };
  const Eigen::Vector3d p_WS_mm = *target.p_WS_mm;
  const auto broken = measure();
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().fault, TrackerFault::BeamBroken) << broken.error().detail;

  target.p_WS_mm = p_WS_mm;
  const auto unlocked = measure();
  ASSERT_FALSE(unlocked) << "a lost reflector is not locked again by itself";
  EXPECT_EQ(unlocked.error().fault, TrackerFault::NoTarget);
  const auto aimed = aim();
  ASSERT_TRUE(aimed) << aimed.error().detail;
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - p_WS_mm).norm(), 5 * kSigma_mm);
}

TEST_F(SimulatedTracker, CannotLockWhileSomethingStandsInTheBeam) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  server.beam_break(10min);
  const auto point = measure();
  ASSERT_FALSE(point);
  const auto aimed = aim();
  ASSERT_FALSE(aimed);
  EXPECT_EQ(aimed.error().fault, TrackerFault::NoTarget) << aimed.error().detail;
}

TEST_F(SimulatedTracker, FindsNothingOutsideTheSearchRadius) {
  ASSERT_TRUE(connect());
  aim_mm = *target.p_WS_mm + Eigen::Vector3d{0, 60, 0};
  const auto missed = aim(50);
  ASSERT_FALSE(missed);
  EXPECT_EQ(missed.error().fault, TrackerFault::NoTarget) << missed.error().detail;
  const auto found = aim(70);
  EXPECT_TRUE(found) << found.error().detail;
}

TEST_F(SimulatedTracker, IsDisconnectedByARestartAndConnectsAgain) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  int looks = 0;
  target.on_look = [&] {
    if (++looks == 5) asio::post(io, [this] { server.restart(); });
  };
  const auto lost = measure();
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().fault, TrackerFault::Disconnected) << lost.error().detail;
  const auto still_lost = aim();
  ASSERT_FALSE(still_lost);
  EXPECT_EQ(still_lost.error().fault, TrackerFault::Disconnected);

  const auto identity = connect();
  ASSERT_TRUE(identity) << identity.error().detail;
  ASSERT_TRUE(aim());
  EXPECT_TRUE(measure());
}

TEST_F(SimulatedTracker, NamesTheReflectorsItKnowsWhenAskedForAnother) {
  drivers::EmsconTracker other{io.get_executor(), clock, options("TBR-0.5in")};
  const auto identity = run(other.connect(soon()));
  ASSERT_FALSE(identity);
  EXPECT_EQ(identity.error().detail,
            "the tracker knows no reflector \"TBR-0.5in\", only: CCR-1.5in, CCR-0.5in");
}

TEST_F(SimulatedTracker, RefusesASecondClientAndServesTheFirstOn) {
  ASSERT_TRUE(connect());
  drivers::EmsconTracker second{io.get_executor(), clock, options()};
  const auto refused = run(second.connect(soon()));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, TrackerFault::Busy) << refused.error().detail;
  EXPECT_TRUE(aim());

  tracker.disconnect();
  EXPECT_TRUE(run(second.connect(soon())));
}

TEST_F(SimulatedTracker, StopsAMeasurementThatRanIntoItsDeadline) {
  drivers::EmsconOptions slow = options();
  slow.measure = 24h;  // more than a minute of the simulation's time
  drivers::AlarmClock alarm{io};
  drivers::EmsconTracker patient{io.get_executor(), alarm, slow};
  ASSERT_TRUE(run(patient.connect({})));
  ASSERT_TRUE(run(patient.aim(aim_mm, 50, {})));
  int looks = 0;
  target.on_look = [&] {
    if (++looks == 50) alarm.ring();
  };
  const auto late = run(patient.measure({}));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().fault, TrackerFault::Timeout) << late.error().detail;
  const auto aimed = run(patient.aim(aim_mm, 50, {}));
  EXPECT_TRUE(aimed) << aimed.error().detail;
}

TEST_F(SimulatedTracker, MeasuresWhereTheTrackerWasPushedAndWhatItSaysIsWrong) {
  ASSERT_TRUE(connect());
  server.disturb({.moved_mm = {5, 0, 0}, .bias_mm = {0, 2, 0}, .std_mm = 50, .temperature_c = 55});
  ASSERT_TRUE(aim());
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - *target.p_WS_mm - Eigen::Vector3d(5, 2, 0)).norm(), 5 * kSigma_mm);
  EXPECT_NEAR(point->std_mm.x(), 50, 1e-9);
  EXPECT_NEAR(point->temperature_c, 55, 1e-9);
  server.disturb({.temperature_c = -273});
  const auto cold = measure();
  ASSERT_FALSE(cold);
  EXPECT_NE(cold.error().detail.find("-273 C"), std::string::npos) << cold.error().detail;
}

/// A tracker that measures nearly without noise through the air of a high and hot place.
class TrackerInThinAir : public SimulatedTracker {
 protected:
  static constexpr Air kThin{34, 790, 65};

  /// How much too long the distance to the reflector comes out.
  double excess(bool weather_station, std::function<std::expected<Air, std::string>()> told) {
    TrackerServerOptions setup{.speedup = 1000};
    setup.instrument = {.weather_station = weather_station, .air = kThin};
    EmsconServer there{io.get_executor(), target,
                       [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm, 1e-7); }, setup};
    drivers::EmsconOptions to = options();
    to.port = there.port();
    to.air = std::move(told);
    drivers::EmsconTracker of{io.get_executor(), clock, to};
    there.disturb({.temperature_c = kThin.temperature_c,
                   .pressure_mbar = kThin.pressure_mbar,
                   .humidity_percent = kThin.humidity_percent});
    EXPECT_TRUE(run(of.connect(soon())));
    EXPECT_TRUE(run(of.aim(aim_mm, 50, soon())));
    const auto point = run(of.measure(soon()));
    EXPECT_TRUE(point) << point.error().detail;
    return point->p_WS_mm.norm() / target.p_WS_mm->norm() - 1;
  }
};

TEST_F(TrackerInThinAir, IsRightToATenthOfAMicrometreAMetreOnceItIsToldTheAir) {
  EXPECT_NEAR(excess(false, [] { return kThin; }), 0, 1e-7);
  EXPECT_NEAR(excess(true, [] { return kThin; }), 0, 1e-7);
}

TEST_F(TrackerInThinAir, IsWrongByWhatItTakesForItsAir) {
  // By the formula for the shop floor (Stone, Zimmerman), whose phase index scales alike.
  const double thin = 7.86e-4 * 79 / (273 + 34) - 1.5e-11 * 65 * (34 * 34 + 160);
  const double usual = 7.86e-4 * 101.325 / (273 + 20) - 1.5e-11 * 50 * (20 * 20 + 160);
  EXPECT_NEAR(excess(false, [] { return Air{20, 1013.25, 50}; }), thin - usual, 2e-6);
  EXPECT_GT(std::abs(excess(false, {})), 50e-6) << "what was in it came from a place by the sea";
}

TEST_F(TrackerInThinAir, NeedsNoTellingWhereItHasAWeatherStation) { EXPECT_NEAR(excess(true, {}), 0, 1e-9); }

/// One that errs in its directions, and sees other reflectors beside the arm's.
class OddTracker : public SimulatedTracker {
 protected:
  OddTracker() {
    TrackerServerOptions setup{.speedup = 1000};
    setup.instrument.aiming = {.collimation = 40e-6, .tilt = 20e-6, .index = -30e-6};
    setup.instrument.nests_mm = {{2500, -700, -300}, {1500, 900, -800}};
    odd.emplace(
        io.get_executor(), target, [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm, 1e-7); }, setup);
    drivers::EmsconOptions to = options();
    to.port = odd->port();
    driver.emplace(io.get_executor(), clock, to);
    EXPECT_TRUE(run(driver->connect(soon())));
  }
  Eigen::Vector3d point() {
    const auto measured = run(driver->measure(soon()));
    EXPECT_TRUE(measured) << measured.error().detail;
    return measured->p_WS_mm;
  }
  std::optional<EmsconServer> odd;
  std::optional<drivers::EmsconTracker> driver;
};

TEST_F(OddTracker, ErrsTheOtherWayInItsOtherFace) {
  ASSERT_TRUE(run(driver->aim(aim_mm, 50, soon())));
  const Eigen::Vector3d face1_mm = point();
  const auto turned = run(driver->turn_over(soon()));
  ASSERT_TRUE(turned) << turned.error().detail;
  const Eigen::Vector3d face2_mm = point();
  EXPECT_GT((face1_mm - *target.p_WS_mm).norm(), 0.08);
  EXPECT_LT(((face1_mm + face2_mm) / 2 - *target.p_WS_mm).norm(), 1e-4);
  ASSERT_TRUE(run(driver->aim(aim_mm, 50, soon())));
  EXPECT_LT((point() - face1_mm).norm(), 1e-5) << "aimed anew it is in face 1 again";
}

TEST_F(OddTracker, LocksToTheReflectorThatItIsAimedAt) {
  ASSERT_TRUE(run(driver->aim({2510, -690, -310}, 50, soon())));
  EXPECT_LT((point() - Eigen::Vector3d(2500, -700, -300)).norm(), 0.2);
  target.p_WS_mm.reset();
  EXPECT_LT((point() - Eigen::Vector3d(2500, -700, -300)).norm(), 0.2) << "it needs no arm for that";
  const auto arms = run(driver->aim(aim_mm, 50, soon()));
  ASSERT_FALSE(arms);
  EXPECT_EQ(arms.error().fault, TrackerFault::NoTarget);
}

TEST_F(SimulatedTracker, IsBusyForAnotherAndThenServesOn) {
  ASSERT_TRUE(connect());
  server.disturb({.busy = true});
  const auto refused = aim();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, TrackerFault::Busy) << refused.error().detail;
  server.disturb({});
  EXPECT_TRUE(aim());
}

TEST_F(SimulatedTracker, IsSilentAndItsClientWaitsNoLongerThanItWasGiven) {
  drivers::AlarmClock alarm{io};
  drivers::EmsconTracker patient{io.get_executor(), alarm, options()};
  ASSERT_TRUE(run(patient.connect({})));
  ASSERT_TRUE(run(patient.aim(aim_mm, 50, {})));
  server.disturb({.silent = true});
  int looks = 0;
  target.on_look = [&] {
    if (++looks % 50 == 0) alarm.ring();
  };
  const auto unanswered = run(patient.measure({}));
  ASSERT_FALSE(unanswered);
  EXPECT_EQ(unanswered.error().fault, TrackerFault::Timeout) << unanswered.error().detail;
}

TEST_F(SimulatedTracker, MeasuresThroughAStormOfReports) {
  server.disturb({.storms = true});
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  EXPECT_TRUE(measure());
}

/// A client that says what it likes, and hears all of it.
class PlainClient {
 public:
  explicit PlainClient(asio::io_context& io, std::uint16_t port) : io_{io}, socket_{io} {
    socket_.connect({asio::ip::address_v4::loopback(), port});
  }

  /// Sends a command. @return the bytes of its answer; what else comes is kept in `others`
  std::vector<std::uint8_t> ask(const emscon::Command& command) {
    asio::write(socket_, asio::buffer(emscon::encode(command)));
    for (;;) {
      std::vector<std::uint8_t> packet = next();
      if (packet.empty()) return packet;
      const auto decoded = emscon::decode_tracker_packet(packet);
      const auto* answer = std::get_if<emscon::Answer>(&decoded.value());
      if (answer && answer->code == command.code) return packet;
      others.push_back(*decoded);
    }
  }

  emscon::Answer answer(emscon::CommandCode code, emscon::Body body = {}) {
    const std::vector<std::uint8_t> packet = ask({code, std::move(body)});
    return std::get<emscon::Answer>(emscon::decode_tracker_packet(packet).value());
  }

  /// The next packet; empty where the connection has ended.
  std::vector<std::uint8_t> next() {
    for (;;) {
      if (const auto packet = splitter_.next().value()) return {packet->begin(), packet->end()};
      std::optional<std::size_t> size;
      boost::system::error_code ended;
      socket_.async_read_some(asio::buffer(buffer_), [&](boost::system::error_code error, std::size_t read) {
        ended = error;
        size = read;
      });
      while (!size) io_.run_one();
      if (ended) return {};
      splitter_.push({buffer_.data(), *size});
    }
  }

  template <class T>
  T wait_for() {
    for (;;) {
      const auto decoded = emscon::decode_tracker_packet(next());
      if (const auto* found = std::get_if<T>(&decoded.value())) return *found;
    }
  }

  std::vector<emscon::TrackerPacket> others;

 private:
  asio::io_context& io_;
  asio::ip::tcp::socket socket_;
  emscon::PacketSplitter splitter_;
  std::array<std::uint8_t, 4096> buffer_{};
};

using emscon::CommandCode;
using emscon::CoordinateSystem;

TEST_F(SimulatedTracker, AnswersTheCommandsOfPublicClientsWithBodiesOfTheirSize) {
  PlainClient client{io, server.port()};
  ASSERT_EQ(client.answer(CommandCode::Initialize).status, 0);
  const std::vector<std::tuple<CommandCode, emscon::Body, std::size_t>> asked{
      {CommandCode::GetRefractionParams, {}, 32},
      {CommandCode::GetContinuousTimeModeParams, {}, 32},
      {CommandCode::GetContinuousDistanceModeParams, {}, 36},
      {CommandCode::GetAdmParams, {}, 32},
      {CommandCode::GetStatisticMode, {}, 24},
      {CommandCode::GetFace, {}, 20},
      {CommandCode::GetLongSystemParameter, emscon::ParameterId{410}, 24},
      {CommandCode::GetDoubleSystemParameter, emscon::ParameterId{1000}, 28},
      {CommandCode::GetObjectTemperature, {}, 24},
      {CommandCode::GetAt4xxInfo, {}, 184},
      {CommandCode::GetSystemSoftwareVersion, {}, 80},
      {CommandCode::CheckBirdBath, {}, 64},
      {CommandCode::GetSystemStatus, {}, 56},
      {CommandCode::GetTrackerInfo, {}, 164},
      {CommandCode::GoBirdBath2, emscon::TurnDirection{true}, 16},
      {CommandCode::ClearCommandQueue, emscon::QueueChoice{1}, 16},
      {CommandCode::ChangeFace, {}, 16},
      {CommandCode::PointLaserHvd, emscon::Aim{{0.1, 1.5, 3.0}}, 16},
      {CommandCode::SetRefractionParams, emscon::Refraction{1.0002, 1.0003}, 16},
  };
  for (const auto& [code, body, size] : asked) {
    const std::vector<std::uint8_t> packet = client.ask({code, body});
    EXPECT_EQ(packet.size(), size) << static_cast<int>(code);
    EXPECT_EQ(std::get<emscon::Answer>(emscon::decode_tracker_packet(packet).value()).status, 0)
        << static_cast<int>(code);
  }
  EXPECT_EQ(std::get<emscon::Refraction>(client.answer(CommandCode::GetRefractionParams).body).adm_index,
            1.0003);
  EXPECT_EQ(std::get<emscon::FaceAnswer>(client.answer(CommandCode::GetFace).body).face, 2);
}

TEST_F(SimulatedTracker, MeasuresInEveryCoordinateSystemAndUnit) {
  PlainClient client{io, server.port()};
  client.answer(CommandCode::Initialize);
  client.answer(CommandCode::SetUnits,
                emscon::Units{emscon::LengthUnit::Millimeter, emscon::AngleUnit::Degree});
  client.answer(CommandCode::SetSearchParams, emscon::SearchParams{50, 1000});
  const Eigen::Vector3d p = *target.p_WS_mm;  // 2500, 1200, -300
  const double across = 2773.0849, distance = 2789.2651, hz = 25.641006, zenith = 96.174399;
  const std::vector<std::pair<CoordinateSystem, Eigen::Vector3d>> expected{
      {CoordinateSystem::Rhr, p},
      {CoordinateSystem::LhrX, {-2500, 1200, -300}},
      {CoordinateSystem::LhrY, {2500, -1200, -300}},
      {CoordinateSystem::LhrZ, {2500, 1200, 300}},
      {CoordinateSystem::Ccw, {-hz, across, -300}},
      {CoordinateSystem::Ccc, {hz, across, -300}},
      {CoordinateSystem::Scw, {-hz, zenith, distance}},
      {CoordinateSystem::Scc, {hz, zenith, distance}}};
  for (const auto& [system, values] : expected) {
    SCOPED_TRACE(static_cast<int>(system));
    EXPECT_EQ(
        client.answer(CommandCode::SetCoordinateSystemType, emscon::CoordinateSystemChoice{system}).status,
        0);
    EXPECT_EQ(
        client.answer(CommandCode::GoPosition, emscon::Position{{values[0], values[1], values[2]}}).status,
        0);
    ASSERT_EQ(client.answer(CommandCode::FindReflector, emscon::SearchDistance{3000}).status, 0)
        << "aimed elsewhere";
    ASSERT_EQ(client.answer(CommandCode::StartMeasurement).status, 0);
    const auto result = client.wait_for<emscon::SingleMeasResult>();
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(result.v[i], values[static_cast<Eigen::Index>(i)], 0.06) << i;
      const bool angle = values[static_cast<Eigen::Index>(i)] != p[static_cast<Eigen::Index>(i)] &&
                         std::abs(values[static_cast<Eigen::Index>(i)]) < 100;
      EXPECT_LT(result.std[i], angle ? 0.002 : 0.1) << i;
      EXPECT_GT(result.std[i], 0) << i;
    }
  }
  EXPECT_EQ(
      client.answer(CommandCode::SetCoordinateSystemType, emscon::CoordinateSystemChoice{CoordinateSystem{8}})
          .status,
      12);
}

TEST_F(SimulatedTracker, IsMeasuredByAClientThatNeverSearchesWherePowerLockIsOn) {
  PlainClient client{io, server.port()};
  client.answer(CommandCode::Initialize);
  client.answer(CommandCode::GoBirdBath);
  EXPECT_EQ(client.answer(CommandCode::StartMeasurement).status, emscon::status::kSystemNotReady);
  client.answer(CommandCode::SetLongSystemParameter, emscon::LongParameter{411, 1});
  while (client.wait_for<emscon::SystemStatusChange>().event != emscon::SystemEvent::MeasurementReady) {
  }
  EXPECT_EQ(client.answer(CommandCode::StartMeasurement).status, 0);
  EXPECT_NEAR(client.wait_for<emscon::SingleMeasResult>().v[0], 2.5, 1e-3);  // in metres, as it comes
}

TEST_F(SimulatedTracker, DrivesLocksAndMeasuresInOneCommand) {
  PlainClient client{io, server.port()};
  client.answer(CommandCode::Initialize);
  EXPECT_EQ(client.answer(CommandCode::GoLastMeasuredPoint).status, emscon::status::kNoLastMeasuredPoint);
  EXPECT_EQ(client.answer(CommandCode::GoAndMeasure, emscon::Aim{{2.49, 1.2, -0.3}}).status, 0);
  EXPECT_NEAR(client.wait_for<emscon::SingleMeasResult>().v[1], 1.2, 1e-3);
  EXPECT_NE(client.answer(CommandCode::GoAndMeasure, emscon::Aim{{2, 1.2, -0.3}}).status, 0)
      << "nothing is there";
}

TEST_F(SimulatedTracker, EndsTheConnectionOfAClientThatExitsAndServesTheNext) {
  {
    PlainClient client{io, server.port()};
    EXPECT_EQ(client.answer(CommandCode::ExitApplication).status, 0);
    EXPECT_TRUE(client.next().empty());
  }
  const auto identity = connect();
  EXPECT_TRUE(identity) << identity.error().detail;
}

}  // namespace
}  // namespace truepose::sim
