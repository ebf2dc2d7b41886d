#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/math/angles.hpp"
#include "proto/eki/document_splitter.hpp"
#include "proto/eki/messages.hpp"

namespace truepose::eki {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Axes from_deg(Axes deg) {
  for (double& value : deg) value *= kRadPerDeg;
  return deg;
}

const std::vector<ToController> kToController{
    Command{17, CommandType::Ptp, 20, 50, 500, from_deg({10, -90, 90, 0.125, -0.5, 350})},
    Control{18, ControlOp::SetOverride, 30},
};
const std::vector<FromController> kFromController{
    Hello{1, "#KR210R2700_2 C4 FLR", "864213", 0, 0, "KSS 8.6.11"},
    Ack{17, AckState::InPosition, 0, from_deg({10, -90, 90, 0.125, -0.5, 350})},
    Ack{18, AckState::Rejected, 1, {}},
    State{.sequence = 5,
          .id = 19,
          .mode = OperatingMode::Ext,
          .override_percent = 30,
          .program = ProgramState::Active,
          .drives_ready = true,
          .no_emergency_stop = true,
          .gate_closed = true,
          .stop_message = false,
          .moving = true,
          .in_position = false,
          .serial = 864213,
          .axes_rad = from_deg({10, -90, 90, 0.125, -0.5, 350}),
          .pose = {1765, -0.5, 1910, 180, 89.5, -180},
          .base = 0,
          .tool = 2,
          .tool_frame = std::array<double, 6>{10, -20.5, 250, 90, -45, 0},
          .base_frame = std::array<double, 6>{900, 0, 500, 0, 0, 180},
          .load_kg = 42.5},
};

constexpr const char* kCommandGolden =
    R"(<Cmd Id="17" Type="1" Vel="20" Acc="50" Settle="500"><Ax A1="10.000000" A2="-90.000000" A3="90.000000" )"
    R"(A4="0.125000" A5="-0.500000" A6="350.000000"></Ax></Cmd>)";
constexpr const char* kStateGolden =
    R"(<Robot><State Seq="5" Id="19" ModeOp="4" OvPro="30" ProState="3" PeriRdy="1" AlarmStop="1" UserSaf="1" StopMess="0" )"
    R"(ProMove="1" InPos="0" Serial="864213"><Ax A1="10.000000" A2="-90.000000" A3="90.000000" A4="0.125000" A5="-0.500000" )"
    R"(A6="350.000000"></Ax><Pos X="1765.000000" Y="-0.500000" Z="1910.000000" A="180.000000" B="89.500000" )"
    R"(C="-180.000000"></Pos><Base No="0"></Base><Tool No="2"></Tool><ToolFrame X="10.000000" Y="-20.500000" Z="250.000000" )"
    R"(A="90.000000" B="-45.000000" C="0.000000"></ToolFrame><BaseFrame X="900.000000" Y="0.000000" Z="500.000000" )"
    R"(A="0.000000" B="0.000000" C="180.000000"></BaseFrame><Load M="42.500000"></Load></State></Robot>)";

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string error_of(const std::string& document) {
  const auto message = decode_from_controller(document);
  EXPECT_FALSE(message) << document;
  return message ? "" : message.error();
}

std::vector<std::string> split(const std::vector<std::string_view>& pieces) {
  DocumentSplitter splitter;
  std::vector<std::string> documents;
  for (const std::string_view piece : pieces) {
    splitter.feed(piece);
    for (auto next = splitter.next(); next && *next; next = splitter.next()) documents.push_back(**next);
  }
  return documents;
}

TEST(EkiMessages, AreWrittenToGoldenBytes) {
  EXPECT_EQ(encode(kToController[0]), kCommandGolden);
  EXPECT_EQ(encode(kToController[1]), R"(<Ctl Id="18" Op="1" Val="30"></Ctl>)");
  EXPECT_EQ(
      encode(kFromController[0]),
      R"(<Robot><Hello Ver="1" Model="#KR210R2700_2 C4 FLR" Serial="864213" Tool="0" Base="0" KssVer="KSS 8.6.11"></Hello></Robot>)");
  EXPECT_EQ(encode(kFromController[2]), R"(<Robot><Ack Id="18" State="4" Err="1"></Ack></Robot>)");
  EXPECT_EQ(encode(kFromController[3]), kStateGolden);
}

TEST(EkiMessages, AreReadAsTheyWereWritten) {
  for (const ToController& message : kToController)
    EXPECT_EQ(decode_to_controller(encode(message)).value(), message);
  for (const FromController& message : kFromController) {
    EXPECT_THAT(decode_from_controller(encode(message)).value(), ElementsAre(message));
  }
}

TEST(EkiMessages, AreReadInAnyOrderSelfClosedAndWithElementsOfOtherMessages) {
  const auto message = decode_from_controller(
      "<Ack\n Err='0' State='3' Id='17'>\r\n<Pos X='1'/><Hello Ver='1'>text</Hello>"
      "<Ax A6='350' A5='-0.5' A4='0.125' A3='90' A2='-90' A1='10'/></Ack>\n");
  ASSERT_TRUE(message) << message.error();
  EXPECT_THAT(*message, ElementsAre(kFromController[1]));
}

TEST(EkiMessages, AreReadAsControllersWriteNumbersAndFlags) {
  const auto expect_state = [](const std::string& text) {
    const auto messages = decode_from_controller(text);
    ASSERT_TRUE(messages) << messages.error();
    EXPECT_THAT(*messages, ElementsAre(kFromController[3])) << text;
  };
  const std::string state = kStateGolden;
  expect_state(replaced(state, R"(Seq="5")", R"(Seq="5.000000")"));
  expect_state(replaced(state, R"(Id="19")", R"(Id="+19")"));
  expect_state(replaced(state, R"(PeriRdy="1")", R"(PeriRdy="TRUE")"));
  expect_state(replaced(state, R"(StopMess="0")", R"(StopMess="False")"));
  expect_state(replaced(state, R"(AlarmStop="1")", R"(AlarmStop="1.0")"));
  expect_state(replaced(state, R"(A1="10.000000")", R"(A1="+1.0e1")"));
  expect_state("\xEF\xBB\xBF" + state + std::string(300, '\0'));
  EXPECT_THAT(error_of(replaced(state, R"(Seq="5")", R"(Seq="5.5")")), HasSubstr("expected an integer"));
  EXPECT_THAT(error_of(replaced(state, R"(Seq="5")", R"(Seq="5000000000")")),
              HasSubstr("expected an integer"));
  EXPECT_THAT(error_of(replaced(state, R"(PeriRdy="1")", R"(PeriRdy="YES")")), HasSubstr("expected 0 or 1"));
  EXPECT_THAT(error_of(replaced(state, R"(PeriRdy="1")", R"(PeriRdy="")")), HasSubstr("PeriRdy is missing"));
}

TEST(EkiMessages, StateMayComeWithoutBaseAndTool) {
  const auto expect_state_without_tool = [](const std::string& text) {
    const auto messages = decode_from_controller(text);
    ASSERT_TRUE(messages) << messages.error();
    State expected = std::get<State>(kFromController[3]);
    expected.tool.reset();
    EXPECT_THAT(*messages, ElementsAre(expected));
  };
  expect_state_without_tool(replaced(kStateGolden, R"(<Tool No="2"></Tool>)", ""));
  expect_state_without_tool(replaced(kStateGolden, R"(<Tool No="2"></Tool>)", "<Tool></Tool>"));
  expect_state_without_tool(replaced(kStateGolden, R"(<Tool No="2"></Tool>)", R"(<Tool No=""></Tool>)"));
}

TEST(EkiMessages, StateMayComeWithoutTheArmsNumber) {
  State expected = std::get<State>(kFromController[3]);
  expected.serial.reset();
  for (const char* without : {"", R"( Serial="")"}) {
    const auto messages = decode_from_controller(replaced(kStateGolden, R"( Serial="864213")", without));
    ASSERT_TRUE(messages) << messages.error();
    EXPECT_THAT(*messages, ElementsAre(expected));
  }
}

TEST(EkiMessages, WhoseValuesAreAllEmptySayNothing) {
  for (const char* blank :
       {R"(<Ack Id="" State="" Err=""><Ax A1="" A2="" A3="" A4="" A5="" A6=""></Ax></Ack>)",
        "<Hello Ver='' Model=' ' Serial=''/>", "<State/>", "<Robot></Robot>",
        "<Robot><Ack Id=''/><Hello Ver=''/></Robot>"}) {
    const auto messages = decode_from_controller(blank);
    ASSERT_TRUE(messages) << messages.error();
    EXPECT_THAT(*messages, testing::IsEmpty()) << blank;
  }
  const auto ack = decode_from_controller(
      R"(<Ack Id="18" State="4" Err="1"><Ax A1="" A2="" A3="" A4="" A5="" A6=""></Ax></Ack>)");
  ASSERT_TRUE(ack) << ack.error();
  EXPECT_THAT(*ack, ElementsAre(kFromController[2]));
  EXPECT_THAT(error_of(R"(<Ack Id="18" State="4" Err="1"><Ax A1="1" A2="" A3="" A4="" A5="" A6=""/></Ack>)"),
              "Ack: Ax.A2 is missing");
}

std::string as_root(const FromController& message) {
  const std::string text = encode(message);
  constexpr std::size_t kOpen = std::string_view{"<Robot>"}.size(), kClose = kOpen + 1;
  return text.substr(kOpen, text.size() - kOpen - kClose);
}

TEST(EkiMessages, AreReadAsRootsToo) {
  for (const FromController& message : kFromController)
    EXPECT_THAT(decode_from_controller(as_root(message)).value(), ElementsAre(message)) << as_root(message);
}

TEST(EkiMessages, AreReadBelowOneRootInAnyNumber) {
  const std::string hello = as_root(kFromController[0]), ack = as_root(kFromController[1]);
  const auto messages_of = [](const std::string& text) {
    const auto messages = decode_from_controller(text);
    EXPECT_TRUE(messages) << messages.error();
    return messages.value_or(std::vector<FromController>{});
  };
  EXPECT_THAT(messages_of("<Robot>" + ack + "</Robot>"), ElementsAre(kFromController[1]));
  EXPECT_THAT(
      messages_of("<Robot Type='KUKA'><Hello Ver=''></Hello>" + ack + "<Note A='1'><Ax/></Note></Robot>"),
      ElementsAre(kFromController[1]));
  EXPECT_THAT(messages_of("<Robot>" + hello + ack + "</Robot>"),
              ElementsAre(kFromController[0], kFromController[1]));
  EXPECT_THAT(error_of("<Robot>" + replaced(ack, "Id=", "No=") + "</Robot>"), "Ack: Id is missing");
  EXPECT_THAT(error_of("<Robots>" + ack + "</Robots>"), HasSubstr("<Robots> is not known here"));
  EXPECT_THAT(error_of("<Robot>" + ack), HasSubstr("Robot: not a well-formed document"));
}

TEST(EkiMessages, HaveTextsThatMayBeLoggedAndPrinted) {
  const auto serial_of = [](std::string serial) {
    Hello hello = std::get<Hello>(kFromController[0]);
    hello.serial = std::move(serial);
    return std::get<Hello>(decode_from_controller(encode(FromController{hello})).value().at(0)).serial;
  };
  EXPECT_EQ(serial_of("864213                  "), "864213");
  EXPECT_EQ(serial_of(" \t864213 \n"), "864213");
  EXPECT_EQ(serial_of("1\n2026-01-01 ok \tforged"), "1 2026-01-01 ok  forged");
  EXPECT_EQ(serial_of("K\xC3\xB6ln \xE2\x82\xAC"), "K\xC3\xB6ln \xE2\x82\xAC");
  EXPECT_EQ(serial_of("\xFF\xC3(\xED\xA0\x80"), "\uFFFD\uFFFD(\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(serial_of("\x7F\xC2\x9B"
                      "2J"),
            "\uFFFD\uFFFD2J");
  const auto escape = decode_from_controller("<Hello Ver='1' Model='' Serial='\x1B[2J' KssVer=''/>");
  EXPECT_EQ(std::get<Hello>(escape.value().at(0)).serial, "\uFFFD[2J");

  std::string euros;
  for (int i = 0; i < 200; ++i) euros += "\xE2\x82\xAC";
  EXPECT_EQ(serial_of(std::string(60'000, 'x')), std::string(200, 'x'));
  EXPECT_EQ(serial_of(euros + euros), euros);
}

TEST(EkiMessages, AreComplainedOfInShortWhateverTheyCarry) {
  const std::string huge(60'000, '\x1B');
  for (const std::string& document :
       {"<Ack Id=\"" + huge + "\" State=\"1\" Err=\"0\"/>", "<" + std::string(60'000, 'x') + "/>",
        "<Hello Ver='" + huge + "'", "<" + std::string(60'000, 'x') + "><"}) {
    const std::string error = error_of(document);
    EXPECT_LT(error.size(), 1000u);
    EXPECT_EQ(error.find('\x1B'), std::string::npos);
  }
}

TEST(EkiMessages, KeepSpecialCharactersOfText) {
  const Hello hello{1, R"(a<b>&"c"')", "", 0, 0, "8.6"};
  EXPECT_THAT(decode_from_controller(encode(FromController{hello})).value(),
              ElementsAre(FromController{hello}));
  EXPECT_THAT(error_of(replaced(encode(kFromController[0]), "864213", "8&x;")), HasSubstr("Hello: Serial"));
}

TEST(EkiMessages, SayWhichFieldIsWrong) {
  const std::string state = kStateGolden;
  EXPECT_THAT(error_of(replaced(state, R"( A3="90.000000")", "")), "State: Ax.A3 is missing");
  EXPECT_THAT(error_of(replaced(state, "90.000000", "nan")),
              "State: Ax.A2 is \"-nan\", expected a finite number");
  EXPECT_THAT(error_of(replaced(state, R"(ModeOp="4")", R"(ModeOp="7")")), HasSubstr("ModeOp is 7"));
  EXPECT_THAT(error_of(replaced(state, R"(PeriRdy="1")", R"(PeriRdy="2")")), HasSubstr("PeriRdy is \"2\""));
  EXPECT_THAT(error_of(replaced(state, R"(Id="19")", R"(Seq="19")")), HasSubstr("Seq comes twice"));
  EXPECT_THAT(error_of(replaced(state, "<Tool No=\"2\"></Tool>", "<Base No=\"2\"></Base>")),
              "State: Base comes twice");
  EXPECT_THAT(error_of(kCommandGolden), HasSubstr("<Cmd> is not known here"));
  EXPECT_FALSE(decode_to_controller(replaced(kCommandGolden, R"(Type="1")", R"(Type="2")")));
}

/// "Ack/Ax/@A1" and so on of an element and what is in it.
void collect_tags(const pugi::xml_node& node, const std::string& path, std::set<std::string>& tags) {
  for (const pugi::xml_attribute& attribute : node.attributes()) tags.insert(path + "/@" + attribute.name());
  for (const pugi::xml_node& child : node.children()) collect_tags(child, path + "/" + child.name(), tags);
}

std::set<std::string> tags_of(const std::vector<std::string>& documents) {
  std::set<std::string> tags;
  for (const std::string& text : documents) {
    pugi::xml_document document;
    EXPECT_TRUE(document.load_string(text.c_str()));
    collect_tags(document.document_element(), document.document_element().name(), tags);
  }
  return tags;
}

TEST(EkiMessages, AreExactlyWhatTheShippedChannelsCarry) {
  const auto listed = [](const char* file, const char* list) {
    pugi::xml_document document;
    EXPECT_TRUE(document.load_file((TRUEPOSE_SOURCE_DIR "/config/kuka/eki/" + std::string{file}).c_str()));
    std::set<std::string> tags;
    for (const pugi::xml_node& element : document.document_element().child(list).child("XML").children()) {
      const std::string tag = element.attribute("Tag").value();
      if (tag.contains('@')) tags.insert(tag);
    }
    return tags;
  };
  EXPECT_EQ(listed("CellLink.xml", "RECEIVE"), tags_of({encode(kToController[0])}));
  EXPECT_EQ(listed("CellLink.xml", "SEND"),
            tags_of({encode(kFromController[0]), encode(kFromController[1])}));
  EXPECT_EQ(listed("CellState.xml", "RECEIVE"), tags_of({encode(kToController[1])}));
  EXPECT_EQ(listed("CellState.xml", "SEND"), tags_of({encode(kFromController[3])}));
}

TEST(EkiMessages, CutOrWithAnyByteChangedAreRefusedOrFinite) {
  const std::string golden = kStateGolden;
  for (std::size_t position = 0; position < golden.size(); ++position) {
    EXPECT_FALSE(decode_from_controller(golden.substr(0, position))) << position;
    for (int value = 0; value < 256; value += position % 16 == 0 ? 1 : 13) {
      std::string bytes = golden;
      bytes[position] = static_cast<char>(value);
      const auto message = decode_from_controller(bytes);
      if (!message || message->empty()) continue;
      const State& state = std::get<State>(message->at(0));
      EXPECT_TRUE(std::ranges::all_of(state.axes_rad, [](double v) { return std::isfinite(v); })) << bytes;
      EXPECT_TRUE(std::ranges::all_of(state.pose, [](double v) { return std::isfinite(v); })) << bytes;
    }
  }
}

TEST(DocumentSplitter, FindsTheDocumentsWhereverTheStreamIsCut) {
  const std::string stream = std::string{kCommandGolden} + "\n" + kStateGolden + "<a/>";
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    const std::string_view view = stream;
    EXPECT_THAT(split({view.substr(0, cut), view.substr(cut)}),
                ElementsAre(kCommandGolden, kStateGolden, "<a/>"))
        << cut;
  }
}

TEST(DocumentSplitter, FindsTheDocumentsByteByByteAndInRandomPieces) {
  constexpr unsigned kSeed = 20263;
  SCOPED_TRACE(kSeed);
  std::mt19937 random{kSeed};
  const std::string stream = std::string{kStateGolden} + kCommandGolden;
  for (unsigned largest : {1u, 2u, 7u, 50u}) {
    std::vector<std::string_view> pieces;
    for (std::string_view rest = stream; !rest.empty();) {
      const std::size_t size = std::min<std::size_t>(rest.size(), 1 + random() % largest);
      pieces.push_back(rest.substr(0, size));
      rest.remove_prefix(size);
    }
    EXPECT_THAT(split(pieces), ElementsAre(kStateGolden, kCommandGolden));
  }
}

TEST(DocumentSplitter, SkipsPaddingAndTheTailOfAnOlderDocument) {
  using namespace std::string_literals;
  const std::string block = "<Ctl Id='1'/>\n\0\0\0\0"s + R"(A6="1.0"></Ax></Cmd>)" + "\n\0\0"s;
  EXPECT_THAT(split({block, block, "  <Ct", "<b></b>"}),
              ElementsAre("<Ctl Id='1'/>", "<Ctl Id='1'/>", "<b></b>"));
}

TEST(DocumentSplitter, IsNotMisledByQuotesCommentsAndInstructions) {
  const char* document =
      R"(<?xml version="1.0"?><!-- <b> --><a x="/>" y='</a>'><!--></a>--><b z=">"/><a></a></a>)";
  const std::string twice = std::string{document} + document;
  EXPECT_THAT(split({twice}), ElementsAre(document, document));
}

TEST(DocumentSplitter, RefusesADocumentAboveTheLimitAndGoesOnAfterReset) {
  DocumentSplitter splitter;
  splitter.feed("<a>" + std::string(DocumentSplitter::kMaxDocumentBytes, 'x'));
  EXPECT_THAT(splitter.next().error(), HasSubstr("64 KiB"));
  EXPECT_FALSE(splitter.next());
  splitter.reset();
  splitter.feed("<a></a>");
  EXPECT_EQ(splitter.next().value(), "<a></a>");
}

TEST(DocumentSplitter, DoesNotKeepWhatIsNoDocument) {
  DocumentSplitter splitter;
  for (int i = 0; i < 100; ++i) {
    splitter.feed(std::string(10000, '\0'));
    EXPECT_EQ(splitter.next().value(), std::nullopt);
  }
}

}  // namespace
}  // namespace truepose::eki
