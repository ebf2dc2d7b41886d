#include "proto/emscon/packets.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "proto/emscon/status.hpp"
#include "tests/proto/emscon/golden_packets.hpp"

namespace truepose::emscon {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Commands and answers that the golden packets do not contain, with every size that the maker's layouts
/// give.
struct Sized {
  std::size_t size;
  std::variant<ClientPacket, TrackerPacket> packet;
};

std::vector<Sized> other_packets() {
  const auto command = [](CommandCode code, Body body = {}) {
    return ClientPacket{Command{code, std::move(body)}};
  };
  const auto answer = [](CommandCode code, Body body = {}) {
    return TrackerPacket{Answer{code, 0, std::move(body)}};
  };
  const Units units{LengthUnit::Inch, AngleUnit::Gon, TemperatureUnit::Fahrenheit, PressureUnit::InHg};
  const StationOrientation orientation{{1, 2, 3}, {4, 5, 6}};
  const Transformation transformation{{1, 2, 3}, {4, 5, 6}, 1.5};
  const Environment environment{21, 990, 40};
  const SystemSettings settings{
      WeatherMonitor::ReadAndCompute, true, false, true, false, true, 3, true, false};
  const StatisticMode extended{StatisticKind::Extended, StatisticKind::Standard};
  const SingleMeasResult2 result2{.v = {1, 2, 3},
                                  .std = {4, 5, 6},
                                  .std_total = 7,
                                  .covariance = {8, 9, 10},
                                  .pointing_error = {11, 12, 13},
                                  .apriori_std = {14, 15, 16},
                                  .apriori_total = 17,
                                  .apriori_covariance = {18, 19, 20},
                                  .environment = environment};
  using enum CommandCode;
  return {
      {12, command(GetSystemStatus)},
      {12, command(ReleaseMotors)},
      {12, command(Park)},
      {12, command(GoBirdBath)},
      {12, command(StopMeasurement)},
      {12, command(GetReflectors)},
      {20, answer(GetTrackerStatus, TrackerStatus{TrackerReadiness::Ready})},
      {36, answer(GetUnits, units)},
      {60, command(SetStationOrientationParams, orientation)},
      {64, answer(GetStationOrientationParams, orientation)},
      {68, command(SetTransformationParams, transformation)},
      {72, answer(GetTransformationParams, transformation)},
      {36, command(SetEnvironmentParams, environment)},
      {40, answer(GetEnvironmentParams, environment)},
      {20, answer(GetMeasurementMode, MeasurementModeChoice{MeasurementMode::ContinuousTime})},
      {16, command(SetCoordinateSystemType, CoordinateSystemChoice{CoordinateSystem::Scc})},
      {20, answer(GetCoordinateSystemType, CoordinateSystemChoice{CoordinateSystem::Scc})},
      {24, answer(GetStationaryModeParams, StationaryModeParams{500, false})},
      {20, answer(GetReflector, ReflectorChoice{3})},
      {28, answer(GetSearchParams, SearchParams{25, 5000})},
      {48, command(SetSystemSettings, settings)},
      {52, answer(GetSystemSettings, settings)},
      {32, answer(GetDirection, Direction{0.5, 1.5})},
      {20, command(SetStatisticMode, extended)},
      {24, answer(GetMeasurementStatusInfo, MeasurementStatusInfo{1, kReflectorFoundBit | kInitializedBit})},
      {164, answer(GetTrackerInfo, TrackerInfo{70, "AT401"})},
      {204, TrackerPacket{result2}},
      {40, TrackerPacket{NivelResult{0, 1, 0.001, -0.002, 20.5}}},
      {48, TrackerPacket{MultiMeasResult{}}}};
}

/// Decodes from a heap block of exactly the packet's size, so that the sanitizer sees a read beyond it.
template <class Decode>
auto decode_exact(const Bytes& bytes, Decode decode) {
  const auto block = std::make_unique<std::uint8_t[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), block.get());
  return decode(std::span<const std::uint8_t>{block.get(), bytes.size()});
}

