#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <random>
#include <vector>

#include "core/math/angles.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "proto/rsi/gain_word.hpp"
#include "tests/allocations.hpp"

namespace truepose::rsi {
namespace {

constexpr std::string_view kRobotGolden =
    R"(<Rob Type="KUKA"><RIst X="1765.0000" Y="-0.1250" Z="1910.0000" A="179.9999" B="89.5000" C="-180.0000"/>)"
    R"(<RSol X="1765.0000" Y="0.0000" Z="1910.0000" A="180.0000" B="89.5000" C="-180.0000"/>)"
    R"(<AIPos A1="0.0125" A2="-90.0000" A3="90.0000" A4="0.0000" A5="0.5000" A6="-350.0000"/>)"
    R"(<ASPos A1="0.0000" A2="-90.0000" A3="90.0000" A4="0.0000" A5="0.5000" A6="-350.0000"/>)"
    R"(<Delay D="3"/><IPOC>4208163</IPOC></Rob>)";

constexpr std::string_view kSensorGolden =
    R"(<Sen Type="TruePose"><AK A1="0.012500" A2="-0.250000" A3="0.000000" A4="1.000000" A5="0.000001" A6="-3.000000"/>)"
    R"(<Stop>0</Stop><IPOC>4208163</IPOC></Sen>)";

Axes from_deg(Axes deg) {
  for (double& value : deg) value *= kRadPerDeg;
  return deg;
}

RobotFrame golden_robot_frame() {
  return {.ipoc = 4208163,
          .rist = CartesianPose{1765, -0.125, 1910, 179.9999, 89.5, -180},
          .rsol = CartesianPose{1765, 0, 1910, 180, 89.5, -180},
          .aipos_rad = from_deg({0.0125, -90, 90, 0, 0.5, -350}),
          .aspos_rad = from_deg({0, -90, 90, 0, 0.5, -350}),
          .eipos = {},
          .espos = {},
          .delay = 3};
}

SensorFrame golden_sensor_frame() {
  return {
      .ipoc = 4208163, .axis_correction_rad = from_deg({0.0125, -0.25, 0, 1, 0.000001, -3}), .stop = false};
}

EthernetConfig ethernet_config(std::string name = "AK", bool stop_first = false) {
  EthernetConfig config;
  config.sentype = "TruePose";
  config.axis_correction = name;
  config.stop = "Stop";
  for (const char* axis : {".A1", ".A2", ".A3", ".A4", ".A5", ".A6"}) {
    config.receive.push_back({name + axis, ElementType::Double, 1, true});
  }
  const Element stop{"Stop", ElementType::Bool, 7, true};
  config.receive.insert(stop_first ? config.receive.begin() : config.receive.end(), stop);
  return config;
}

std::string encoded(const RobotFrame& frame) {
  std::array<char, kMaxFrameBytes> buffer;
  const auto text = encode_robot_frame(frame, buffer);
  EXPECT_TRUE(text) << describe(text.error());
  return std::string{text.value_or("")};
}

FrameError robot_error(std::string_view datagram) {
  const auto frame = decode_robot_frame(datagram);
  EXPECT_FALSE(frame) << datagram;
  return frame ? FrameError{} : frame.error();
}

std::string replaced(std::string_view source, std::string_view from, std::string_view to) {
  std::string text{source};
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

bool finite(const Axes& values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

bool finite(const RobotFrame& frame) {
  for (const auto& pose : {frame.rist, frame.rsol}) {
    if (pose && !finite(Axes{pose->x_mm, pose->y_mm, pose->z_mm, pose->a_deg, pose->b_deg, pose->c_deg}))
      return false;
  }
  for (const auto& axes : {frame.aipos_rad, frame.aspos_rad, frame.eipos, frame.espos}) {
    if (axes && !finite(*axes)) return false;
  }
  return true;
}

TEST(RobotFrame, IsReadFromGoldenBytes) {
  const auto frame = decode_robot_frame(kRobotGolden);
  ASSERT_TRUE(frame) << describe(frame.error());
  EXPECT_EQ(*frame, golden_robot_frame());
}

TEST(RobotFrame, IsWrittenToGoldenBytes) { EXPECT_EQ(encoded(golden_robot_frame()), kRobotGolden); }

TEST(RobotFrame, IsReadInAnyOrderWithLineBreaksPairsAndUnknownElements) {
  const auto frame = decode_robot_frame(R"(<?xml version="1.0"?>
    <Rob TYPE='KUKA'>
      <IPOC> 4208163 </IPOC>
      <!-- <Delay D="9"/> -->
      <Tech C11="1" C12="x"><Delay D="8"/></Tech>
      <Delay D="3"></Delay>
      <AIPos A6="-350.0000" A5 = " 0.5000" A4="0" A3="90" A2="-90" A1="0.0125" Note="here"></AIPos>
      <ASPos A2="-9e1" A1="0" A3="90" A4="0" A5=".5" A6="-350"/>
      <RSol C="-180" B="89.5" A="180" Z="1910" Y="0" X="1765"/>
      <RIst X="1765" Y="-0.125" Z="1910" A="179.9999" B="89.5" C="-180"/>
      <Text>free</Text>
    </Rob>
  )");
  ASSERT_TRUE(frame) << describe(frame.error());
  EXPECT_EQ(*frame, golden_robot_frame());
}

TEST(RobotFrame, KeepsTheWholeIpoc) {
  const auto frame = decode_robot_frame("<Rob><IPOC>18446744073709551615</IPOC></Rob>");
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->ipoc, 18446744073709551615u);
  EXPECT_EQ(encoded(*frame), R"(<Rob Type="KUKA"><IPOC>18446744073709551615</IPOC></Rob>)");
}

TEST(RobotFrame, HasTheExternalAxesAsOnTheWire) {
  RobotFrame frame = golden_robot_frame();
  frame.eipos = Axes{1, 2, 3, 4, 5, 6};
  frame.espos = Axes{-1, -2, -3, -4, -5, -6};
  const auto decoded = decode_robot_frame(encoded(frame));
  ASSERT_TRUE(decoded);
  EXPECT_EQ(*decoded, frame);
}

TEST(RobotFrame, TellsOfTheProgramWhatTheListHas) {
  RobotFrame frame = golden_robot_frame();
  for (const ProgramSignals& program :
       {ProgramSignals{.ask = 1, .state = 3}, ProgramSignals{.ask = 0, .state = {}},
        ProgramSignals{.ask = {}, .state = 4}, ProgramSignals{.ask = 1, .state = 3, .mode = 4},
        ProgramSignals{.ask = 1, .state = 3, .mode = 4, .override_percent = 100},
        ProgramSignals{.ask = 1, .state = 3, .mode = 4, .override_percent = 100, .cell = 1'024'003}}) {
    frame.program = program;
    EXPECT_EQ(decode_robot_frame(encoded(frame)).value(), frame);
  }
  const auto read = [&](std::string_view element) {
    frame.program = {.ask = 1, .state = {}};
    std::string text = encoded(frame);
    return decode_robot_frame(
        text.replace(text.find("<Tp"), std::string_view{R"(<Tp Ask="1"/>)"}.size(), element));
  };
  EXPECT_EQ(read(R"(<Tp Ask="1.0" Other="x"/>)")->program.ask, 1) << "as controllers write whole numbers";
  const auto odd = read(R"(<Tp Ask="yes" Pro="3"/>)");
  ASSERT_TRUE(odd) << "it is not what is corrected by";
  EXPECT_EQ(odd->program, (ProgramSignals{.ask = {}, .state = 3}));
  EXPECT_EQ(odd->unread->attribute, "Ask");
  EXPECT_EQ(read(R"(<Tp Ask="1" Ask="0"/>)").error().fault, FrameFault::Duplicate);
}

TEST(RobotFrame, SaysWhichFieldIsWrong) {
  const auto expect = [](std::string_view from, std::string_view to, FrameFault fault,
                         std::string_view element, std::string_view attribute) {
    const FrameError error = robot_error(replaced(kRobotGolden, from, to));
    EXPECT_EQ(error.fault, fault) << from << " -> " << to << ": " << describe(error);
    EXPECT_EQ(error.element, element);
    EXPECT_EQ(error.attribute, attribute);
  };
  const auto expect_in_aspos = [&](std::string_view from, std::string_view to, FrameFault fault,
                                   std::string_view attribute) {
    const std::string aspos = R"(<ASPos A1="0.0000" )" + std::string{from};
    expect(aspos, replaced(aspos, from, to), fault, "ASPos", attribute);
  };
  expect_in_aspos(R"(A2="-90.0000")", "", FrameFault::Missing, "A2");
  expect_in_aspos(R"(A2="-90.0000")", R"(A1="-90.0000")", FrameFault::Duplicate, "A1");
  for (const char* bad :
       {"nan", "inf", "1e999", "", "-90,0000", "0x10", "1.#QNAN", "++1", "+-1", "-+1", "+", "+ 1", "1 2"}) {
    expect_in_aspos(R"(A2="-90.0000")", R"(A2=")" + std::string{bad} + "\"", FrameFault::BadNumber, "A2");
  }
  expect(R"(A3="90.0000")", R"(A2="90.0000")", FrameFault::Duplicate, "AIPos", "A2");
  expect("RSol", "RIst", FrameFault::Duplicate, "RIst", "");
  expect(R"(D="3")", R"(D="x" D="3")", FrameFault::Duplicate, "Delay", "D");
  expect("<Delay", R"(<Delay D="x"/><Delay)", FrameFault::Duplicate, "Delay", "");
  expect("<AIPos", R"(<AIPos A1="x"/><AIPos)", FrameFault::Duplicate, "AIPos", "");
  expect("<IPOC>4208163</IPOC>", "<IPOC/>", FrameFault::Missing, "IPOC", "");
  expect("4208163", "4208163.0", FrameFault::BadNumber, "IPOC", "");
  expect("<IPOC>4208163</IPOC>", "<![CDATA[<IPOC>1</IPOC>]]>", FrameFault::Malformed, "", "");
  expect("<IPOC>4208163</IPOC>", "", FrameFault::Missing, "IPOC", "");
  expect("4208163", "", FrameFault::Missing, "IPOC", "");
  expect("4208163", "-4", FrameFault::BadNumber, "IPOC", "");
  expect("4208163", "18446744073709551616", FrameFault::BadNumber, "IPOC", "");
  expect("4208163", "42<a/>", FrameFault::BadNumber, "IPOC", "");
  expect("<Delay", "<IPOC>1</IPOC><Delay", FrameFault::Duplicate, "IPOC", "");
  expect("</Rob>", "</Bob>", FrameFault::Malformed, "", "");
  expect("</Rob>", "</Rob><Rob></Rob>", FrameFault::Malformed, "", "");
  expect("<Delay", "stray<Delay", FrameFault::Malformed, "", "");
  EXPECT_EQ(robot_error(kSensorGolden).fault, FrameFault::WrongRoot);
  EXPECT_EQ(robot_error(replaced(kRobotGolden, "<Rob ", "<rob ")).fault, FrameFault::WrongRoot);
  EXPECT_EQ(robot_error("<!DOCTYPE Rob>" + std::string{kRobotGolden}).fault, FrameFault::Malformed);
  const std::string no_aspos = replaced(kRobotGolden, "ASPos", "Other");
  EXPECT_EQ(describe(robot_error(replaced(no_aspos, R"( A3="90.0000")", ""))),
            "AIPos.A3 is missing (at byte 261)");
}

TEST(RobotFrame, OfAnOddButHonestSenderIsRead) {
  using namespace std::string_literals;
  const std::string golden{kRobotGolden};
  const auto expect_golden = [](const std::string& text) {
    const auto frame = decode_robot_frame(text);
    ASSERT_TRUE(frame) << describe(frame.error()) << ": " << text;
    EXPECT_EQ(*frame, golden_robot_frame()) << text;
  };
  expect_golden(golden + "\0"s);
  expect_golden(golden + std::string(600, '\0'));
  expect_golden(golden + "\r\n\0</Delay><IPOC>1</IPOC></Rob>"s);  // a block with the end of an older frame
  expect_golden("\xEF\xBB\xBF" + golden);
  expect_golden(replaced(golden, R"(<ASPos A1="0.0000" A2="-90.0000" A3="90.0000")",
                         R"(<ASPos A1="+0.0" A2="-90.0000" A3=" +90 ")"));
  expect_golden(replaced(golden, "4208163", "+4208163"));
  expect_golden(replaced(golden, R"(D="3")", R"(D="3.0")"));
  expect_golden(replaced(golden, R"(D="3")", R"(D="+3")"));

  std::string tech = "<Tech";
  for (int i = 0; i < 400; ++i) tech += " C" + std::to_string(i) + R"(="0.0")";
  expect_golden(replaced(golden, "<RSol", tech + "/><RSol"));
}

TEST(RobotFrame, LosesOnlyTheElementThatCannotBeReadWhereItIsNotWhatIsCorrectedBy) {
  const auto without = [](std::string_view from, std::string_view to, auto RobotFrame::*element) {
    const auto frame = decode_robot_frame(replaced(kRobotGolden, from, to));
    ASSERT_TRUE(frame) << to << ": " << describe(frame.error());
    RobotFrame expected = golden_robot_frame();
    (expected.*element).reset();
    expected.unread = frame->unread;
    EXPECT_EQ(*frame, expected) << to;
    EXPECT_TRUE(frame->unread) << to;
  };
  without(R"(<Delay D="3"/>)", "<Delay>3</Delay>", &RobotFrame::delay);
  for (const char* bad : {"", "3.5", "1e300", "nan", "three"})
    without(R"(D="3")", R"(D=")" + std::string{bad} + "\"", &RobotFrame::delay);
  without(R"( A3="90.0000")", "", &RobotFrame::aipos_rad);
  without(R"(<AIPos A1="0.0125")", R"(<AIPos A1="nan")", &RobotFrame::aipos_rad);
  without("<RIst X=\"1765.0000\"", "<RIst X=\"1765,0000\"", &RobotFrame::rist);
  without("<RSol X=\"1765.0000\"", "<RSol", &RobotFrame::rsol);

