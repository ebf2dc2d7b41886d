#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cmath>
#include <tuple>
#include <variant>
#include <vector>

#include "proto/emscon/packet_splitter.hpp"
#include "proto/emscon/packets.hpp"
#include "proto/emscon/status.hpp"
#include "tests/tools/sim/tracker/emscon_server_fixture.hpp"

namespace truepose::sim {
namespace {

namespace asio = boost::asio;

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

using EmsconClientTest = EmsconServerTest;

TEST_F(EmsconClientTest, AnswersTheCommandsOfPublicClientsWithBodiesOfTheirSize) {
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

TEST_F(EmsconClientTest, MeasuresInEveryCoordinateSystemAndUnit) {
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

TEST_F(EmsconClientTest, IsMeasuredByAClientThatNeverSearchesWherePowerLockIsOn) {
  PlainClient client{io, server.port()};
  client.answer(CommandCode::Initialize);
  client.answer(CommandCode::GoPosition, emscon::Position{{1, 0, 0}});  // away from the nest
  EXPECT_EQ(client.answer(CommandCode::StartMeasurement).status, emscon::status::kSystemNotReady);
  client.answer(CommandCode::SetLongSystemParameter, emscon::LongParameter{411, 1});
  while (client.wait_for<emscon::SystemStatusChange>().event != emscon::SystemEvent::MeasurementReady) {
  }
  EXPECT_EQ(client.answer(CommandCode::StartMeasurement).status, 0);
  EXPECT_NEAR(client.wait_for<emscon::SingleMeasResult>().v[0], 2.5, 1e-3);  // in metres, as it comes
}

/// In the order of MuffinSpawn/Leica:bin/command-example.py, whose refraction is set twice because an AT40x
/// passes over a small change.
TEST_F(EmsconClientTest, IsMeasuredInItsNestByAPublicClientThatInitialisesAndNeverAims) {
  PlainClient client{io, server.port()};
  client.answer(CommandCode::SetUnits, emscon::Units{emscon::LengthUnit::Millimeter});
  const auto system = std::get<emscon::SystemStatus>(client.answer(CommandCode::GetSystemStatus).body);
  ASSERT_NE(system.processor, emscon::ProcessorStatus::Initialized);
  ASSERT_EQ(client.answer(CommandCode::Initialize).status, 0);
  client.answer(CommandCode::SetMeasurementMode, emscon::MeasurementModeChoice{});
  client.answer(CommandCode::SetStationaryModeParams, emscon::StationaryModeParams{1000, false});
  client.answer(CommandCode::SetCoordinateSystemType, emscon::CoordinateSystemChoice{CoordinateSystem::Scc});
  client.answer(CommandCode::SetSystemSettings,
                emscon::SystemSettings{.weather = emscon::WeatherMonitor::ReadAndCompute});
  const auto given = std::get<emscon::Refraction>(client.answer(CommandCode::GetRefractionParams).body);
  client.answer(CommandCode::SetRefractionParams, emscon::Refraction{1.000331, given.adm_index});
  client.answer(CommandCode::GetEnvironmentParams);
  client.answer(CommandCode::SetRefractionParams, given);
  ASSERT_EQ(client.answer(CommandCode::StartMeasurement).status, 0);
  const auto in_nest = client.wait_for<emscon::SingleMeasResult>();
  EXPECT_NEAR(in_nest.v[2], kHomeNest_mm.norm(), 5 * kSigma_mm);
}

TEST_F(EmsconClientTest, ComesHomeLockedFromWhereverItWasAndIsFoundThereByASearch) {
  PlainClient client{io, server.port()};
  client.answer(CommandCode::Initialize);
  client.answer(CommandCode::SetUnits, emscon::Units{emscon::LengthUnit::Millimeter});
  client.answer(CommandCode::SetSearchParams, emscon::SearchParams{50, 1000});
  const auto measured = [&] {
    EXPECT_EQ(client.answer(CommandCode::StartMeasurement).status, 0);
    const auto v = client.wait_for<emscon::SingleMeasResult>().v;
    return Eigen::Vector3d{v[0], v[1], v[2]};
  };
  client.answer(CommandCode::GoAndMeasure, emscon::Aim{{2500, 1200, -300}});
  client.wait_for<emscon::SingleMeasResult>();
  ASSERT_EQ(client.answer(CommandCode::GoBirdBath).status, 0);
  EXPECT_LT((measured() - kHomeNest_mm).norm(), 5 * kSigma_mm);

  server.disturb({.moved_mm = {5, 0, 0}});
  EXPECT_LT((measured() - kHomeNest_mm).norm(), 5 * kSigma_mm)
      << "the nest moves with a tracker that is pushed";
  ASSERT_EQ(client.answer(CommandCode::ReleaseMotors).status, 0);
  EXPECT_EQ(client.answer(CommandCode::StartMeasurement).status, emscon::status::kSystemNotReady);
  client.answer(CommandCode::GoPosition, emscon::Position{{5, -190, 5}});
  ASSERT_EQ(client.answer(CommandCode::FindReflector, emscon::SearchDistance{200}).status, 0);
  EXPECT_LT((measured() - kHomeNest_mm).norm(), 5 * kSigma_mm);
}

TEST_F(EmsconClientTest, DrivesLocksAndMeasuresInOneCommand) {
  PlainClient client{io, server.port()};
  client.answer(CommandCode::Initialize);
  EXPECT_EQ(client.answer(CommandCode::GoLastMeasuredPoint).status, emscon::status::kNoLastMeasuredPoint);
  EXPECT_EQ(client.answer(CommandCode::GoAndMeasure, emscon::Aim{{2.49, 1.2, -0.3}}).status, 0);
  EXPECT_NEAR(client.wait_for<emscon::SingleMeasResult>().v[1], 1.2, 1e-3);
  EXPECT_NE(client.answer(CommandCode::GoAndMeasure, emscon::Aim{{2, 1.2, -0.3}}).status, 0)
      << "nothing is there";
}

TEST_F(EmsconClientTest, EndsTheConnectionOfAClientThatExitsAndServesTheNext) {
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