void expect_decodes_to(const Bytes& bytes, const std::variant<ClientPacket, TrackerPacket>& packet) {
  if (const auto* wanted = std::get_if<ClientPacket>(&packet)) {
    const auto decoded = decode_exact(bytes, decode_client_packet);
    ASSERT_TRUE(decoded) << decoded.error().what;
    EXPECT_EQ(*decoded, *wanted);
  } else {
    const auto decoded = decode_exact(bytes, decode_tracker_packet);
    ASSERT_TRUE(decoded) << decoded.error().what;
    EXPECT_EQ(*decoded, std::get<TrackerPacket>(packet));
  }
}

TEST(EmsconPackets, EncodesEveryGoldenPacketByteForByte) {
  for (const Golden& golden : golden_packets())
    EXPECT_EQ(encode_any(golden.packet), bytes_of(golden.hex)) << golden.name;
}

TEST(EmsconPackets, DecodesEveryGoldenPacket) {
  for (const Golden& golden : golden_packets()) {
    SCOPED_TRACE(golden.name);
    expect_decodes_to(bytes_of(golden.hex), golden.packet);
  }
}

TEST(EmsconPackets, GivesTheOtherPacketsTheMakersSizesAndReadsThemBack) {
  for (const Sized& sized : other_packets()) {
    const Bytes bytes = encode_any(sized.packet);
    SCOPED_TRACE(testing::PrintToString(bytes));
    EXPECT_EQ(bytes.size(), sized.size);
    expect_decodes_to(bytes, sized.packet);
  }
}

TEST(EmsconPackets, RefusesEveryPacketCutAtEveryLength) {
  for (const Golden& golden : golden_packets()) {
    const Bytes whole = bytes_of(golden.hex);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      Bytes cut{whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)};
      EXPECT_FALSE(decode_exact(cut, decode_client_packet)) << golden.name << " at " << size;
      EXPECT_FALSE(decode_exact(cut, decode_tracker_packet)) << golden.name << " at " << size;
      if (size < 4) continue;
      // The same with a size field that agrees: the layout itself must notice.
      cut[0] = static_cast<std::uint8_t>(size);
      if (std::holds_alternative<ClientPacket>(golden.packet)) {
        EXPECT_FALSE(decode_exact(cut, decode_client_packet)) << golden.name << " at " << size;
      } else {
        const auto decoded = decode_exact(cut, decode_tracker_packet);
        EXPECT_FALSE(decoded) << golden.name << " at " << size;
        if (!decoded) {
          EXPECT_LE(decoded.error().offset, size);
        }
      }
    }
  }
}

TEST(EmsconPackets, RefusesAPacketLongerThanItsLayout) {
  Bytes bytes = encode(ReflectorPosResult{});
  bytes.resize(bytes.size() + 4);
  bytes[0] = static_cast<std::uint8_t>(bytes.size());
  const auto decoded = decode_tracker_packet(bytes);
  ASSERT_FALSE(decoded);
  EXPECT_EQ(decoded.error().offset, 36u);
}

TEST(EmsconPackets, SurvivesAnyByteFlippedAnywhere) {
  for (const Golden& golden : golden_packets()) {
    const Bytes whole = bytes_of(golden.hex);
    for (std::size_t at = 0; at < whole.size(); ++at) {
      for (unsigned flip = 1; flip < 256; ++flip) {
        Bytes broken = whole;
        broken[at] = static_cast<std::uint8_t>(broken[at] ^ flip);
        static_cast<void>(decode_exact(broken, decode_client_packet));
        static_cast<void>(decode_exact(broken, decode_tracker_packet));
      }
    }
  }
}

TEST(EmsconPackets, SurvivesRandomBytes) {
  constexpr unsigned kSeed = 20261121;
  RecordProperty("seed", kSeed);
  std::mt19937 random{kSeed};
  for (int round = 0; round < 20000; ++round) {
    Bytes bytes(8 + random() % 200);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    bytes[0] = static_cast<std::uint8_t>(bytes.size());
    bytes[1] = bytes[2] = bytes[3] = 0;
    bytes[4] = static_cast<std::uint8_t>(random() % 12);
    bytes[5] = bytes[6] = bytes[7] = 0;
    static_cast<void>(decode_exact(bytes, decode_client_packet));
    static_cast<void>(decode_exact(bytes, decode_tracker_packet));
  }
}