  const auto several =
      decode_robot_frame(replaced(replaced(kRobotGolden, "<RIst X", "<RIst x"), R"( A3="90.0000")", ""));
  ASSERT_TRUE(several);
  EXPECT_EQ(describe(*several->unread), "AIPos.A3 is missing (at byte 261)");
}

TEST(RobotFrame, NeedsItsActualAxesWhereNoCommandedOnesAreSent) {
  const std::string bad = replaced(kRobotGolden, R"(<AIPos A1="0.0125")", R"(<AIPos A1="x")");
  EXPECT_TRUE(decode_robot_frame(bad));
  const FrameError error = robot_error(replaced(bad, "ASPos", "Other"));
  EXPECT_EQ(error.fault, FrameFault::BadNumber);
  EXPECT_EQ(error.element, "AIPos");
}

TEST(RobotFrame, IsRefusedWhereAnElementThatMattersHasMoreAttributesThanAreLookedAt) {
  std::string many;
  for (int i = 0; i < 40; ++i) many += " X" + std::to_string(i) + R"(="1")";
  const FrameError error = robot_error(replaced(kRobotGolden, "<ASPos", "<ASPos" + many));
  EXPECT_EQ(describe(error).substr(0, 31), "ASPos has too many attributes (");
  const auto frame = decode_robot_frame(replaced(kRobotGolden, "<AIPos", "<AIPos" + many));
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->aipos_rad);
}

