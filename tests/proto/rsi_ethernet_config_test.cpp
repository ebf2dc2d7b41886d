#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "proto/rsi/ethernet_config.hpp"
#include "proto/text/message.hpp"
#include "tests/rsi_flaws.hpp"

namespace truepose::rsi {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

std::string shipped() {
  std::ifstream file{TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml"};
  return {std::istreambuf_iterator<char>{file}, {}};
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

EthernetConfig parsed(const std::string& xml) {
  const auto config = parse_ethernet_config(xml);
  EXPECT_TRUE(config) << config.error();
  return config.value_or(EthernetConfig{});
}

std::string error_of(const std::string& xml) {
  const auto config = parse_ethernet_config(xml);
  EXPECT_FALSE(config);
  return config ? "" : config.error();
}

TEST(EthernetConfig, TheOneThatWeShipHasEverythingAndNoWarning) {
  const EthernetConfig config = parsed(shipped());
  EXPECT_EQ(config.sentype, "TruePose");
  EXPECT_FALSE(config.only_send);
  EXPECT_EQ(config.axis_correction, "AK");
  EXPECT_EQ(config.stop, "Stop");
  for (const char* keyword : {"RIst", "RSol", "AIPos", "ASPos", "Delay"})
    EXPECT_TRUE(config.sends(keyword)) << keyword;
  EXPECT_FALSE(config.sends("EIPos"));
  EXPECT_EQ(config.receive.front(), (Element{"AK.A1", ElementType::Double, 1, true}));
  EXPECT_EQ(config.send.front().index, std::nullopt);
  EXPECT_THAT(lint(config), IsEmpty());
}

TEST(EthernetConfig, TheAxisCorrectionIsFoundByItsShapeNotItsName) {
  std::string xml = shipped();
  for (int i = 1; i <= 6; ++i) {
    xml = replaced(xml, "AK.A" + std::to_string(i), "Bending.A" + std::to_string(i));
  }
  EXPECT_EQ(parsed(xml).axis_correction, "Bending");
}

TEST(EthernetConfig, AnElementThatLacksAnAxisOrIsNotDoubleIsNoAxisCorrection) {
  EXPECT_EQ(parsed(replaced(shipped(), "AK.A6", "AK.B6")).axis_correction, std::nullopt);
  EXPECT_EQ(parsed(replaced(shipped(), R"("AK.A6" TYPE="DOUBLE")", R"("AK.A6" TYPE="LONG")")).axis_correction,
            std::nullopt);
}

/// "L_HOLDON What is wrong. What to do."
std::vector<std::string> said(const std::vector<Message>& found) {
  std::vector<std::string> lines;
  for (const Message& one : found) lines.push_back(one.code + " " + sentences(one));
  return lines;
}

TEST(EthernetConfig, WarnsOfWhatWouldBreakAbsoluteCorrections) {
  for (const EthernetFlaw& flaw : ethernet_flaws())
    EXPECT_THAT(said(lint(parsed(replaced(shipped(), flaw.from, flaw.to)))),
                Contains(StartsWith(std::string{kind_of(flaw.kind).code} + " " + flaw.found)));
}

TEST(EthernetConfig, SaysThatACartesianCorrectionIsNeverSent) {
  std::string receive;
  for (const std::string axis : {"X", "Y", "Z", "A", "B", "C"})
    receive += "<ELEMENT TAG=\"RKorr." + axis + "\" TYPE=\"DOUBLE\" INDX=\"1\" HOLDON=\"1\"/>";
  const auto config = parse_ethernet_config(
      "<ROOT><CONFIG><IP_NUMBER>10.0.0.1</IP_NUMBER><PORT>49152</PORT><SENTYPE>P</SENTYPE><ONLYSEND>FALSE</ONLYSEND>"
      "</CONFIG><SEND><ELEMENTS/></SEND><RECEIVE><ELEMENTS>" +
      receive + "</ELEMENTS></RECEIVE></ROOT>");
  ASSERT_TRUE(config) << config.error();
  EXPECT_THAT(
      said(lint(*config)),
      Contains("L_CARTESIAN RECEIVE has a Cartesian correction, RKorr: truepose corrects axes alone and "
               "never sends it. Remove it, or keep its start value at 0."));
  EXPECT_THAT(said(lint(*config)), Not(Contains(HasSubstr("RKorr.X"))));
}

TEST(EthernetConfig, RefusesWhatItCannotBelieveAndNamesIt) {
  EXPECT_THAT(error_of("hello"), HasSubstr("not an XML document"));
  EXPECT_THAT(error_of("<ROOT/>"), HasSubstr("ROOT/CONFIG"));
  EXPECT_THAT(error_of(replaced(shipped(), "<PORT>49152", "<PORT>70000")),
              HasSubstr("CONFIG/PORT is \"70000\""));
  EXPECT_THAT(error_of(replaced(shipped(), "<SENTYPE>TruePose", "<SENTYPE>")), HasSubstr("SENTYPE"));
  EXPECT_THAT(error_of(replaced(shipped(), R"("AK.A2" TYPE="DOUBLE" INDX="2")",
                                R"("AK.A2" TYPE="DOUBLE" INDX="65")")),
              HasSubstr("RECEIVE element AK.A2: INDX is \"65\""));
  EXPECT_THAT(error_of(replaced(shipped(), "\"AK.A2\"", "\"AK.A1\"")), HasSubstr("AK.A1 is listed twice"));
  EXPECT_THAT(error_of(replaced(shipped(), R"("Stop" TYPE="BOOL")", R"("Stop" TYPE="BOOLEAN")")),
              HasSubstr("element Stop: TYPE"));
}

TEST(EthernetConfig, RefusesNamesThatAReplyCannotCarry) {
  for (const std::string name :
       {"A\nB", "A\x1d", "A&lt;", "a name of more than sixty-four characters, which nobody has ever read"})
    EXPECT_THAT(error_of(replaced(shipped(), "<SENTYPE>TruePose", "<SENTYPE>" + name)), HasSubstr("SENTYPE"));
  EXPECT_EQ(parsed(replaced(shipped(), "<SENTYPE>TruePose", "<SENTYPE>True Pose")).sentype, "True Pose");
  for (const char* name : {"S top", "S/", "S=", "1", "-S", "!S", "S\t",
                           "SSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSSS"})
    EXPECT_THAT(error_of(replaced(shipped(), "\"Stop\"", "\"" + std::string{name} + "\"")),
                HasSubstr("TAG is"))
        << name;
  EXPECT_EQ(parsed(replaced(shipped(), "\"Stop\"", "\"Out.01\"")).stop, std::nullopt);
}

TEST(EthernetConfig, EveryTruncationIsAnErrorOrACompleteConfiguration) {
  const std::string xml = shipped();
  const std::size_t complete = xml.rfind("</ROOT>");
  for (std::size_t length = 0; length < complete; ++length) {
    EXPECT_FALSE(parse_ethernet_config(xml.substr(0, length))) << length;
  }
}

}  // namespace
}  // namespace truepose::rsi
