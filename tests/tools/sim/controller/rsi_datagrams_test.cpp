#include "tools/sim/controller/rsi_datagrams.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "proto/rsi/frame_codec.hpp"

namespace truepose::sim {
namespace {

rsi::EthernetConfig sending(const std::vector<std::string>& tags) {
  rsi::EthernetConfig config;
  for (const std::string& tag : tags) {
    const bool built_in = tag.starts_with("DEF_");
    config.send.push_back({tag,
                           built_in || tag.ends_with("X") ? rsi::ElementType::Double : rsi::ElementType::Long,
                           built_in ? std::nullopt : std::optional{1}});
  }
  return config;
}

TEST(RobotDatagram, HasEveryElementThatTheSendListAsksForInItsOrder) {
  RobotDatagram datagram{sending({"DEF_Delay", "DEF_EIPos", "DEF_AIPos", "DEF_MACur", "DEF_MECur",
                                  "DEF_ESPos", "Count", "FT.X", "FT.N", "DEF_Tech.C1", "DEF_Tech.T2"}),
                         2};
  EXPECT_EQ(datagram.write({.ipoc = 77, .aipos_deg = {1, 2, 3, 4, 5, 6.005}, .delay = 9}),
            "<Rob Type=\"KUKA\"><Delay D=\"9\"/>"
            "<EIPos E1=\"0.00\" E2=\"0.00\" E3=\"0.00\" E4=\"0.00\" E5=\"0.00\" E6=\"0.00\"/>"
            "<AIPos A1=\"1.00\" A2=\"2.00\" A3=\"3.00\" A4=\"4.00\" A5=\"5.00\" A6=\"6.00\"/>"
            "<MACur A1=\"0.00\" A2=\"0.00\" A3=\"0.00\" A4=\"0.00\" A5=\"0.00\" A6=\"0.00\"/>"
            "<MECur E1=\"0.00\" E2=\"0.00\" E3=\"0.00\" E4=\"0.00\" E5=\"0.00\" E6=\"0.00\"/>"
            "<ESPos E1=\"0.00\" E2=\"0.00\" E3=\"0.00\" E4=\"0.00\" E5=\"0.00\" E6=\"0.00\"/>"
            "<Count>0</Count><FT X=\"0.00\" N=\"0\"/>"
            "<Tech C11=\"0.00\" C12=\"0.00\" C13=\"0.00\" C14=\"0.00\" C15=\"0.00\" C16=\"0.00\" "
            "C17=\"0.00\" C18=\"0.00\" "
            "C19=\"0.00\" C110=\"0.00\" T21=\"0.00\" T22=\"0.00\" T23=\"0.00\" T24=\"0.00\" T25=\"0.00\" "
            "T26=\"0.00\" "
            "T27=\"0.00\" T28=\"0.00\" T29=\"0.00\" T210=\"0.00\"/><IPOC>77</IPOC></Rob>");
}

TEST(RobotDatagram, IsUnderstoodByOurDecoder) {
  RobotDatagram datagram{
      sending({"DEF_RIst", "DEF_RSol", "DEF_AIPos", "DEF_ASPos", "DEF_EIPos", "DEF_Delay"}), 4};
  const auto frame = rsi::decode_robot_frame(datagram.write(
      {.ipoc = 5, .rist = {1, 2, 3, 4, 5, 6}, .rsol = {7, 8, 9, 10, 11, 12}, .aspos_deg = {180}}));
  ASSERT_TRUE(frame) << rsi::describe(frame.error());
  EXPECT_EQ(frame->rist->c_deg, 6);
  EXPECT_EQ(frame->rsol->x_mm, 7);
  EXPECT_DOUBLE_EQ((*frame->aspos_rad)[0], std::numbers::pi);
  EXPECT_EQ((*frame->eipos)[5], 0);
}

TEST(RobotDatagram, RefusesASendListThatItCannotServeByName) {
  EXPECT_EQ(unsendable(sending({"DEF_RIst", "DEF_Tech.C6", "DEF_Tech.T2", "FT.X"})), std::nullopt);
  EXPECT_EQ(
      unsendable(sending({"DEF_RIst", "DEF_Foo"})),
      "SEND element DEF_Foo is no built-in: a controller knows DEF_RIst, DEF_RSol, DEF_AIPos, DEF_ASPos, "
      "DEF_EIPos, DEF_ESPos, DEF_MACur, DEF_MECur, DEF_Delay, DEF_Tech.C1..C6 and DEF_Tech.T2..T6");
  EXPECT_EQ(unsendable(sending({"DEF_Tech.T1"})),
            "SEND element DEF_Tech.T1: RSI needs technology generator 1 itself (RSIBad); leave it out");
  EXPECT_EQ(unsendable(sending({"DEF_Tech.C7"})),
            "SEND element DEF_Tech.C7 is no built-in: Tech has C1..C6 and T2..T6");
  rsi::EthernetConfig free_name = sending({"Count"});
  free_name.send[0].index.reset();
  EXPECT_EQ(unsendable(free_name),
            "SEND element Count is INTERNAL, but no built-in (their tags begin with DEF_): give it an INDX "
            "of 1..64");
}

}  // namespace
}  // namespace truepose::sim