TEST(RobotFrame, IsRefusedWhenCutAnywhere) {
  for (std::size_t length = 0; length < kRobotGolden.size(); ++length) {
    // A copy of its own, so that the address sanitizer sees a read past the end.
    const std::vector<char> cut{kRobotGolden.begin(),
                                kRobotGolden.begin() + static_cast<std::ptrdiff_t>(length)};
    EXPECT_FALSE(decode_robot_frame({cut.data(), cut.size()})) << length;
  }
}

TEST(RobotFrame, WithAnyByteChangedIsRefusedOrFinite) {
  for (std::size_t position = 0; position < kRobotGolden.size(); ++position) {
    std::vector<char> bytes{kRobotGolden.begin(), kRobotGolden.end()};
    for (int value = 0; value < 256; ++value) {
      bytes[position] = static_cast<char>(value);
      const auto frame = decode_robot_frame({bytes.data(), bytes.size()});
      if (frame) {
        EXPECT_TRUE(finite(*frame)) << position << " " << value;
      }
    }
  }
}

TEST(RobotFrame, WithManyBytesChangedIsRefusedOrFinite) {
  constexpr unsigned kSeed = 20261;
  SCOPED_TRACE(kSeed);
  std::mt19937 random{kSeed};
  constexpr std::string_view kInteresting = "<>/=\"' \0naifxe+-.0123456789AEIPOC&!?";
  for (int round = 0; round < 50000; ++round) {
    std::vector<char> bytes{kRobotGolden.begin(), kRobotGolden.end()};
    for (unsigned changes = 1 + random() % 4; changes > 0; --changes) {
      bytes[random() % bytes.size()] = kInteresting[random() % kInteresting.size()];
    }
    const auto frame = decode_robot_frame({bytes.data(), bytes.size()});
    if (frame) {
      EXPECT_TRUE(finite(*frame));
    }
  }
}

