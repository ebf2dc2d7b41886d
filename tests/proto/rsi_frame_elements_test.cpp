#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/rsi/frame_elements.hpp"

namespace truepose::rsi {
namespace {

using testing::ElementsAre;

EthernetConfig sending(std::initializer_list<const char*> tags) {
  EthernetConfig ethernet;
  for (const char* tag : tags) ethernet.send.push_back({.tag = tag});
  return ethernet;
}

NameDifference difference(const char* frame, const EthernetConfig& ethernet) {
  return compare_names(frame_elements(frame).value(), ethernet);
}

TEST(FrameElements, NameEveryAttributeOfAFrame) {
  const auto found =
      frame_elements("<Rob Type=\"KUKA\"><RIst X=\"1\" Y=\"2\"/><On>1</On><IPOC>4</IPOC></Rob>");
  ASSERT_TRUE(found);
  EXPECT_THAT(found->names, ElementsAre("RIst.X", "RIst.Y", "On", "IPOC"));
}

TEST(FrameElements, CountTheDecimalsThatTheControllerSends) {
  const auto decimals = [](const char* frame) { return frame_elements(frame)->decimals; };
  EXPECT_EQ(decimals("<Rob><RIst X=\"1.0000\" Y=\"-2.5000\"/></Rob>"), 4);
  EXPECT_EQ(decimals("<Rob><AIPos A1=\"1.5\"/><Delay D=\"0\"/></Rob>"), 1);
  EXPECT_EQ(decimals("<Rob><Delay D=\"0\"/></Rob>"), 0);
}

TEST(FrameElements, SayWhereAFrameIsBroken) {
  const auto broken = frame_elements("<Rob><RIst X=\"1\"</Rob>");
  ASSERT_FALSE(broken);
  EXPECT_EQ(describe(broken.error()), "not a well-formed frame (at byte 16)");
}

TEST(FrameElements, AgreeWithTheConfigurationThatMadeThem) {
  EXPECT_EQ(
      difference(
          "<Rob><RIst X=\"1\"/><Tech C11=\"0\" C110=\"0\"/><Tp Ask=\"1\"/><On>1</On><IPOC>4</IPOC></Rob>",
          sending({"DEF_RIst", "DEF_Tech.C1", "Tp.Ask", "On"})),
      NameDifference{});
}

TEST(FrameElements, AreNamedWhereTheConfigurationHasOthers) {
  const NameDifference found =
      difference("<Rob><MACur A1=\"1\" A2=\"2\"/><Tp Ask=\"1\" Asks=\"1\"/><IPOC>4</IPOC></Rob>",
                 sending({"DEF_RIst", "Tp.Ask", "Tp.Pro"}));
  EXPECT_THAT(found.unknown, ElementsAre("MACur", "Tp.Asks"));
  EXPECT_THAT(found.missing, ElementsAre("DEF_RIst", "Tp.Pro"));
}

TEST(FrameElements, DoNotTakeOneNameForTheBeginningOfAnother) {
  const NameDifference found = difference("<Rob><RIstX X=\"1\"/></Rob>", sending({"DEF_RIst"}));
  EXPECT_THAT(found.unknown, ElementsAre("RIstX"));
  EXPECT_THAT(found.missing, ElementsAre("DEF_RIst"));
}

}  // namespace
}  // namespace truepose::rsi