TEST(EmsconPackets, ReturnsAPacketOfAnUnknownTypeAsUnknown) {
  const Bytes six_d = bytes_of("0c000000 04000000 00000000");
  EXPECT_EQ(decode_tracker_packet(six_d), TrackerPacket{Unknown{4}});
  EXPECT_EQ(decode_client_packet(six_d), ClientPacket{Unknown{4}});
}

TEST(EmsconPackets, KeepsTheCodeOfAnUnknownCommandAndItsAnswer) {
  const Bytes command = bytes_of("10000000 00000000 28230000 01000000");
  EXPECT_EQ(decode_client_packet(command), (ClientPacket{Command{CommandCode{9000}, {}}}));
  const Bytes answer = bytes_of("14000000 00000000 28230000 00000000 01000000");
  EXPECT_EQ(decode_tracker_packet(answer), (TrackerPacket{Answer{CommandCode{9000}, 0, {}}}));
}

TEST(EmsconPackets, AcceptsARefusalWithAndWithoutTheBodyOfTheAnswer) {
  const TrackerPacket refused{Answer{CommandCode::GetReflector, 39, {}}};
  EXPECT_EQ(decode_tracker_packet(bytes_of("10000000 00000000 29000000 27000000")), refused);
  EXPECT_EQ(decode_tracker_packet(bytes_of("14000000 00000000 29000000 27000000 00000000")), refused);
}

TEST(EmsconPackets, RefusesACountOfPointsThatDoesNotFitTheSize) {
  for (const unsigned count : {0u, 1u, 3u, 255u}) {
    Bytes bytes = encode(MultiMeasResult{.points = {{}, {}}});
    bytes[12] = static_cast<std::uint8_t>(count);
    EXPECT_FALSE(decode_tracker_packet(bytes)) << count;
  }
  Bytes negative = encode(MultiMeasResult{.points = {{}, {}}});
  negative[15] = 0x80;
  EXPECT_FALSE(decode_tracker_packet(negative));
}

TEST(EmsconPackets, CarriesNamesBeyondAsciiAndCutsLongOnesBetweenCharacters) {
  const auto through_the_wire = [](const std::string& name) {
    const auto packet =
        decode_tracker_packet(encode(Answer{CommandCode::GetTrackerInfo, 0, TrackerInfo{1, name}}));
    return std::get<TrackerInfo>(std::get<Answer>(packet.value()).body).name;
  };
  EXPECT_EQ(through_the_wire("Würfel \xE2\x82\xAC \xF0\x9F\x8E\xAF"), "Würfel \xE2\x82\xAC \xF0\x9F\x8E\xAF");
  EXPECT_EQ(through_the_wire(std::string(40, 'x')), std::string(32, 'x'));
  EXPECT_EQ(through_the_wire(std::string(31, 'x') + "\xF0\x9F\x8E\xAF"), std::string(31, 'x'));
  EXPECT_EQ(through_the_wire("a\xFF\xC3"), "a\xEF\xBF\xBD\xEF\xBF\xBD");
}

TEST(EmsconPackets, CarriesNamesThatMayBeLoggedAndPrinted) {
  const auto through_the_wire = [](const std::string& name) {
    const auto packet = decode_tracker_packet(
        encode(Answer{CommandCode::GetReflectors, 0, ReflectorEntry{1, 1, {}, 0, name}}));
    return std::get<ReflectorEntry>(std::get<Answer>(packet.value()).body).name;
  };
  EXPECT_EQ(through_the_wire("CCR-1.5in   "), "CCR-1.5in");
  EXPECT_EQ(through_the_wire("a\nforged \x1B[2J\xC2\x9B\x7F"), "a forged \uFFFD[2J\uFFFD\uFFFD");
}

TEST(EmsconStatus, IsDescribedInASentenceWithItsNumber) {
  EXPECT_EQ(describe_status(39), "the tracker is not initialised (status 39)");
  EXPECT_EQ(
      describe_status(12),
      "a parameter is wrong or out of range (status 12): see whether the point is in the tracker's reach");
  EXPECT_EQ(describe_status(10010), "the tracker is not levelled (status 10010): level it");
  EXPECT_EQ(describe_status(24001), "the tracker reports a fault that has no public name (status 24001)");
  EXPECT_EQ(describe_status(-1), "the tracker reports a fault that has no public name (status -1)");
}

}  // namespace
}  // namespace truepose::emscon