TEST(RobotFrame, AgreesWithAnXmlParserOnRandomFrames) {
  constexpr unsigned kSeed = 20262;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> number{-3000, 3000};
  const auto axes = [&] {
    Axes values;
    for (double& value : values) value = number(random);
    return values;
  };
  const auto maybe = [&] { return random() % 4 != 0; };
  for (int round = 0; round < 2000; ++round) {
    RobotFrame frame{.ipoc = random(),
                     .rist = {},
                     .rsol = {},
                     .aipos_rad = {},
                     .aspos_rad = {},
                     .eipos = {},
                     .espos = {},
                     .delay = {}};
    if (maybe())
      frame.rist = CartesianPose{number(random), number(random), number(random), 1, 2, number(random)};
    if (maybe()) frame.aipos_rad = axes();
    if (maybe()) frame.aspos_rad = axes();
    if (maybe()) frame.espos = axes();
    if (maybe()) frame.delay = static_cast<std::int64_t>(random() % 100);
    std::array<char, kMaxFrameBytes> buffer;
    const auto text = encode_robot_frame(frame, buffer, static_cast<int>(random() % 10));
    ASSERT_TRUE(text);

    pugi::xml_document document;
    ASSERT_TRUE(document.load_buffer(text->data(), text->size()));
    const pugi::xml_node root = document.child("Rob");
    const auto decoded = decode_robot_frame(*text);
    ASSERT_TRUE(decoded) << *text;
    EXPECT_EQ(decoded->ipoc, root.child("IPOC").text().as_ullong());
    const auto expect_axes = [&](const char* name, const std::optional<Axes>& values, double scale,
                                 char letter) {
      ASSERT_EQ(static_cast<bool>(root.child(name)), values.has_value()) << name;
      for (std::size_t i = 0; values && i < values->size(); ++i) {
        const std::string attribute = letter + std::to_string(i + 1);
        EXPECT_DOUBLE_EQ((*values)[i], root.child(name).attribute(attribute.c_str()).as_double() * scale)
            << *text;
      }
    };
    expect_axes("AIPos", decoded->aipos_rad, kRadPerDeg, 'A');
    expect_axes("ASPos", decoded->aspos_rad, kRadPerDeg, 'A');
    expect_axes("ESPos", decoded->espos, 1, 'E');
    ASSERT_EQ(static_cast<bool>(root.child("RIst")), decoded->rist.has_value());
    if (decoded->rist) {
      EXPECT_DOUBLE_EQ(decoded->rist->y_mm, root.child("RIst").attribute("Y").as_double());
      EXPECT_DOUBLE_EQ(decoded->rist->c_deg, root.child("RIst").attribute("C").as_double());
    }
    ASSERT_EQ(static_cast<bool>(root.child("Delay")), decoded->delay.has_value());
    if (decoded->delay) {
      EXPECT_EQ(*decoded->delay, root.child("Delay").attribute("D").as_llong());
    }
  }
}

