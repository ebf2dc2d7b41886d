#include "tools/sim/controller/eki_channel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace truepose::sim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A file whose robot listens.
std::string eki_xml(const std::string& internal, const std::string& data) {
  return "<ETHERNETKRL><CONFIGURATION><EXTERNAL><TYPE>Client</TYPE></EXTERNAL><INTERNAL>" + internal +
         "<PORT>54600</PORT></INTERNAL></CONFIGURATION>" + data + "</ETHERNETKRL>";
}

const std::string kFrameFile =
    eki_xml("",
            "<RECEIVE><XML><ELEMENT Tag=\"In/Frame\" Type=\"FRAME\"/>"
            "<ELEMENT Tag=\"In/No\" Type=\"INT\"/><ELEMENT Tag=\"Other\" Type=\"INT\"/></XML></RECEIVE>"
            "<SEND><XML><ELEMENT Tag=\"Out/Whole\"/></XML></SEND>");

TEST(EkiFile, IsOfTcpWhereItNamesNoProtocol) {
  EXPECT_EQ(parse_eki_file(eki_xml("", "")).value().port, 54600);
  EXPECT_TRUE(parse_eki_file(eki_xml("<PROTOCOL>TCP</PROTOCOL>", "")));
  EXPECT_THAT(parse_eki_file(eki_xml("<PROTOCOL>UDP</PROTOCOL>", "")).error(),
              HasSubstr("PROTOCOL: UDP is not simulated"));
}

TEST(EkiFile, LoadsWithEmptyOrMissingReceiveAndSend) {
  for (const std::string data : {"", "<RECEIVE></RECEIVE><SEND/>", "<RECEIVE><XML/></RECEIVE>"}) {
    const auto file = parse_eki_file(eki_xml("", data));
    ASSERT_TRUE(file) << data << file.error();
    EXPECT_THAT(file->receive, IsEmpty());
    EXPECT_THAT(file->send, IsEmpty());
  }
  EXPECT_THAT(parse_eki_file(eki_xml("", "<RECEIVE><RAW/></RECEIVE>")).error(), HasSubstr("RECEIVE: RAW"));
}

TEST(EkiChannel, TakesAFrameFromTheAttributesOfItsElement) {
  EkiChannel channel{parse_eki_file(kFrameFile).value()};
  ASSERT_TRUE(channel.receive("<In><Frame X='1' Y='2' Z='3' A='4' B='5' C='-6.5'/></In>"));
  EXPECT_FALSE(channel.take("In/Frame", EkiFile::Type::Real));
  const krl::Value frame = channel.take("In/Frame", EkiFile::Type::Frame).value();
  EXPECT_EQ(frame, (krl::Value{krl::Parts{1.0, 2.0, 3.0, 4.0, 5.0, -6.5}}));
  const auto partial = channel.receive("<In><Frame X='1' Y='2' Z='3' A='4' B='5'/></In>");
  ASSERT_FALSE(partial);
  EXPECT_EQ(partial.error(), "In/Frame/@C is missing");
}

TEST(EkiChannel, SendsAFrameInTheAttributesOfItsElement) {
  EkiChannel channel{parse_eki_file(kFrameFile).value()};
  ASSERT_TRUE(channel.set("Out/Whole", krl::Parts{1.0, 2.0, 3.0, 4.0, 5.0, 6.0}));
  EXPECT_THAT(channel.document("Out").value(), HasSubstr("<Whole X=\"1.000000\" Y=\"2.000000\""));
  EXPECT_EQ(channel.set("Out/Pos", krl::Parts{1.0, 2.0, 3.0, 4.0, 5.0, 6.0}).error(),
            "SEND has no Out/Pos/@X");
}

TEST(EkiChannel, ClearsTheBufferOfAnElementAndOfAllBelowIt) {
  EkiChannel channel{parse_eki_file(kFrameFile).value()};
  ASSERT_TRUE(channel.receive("<In><No>1</No></In>"));
  ASSERT_TRUE(channel.receive("<Other>2</Other>"));
  channel.clear_buffer("In");
  EXPECT_EQ(channel.waiting("In/No"), 0U);
  EXPECT_EQ(channel.waiting("Other"), 1U);
}

}  // namespace
}  // namespace truepose::sim
