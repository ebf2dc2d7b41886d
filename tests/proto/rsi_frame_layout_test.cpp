#include <gtest/gtest.h>

#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "proto/rsi/frame_layout.hpp"
#include "tests/allocations.hpp"
#include "tests/trials.hpp"

namespace truepose::rsi {
namespace {

using namespace std::string_literals;

/// Layouts that controllers, and who imitates them, may have; each with a %s in the place of a number.
const std::vector<std::string> kLayouts{
    R"(<Rob Type="KUKA"><RIst X="%s" Y="%s" Z="%s" A="%s" B="%s" C="%s"/><RSol X="%s" Y="%s" Z="%s" A="%s" B="%s" C="%s"/>)"
    R"(<AIPos A1="%s" A2="%s" A3="%s" A4="%s" A5="%s" A6="%s"/><ASPos A1="%s" A2="%s" A3="%s" A4="%s" A5="%s" A6="%s"/>)"
    R"(<Delay D="3"/><IPOC>4208163</IPOC></Rob>)",
    R"(<Rob Type="KUKA"><ASPos A1="%s" A2="%s" A3="%s" A4="%s" A5="%s" A6="%s"/><EIPos E1="%s" E2="%s" E3="%s" E4="%s" E5="%s" E6="%s"/>)"
    R"(<Tech C11="%s" C12="%s" T13="x"/><DiL>0</DiL><Delay D="0"/><Tp Ask="1" Pro="3" Mode="4"/><IPOC>0</IPOC></Rob>)",
    "\xEF\xBB\xBF<?xml version='1.0'?>\r\n<Rob TYPE='KUKA'>\r\n <IPOC> 42 </IPOC>\r\n <!-- c -->\r\n"
    " <AIPos A6='%s' Note='' A5 = '%s' A4='%s' A3='%s' A2='%s' A1='%s'>text</AIPos>\r\n"
    " <T><Delay D='8'/><ASPos A1='1'/> u <IPOC>3</IPOC></T><Delay D='12'></Delay></Rob>\r\n\0\0"s,
};

std::string filled(const std::string& layout, std::mt19937_64& random) {
  std::string text = layout;
  for (std::size_t at; (at = text.find("%s")) != std::string::npos;) {
    char number[32];
    std::snprintf(
        number, sizeof number, "%.*f", static_cast<int>(random() % 7),
        static_cast<double>(static_cast<std::int64_t>(random() % 4'000'000'000) - 2'000'000'000) * 1e-6);
    text.replace(at, 2, number);
  }
  return text;
}

void expect_one_decoding(RobotFrameDecoder& decoder, const std::string& text) {
  // A copy of its own, so that the address sanitizer sees a read past the end.
  const std::vector<char> bytes{text.begin(), text.end()};
  const std::string_view frame{bytes.data(), bytes.size()};
  const auto expected = decode_robot_frame(frame);
  const auto decoded = decoder.decode(frame);
  ASSERT_EQ(decoded.has_value(), expected.has_value()) << text;
  if (expected) {
    ASSERT_EQ(*decoded, *expected) << text;
  } else {
    ASSERT_EQ(decoded.error(), expected.error()) << text;
  }
}

TEST(FrameLayout, OfOneFrameIsThatOfTheNext) {
  std::mt19937_64 random{1};
  for (const std::string& layout : kLayouts) {
    FrameLayout learned;
    learned.learn(filled(layout, random));
    for (int round = 0; round < 1000; ++round) {
      const std::string next = filled(layout, random);
      const auto frame = learned.read(next);
      ASSERT_TRUE(frame) << next;
      ASSERT_EQ(*frame, decode_robot_frame(next).value()) << next;
    }
  }
}

TEST(FrameLayout, TakesOtherTextsWhereNobodyReadsThem) {
  FrameLayout layout;
  const auto frame = [](const std::string& c, const std::string& text) {
    return R"(<Rob><ASPos A1="1" A2="2" A3="3" A4="4" A5="5" A6="6"/><Tech C=")" + c + R"("/><DiL>)" + text +
           "</DiL><IPOC>7</IPOC></Rob>";
  };
  layout.learn(frame("1.0", "0"));
  EXPECT_TRUE(layout.read(frame("", "a longer one")));
  EXPECT_FALSE(layout.read(frame("<", "0"))) << "no attribute has that";
  EXPECT_FALSE(layout.read(frame("1"s + '\0', "0"))) << "the frame ends here";
}

TEST(FrameLayout, OfAnotherFrameFitsNot) {
  std::mt19937_64 random{2};
  for (const std::string& learned : kLayouts) {
    FrameLayout layout;
    layout.learn(filled(learned, random));
    for (const std::string& other : kLayouts)
      EXPECT_EQ(layout.read(filled(other, random)).has_value(), &learned == &other);
  }
  FrameLayout none;
  EXPECT_FALSE(none.read(filled(kLayouts[0], random)));
}

TEST(FrameLayout, OfAFrameTooLargeOrTooRichIsNotKept) {
  const auto frame_with = [](const std::string& more) {
    return "<Rob><ASPos A1=\"1\" A2=\"2\" A3=\"3\" A4=\"4\" A5=\"5\" A6=\"6\"/>" + more +
           "<IPOC>7</IPOC></Rob>";
  };
  std::string many;
  for (int i = 0; i < 200; ++i) many += "<T C=\"0\"/>";
  for (const std::string& more : {many, std::string(60'000, ' ')}) {
    RobotFrameDecoder decoder;
    FrameLayout layout;
    ASSERT_TRUE(decode_robot_frame(frame_with(more)));
    layout.learn(frame_with(more));
    EXPECT_FALSE(layout.read(frame_with(more)));
    for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(expect_one_decoding(decoder, frame_with(more)));
  }
}

TEST(RobotFrameDecoder, DecodesWhateverIsChangedAsTheGeneralDecoderDoes) {
  constexpr unsigned kSeed = 20265;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random{kSeed};
  const std::string interesting = "<>/=\"' \0naifxe+-.0123456789AEIPOC&!?\r\n"s;
  std::vector<RobotFrameDecoder> decoders(kLayouts.size());
  for (int round = 0; round < 60'000 / share(); ++round) {
    const std::size_t kind = random() % kLayouts.size();
    std::string text = filled(kLayouts[kind], random);
    ASSERT_NO_FATAL_FAILURE(expect_one_decoding(decoders[kind], text));
    for (std::uint64_t changes = 1 + random() % 3; changes > 0; --changes) {
      const std::size_t at = random() % text.size();
      const char c = interesting[random() % interesting.size()];
      if (random() % 3 == 0) {
        text.erase(at, 1 + random() % 4);
      } else if (random() % 2 == 0) {
        text.insert(at, 1 + random() % 3, c);
      } else {
        text[at] = c;
      }
    }
    ASSERT_NO_FATAL_FAILURE(expect_one_decoding(decoders[kind], text));
  }
}

TEST(RobotFrameDecoder, DecodesAFrameWithAnyByteChangedOrCutAnywhereAsTheGeneralDecoderDoes) {
  std::mt19937_64 random{3};
  for (const std::string& layout : kLayouts) {
    const std::string good = filled(layout, random);
    RobotFrameDecoder decoder;
    for (std::size_t at = 0; at < good.size(); ++at) {
      ASSERT_NO_FATAL_FAILURE(expect_one_decoding(decoder, good.substr(0, at)));
      std::string bytes = good;
      // Each place meets other bytes than the one before it.
      for (int value = static_cast<int>(at) % share(); value < 256; value += share()) {
        bytes[at] = static_cast<char>(value);
        RobotFrameDecoder learned;
        learned.decode(good);
        ASSERT_NO_FATAL_FAILURE(expect_one_decoding(learned, bytes));
      }
    }
  }
}

TEST(RobotFrameDecoder, DoesNotAllocate) {
  std::mt19937_64 random{4};
  RobotFrameDecoder decoder;
  std::vector<std::string> frames;
  for (int round = 0; round < 20; ++round) {
    for (const std::string& layout : kLayouts) frames.push_back(filled(layout, random));
  }
  const auto before = allocations();
  for (const std::string& frame : frames) {
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(decoder.decode(frame));
  }
  EXPECT_EQ(allocations(), before);
}

}  // namespace
}  // namespace truepose::rsi