TEST(SensorFrame, IsWrittenToGoldenBytes) {
  const SensorFrameCodec codec{ethernet_config()};
  std::array<char, kMaxFrameBytes> buffer;
  EXPECT_EQ(codec.encode(golden_sensor_frame(), buffer).value(), kSensorGolden);
}

TEST(SensorFrame, IsReadFromGoldenBytes) {
  const auto frame = SensorFrameCodec{ethernet_config()}.decode(kSensorGolden);
  ASSERT_TRUE(frame) << describe(frame.error());
  EXPECT_EQ(*frame, golden_sensor_frame());
}

TEST(SensorFrame, HasTheNamesAndTheOrderOfTheConfiguration) {
  const SensorFrameCodec codec{ethernet_config("AKorr", true)};
  std::array<char, kMaxFrameBytes> buffer;
  const SensorFrame frame{.ipoc = 7, .axis_correction_rad = Axes{}, .stop = true};
  const std::string_view text = codec.encode(frame, buffer).value();
  EXPECT_EQ(
      text,
      R"(<Sen Type="TruePose"><Stop>1</Stop><AKorr A1="0.000000" A2="0.000000" A3="0.000000" A4="0.000000" )"
      R"(A5="0.000000" A6="0.000000"/><IPOC>7</IPOC></Sen>)");
  EXPECT_EQ(codec.decode(text).value(), frame);
}

TEST(SensorFrame, LeavesOutWhatTheConfigurationDoesNotReceive) {
  EthernetConfig config;
  config.sentype = "TruePose";
  const SensorFrameCodec codec{config};
  std::array<char, kMaxFrameBytes> buffer;
  EXPECT_EQ(codec.encode(golden_sensor_frame(), buffer).value(),
            R"(<Sen Type="TruePose"><IPOC>4208163</IPOC></Sen>)");
  EXPECT_EQ(codec.decode(kSensorGolden).value(),
            (SensorFrame{.ipoc = 4208163, .axis_correction_rad = {}, .stop = {}}));
}

TEST(SensorFrame, TellsTheGainWhereTheConfigurationReceivesIt) {
  EthernetConfig config = ethernet_config();
  config.gain = true;
  const SensorFrameCodec codec{config};
  std::array<char, kMaxFrameBytes> buffer;
  SensorFrame frame = golden_sensor_frame();
  for (const std::int64_t gain : {std::int64_t{100}, std::int64_t{0}, kGainFault}) {
    frame.gain = gain;
    const std::string_view text = codec.encode(frame, buffer).value();
    EXPECT_THAT(
        std::string{text},
        testing::HasSubstr("<Tp Gain=\"" + std::to_string(gain_word(gain, frame.ipoc)) + "\"/><IPOC>"));
    EXPECT_EQ(codec.decode(text).value(), frame);
  }
}

TEST(SensorFrame, OfAnotherTypeIsRefused) {
  const SensorFrameCodec codec{ethernet_config()};
  const auto frame = codec.decode(replaced(kSensorGolden, "TruePose", "ImFree"));
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().fault, FrameFault::WrongRoot);
  EXPECT_EQ(codec.decode(replaced(kSensorGolden, "<Stop>0", "<Stop>2")).error().element, "Stop");
  EXPECT_TRUE(codec.decode(replaced(kSensorGolden, "Type", "TYPE")));
}

TEST(SensorFrame, IsNeverWrittenWithANumberThatIsNotFinite) {
  const SensorFrameCodec codec{ethernet_config()};
  std::array<char, kMaxFrameBytes> buffer;
  for (const double bad : {double{NAN}, double{INFINITY}, -double{INFINITY}, 1e308}) {
    SensorFrame frame = golden_sensor_frame();
    (*frame.axis_correction_rad)[4] = bad;
    const auto text = codec.encode(frame, buffer);
    ASSERT_FALSE(text);
    EXPECT_EQ(text.error().fault, FrameFault::BadNumber);
    EXPECT_EQ(text.error().attribute, "A5");
  }
}

TEST(SensorFrame, ThatDoesNotFitIsAnErrorAndStaysInsideTheBuffer) {
  const SensorFrameCodec codec{ethernet_config()};
  for (std::size_t size = 0; size < kSensorGolden.size(); ++size) {
    std::vector<char> buffer(size);
    const auto text = codec.encode(golden_sensor_frame(), buffer);
    ASSERT_FALSE(text) << size;
    EXPECT_EQ(text.error().fault, FrameFault::BufferFull);
  }
  std::vector<char> exact(kSensorGolden.size());
  EXPECT_EQ(codec.encode(golden_sensor_frame(), exact).value(), kSensorGolden);
}

TEST(SensorFrame, CutOrWithAnyByteChangedIsRefusedOrFinite) {
  const SensorFrameCodec codec{ethernet_config()};
  for (std::size_t position = 0; position < kSensorGolden.size(); ++position) {
    EXPECT_FALSE(codec.decode(kSensorGolden.substr(0, position)));
    std::vector<char> bytes{kSensorGolden.begin(), kSensorGolden.end()};
    for (int value = 0; value < 256; ++value) {
      bytes[position] = static_cast<char>(value);
      const auto frame = codec.decode({bytes.data(), bytes.size()});
      if (frame && frame->axis_correction_rad) {
        EXPECT_TRUE(finite(*frame->axis_correction_rad)) << position << " " << value;
      }
    }
  }
}

TEST(Frames, AreReadAndWrittenWithoutAllocation) {
  const SensorFrameCodec codec{ethernet_config()};
  std::array<char, kMaxFrameBytes> buffer;
  const std::string partly = replaced(kRobotGolden, "-90.0000", "nan");
  const std::string broken = replaced(partly, "ASPos", "Other");
  const SensorFrame reply = golden_sensor_frame();
  const auto before = allocations();
  const auto frame = decode_robot_frame(kRobotGolden);
  const auto in_part = decode_robot_frame(partly);
  const auto refused = decode_robot_frame(broken);
  const auto written = encode_robot_frame(*frame, buffer);
  const auto answer = codec.encode(reply, buffer);
  const auto answered = codec.decode(*answer);
  EXPECT_EQ(allocations(), before);
  EXPECT_TRUE(frame && in_part && !refused && written && answered);
}

}  // namespace
}  // namespace truepose::rsi
