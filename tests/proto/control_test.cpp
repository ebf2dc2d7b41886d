#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <boost/json/parse.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <random>

#include "proto/control/json_text.hpp"
#include "proto/control/line_splitter.hpp"
#include "proto/control/request.hpp"
#include "proto/control/schema.hpp"
#include "proto/rpc/methods.hpp"

namespace truepose::control {
namespace {

namespace json = boost::json;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::string_view kStart =
    R"({"jsonrpc":"2.0","id":7,"method":"campaign.start","params":{"identify_poses":30,"seed":-3,"note":"\u00e4 \"b\""}})";

ErrorCode code_of(std::string_view line) {
  const auto request = decode_request(line);
  return request ? ErrorCode{} : request.error().error.code;
}

std::string message_of(std::string_view line) {
  const auto request = decode_request(line);
  return request ? "" : request.error().error.message;
}

TEST(ControlLines, AreCutAtNewlinesWhereverThePacketsEnd) {
  const std::string bytes = "one\r\n\ntwo\nthree";
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    LineSplitter lines{16};
    lines.push(bytes.substr(0, cut));
    lines.push(bytes.substr(cut));
    EXPECT_EQ(lines.next(), "one");
    EXPECT_EQ(lines.next(), "two");
    EXPECT_EQ(lines.next(), std::nullopt);
    EXPECT_TRUE(lines.partial());
    EXPECT_FALSE(lines.overflowed());
  }
}

TEST(ControlLines, MayBeAsLongAsTheLimitAndNotAByteLonger) {
  LineSplitter lines{4};
  lines.push("1234\n12345");
  EXPECT_FALSE(lines.overflowed());
  EXPECT_EQ(lines.next(), "1234");
  EXPECT_TRUE(lines.overflowed());
  lines.push("\n");
  EXPECT_TRUE(lines.overflowed());
  EXPECT_EQ(lines.next(), std::nullopt);
  lines.set_max_line(5);
  EXPECT_EQ(lines.next(), "12345");
}

TEST(ControlRequest, IsReadFromOneLine) {
  const auto request = decode_request(kStart);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->id, Id{7});
  EXPECT_EQ(request->method, "campaign.start");
  EXPECT_EQ(request->params.at("identify_poses").as_int64(), 30);
  EXPECT_EQ(request->params.at("note").as_string(), "ä \"b\"");
}

TEST(ControlRequest, WithoutAnIdIsANotificationWhateverItsParameters) {
  const auto request = decode_request(R"({"jsonrpc":"2.0","method":"x","params":[1]})");
  ASSERT_TRUE(request);
  EXPECT_TRUE(request->is_notification());
}

TEST(ControlRequest, MayHaveATextAsIdAndNoParameters) {
  const auto request = decode_request(R"({"method":"cell.status","id":"a-1","jsonrpc":"2.0"})");
  ASSERT_TRUE(request);
  EXPECT_EQ(request->id, Id{"a-1"});
  EXPECT_TRUE(request->params.empty());
}

TEST(ControlRequest, ThatIsNotJsonIsAParseError) {
  for (const char* line :
       {"", "{", "nonsense", "{\"a\":1}}", "{\"a\":01}", "{'a':1}", "{\"a\":NaN}", "{\"a\":1,}", "\xff\xfe",
        "{\"a\":\"\xc3\x28\"}", "{\"a\":\"\\ud800\"}", "{\"a\":\"\x01\"}", "{} {}"})
    EXPECT_EQ(code_of(line), ErrorCode::ParseError) << line;
}

TEST(ControlRequest, NamesTheKeyThatAppearsTwice) {
  EXPECT_THAT(message_of(R"({"jsonrpc":"2.0","id":1,"method":"x","params":{"a":1,"\u0061":2}})"),
              HasSubstr(R"(key "a" appears twice)"));
  EXPECT_EQ(code_of(R"({"id":1,"id":2})"), ErrorCode::ParseError);
  EXPECT_TRUE(decode_request(
      R"({"jsonrpc":"2.0","id":1,"method":"x","params":{"a":{"a":1},"b":[{"a":1},{"a":1}]}})"));
}

TEST(ControlRequest, RefusesNumbersThatOverflow) {
  for (const char* number : {"1e999", "-1e999", "1e99999999999999999999", "123456789e400"})
    EXPECT_EQ(code_of(std::string{R"({"jsonrpc":"2.0","id":1,"method":"x","params":{"a":)"} + number + "}}"),
              ErrorCode::ParseError)
        << number;
}

TEST(ControlRequest, RefusesMoreThanSixteenLevels) {
  const auto nested = [](std::size_t levels) {
    return R"({"jsonrpc":"2.0","id":1,"method":"x","params":{"a":)" + std::string(levels - 2, '[') +
           std::string(levels - 2, ']') + "}}";
  };
  EXPECT_TRUE(decode_request(nested(16)));
  EXPECT_EQ(code_of(nested(17)), ErrorCode::ParseError);
  EXPECT_EQ(code_of(nested(60'000)), ErrorCode::ParseError);
}

TEST(ControlRequest, ThatIsNoRequestSaysWhatIsWrong) {
  const auto invalid = [](std::string_view line) {
    EXPECT_EQ(code_of(line), ErrorCode::InvalidRequest) << line;
    return message_of(line);
  };
  EXPECT_THAT(invalid("[]"), HasSubstr("batches"));
  EXPECT_THAT(invalid("3"), HasSubstr("object"));
  EXPECT_THAT(invalid(R"({"jsonrpc":"2.0","id":null,"method":"x"})"), HasSubstr("id:"));
  EXPECT_THAT(invalid(R"({"jsonrpc":"2.0","id":1.5,"method":"x"})"), HasSubstr("id:"));
  EXPECT_THAT(invalid(R"({"jsonrpc":"2.0","id":18446744073709551615,"method":"x"})"), HasSubstr("id:"));
  EXPECT_THAT(invalid(R"({"jsonrpc":"1.0","id":1,"method":"x"})"), HasSubstr("jsonrpc"));
  EXPECT_THAT(invalid(R"({"jsonrpc":"2.0","id":1})"), HasSubstr("method"));
  EXPECT_THAT(invalid(R"({"jsonrpc":"2.0","id":1,"method":"x","parms":{}})"), HasSubstr("\"parms\""));
  EXPECT_EQ(code_of(R"({"jsonrpc":"2.0","id":1,"method":"x","params":[1]})"), ErrorCode::InvalidParams);
}

TEST(ControlRequest, IsAnsweredUnderItsIdEvenIfItIsInvalid) {
  EXPECT_EQ(decode_request(R"({"jsonrpc":"2.0","id":"k"})").error().id, Id{"k"});
  EXPECT_EQ(decode_request("{").error().id, Id{});
}

TEST(ControlRequest, TruncatedAnywhereIsAParseError) {
  for (std::size_t length = 0; length < kStart.size(); ++length)
    EXPECT_EQ(code_of(kStart.substr(0, length)), ErrorCode::ParseError) << length;
}

TEST(ControlRequest, WithAnyBitFlippedIsReadOrRefusedWithASentence) {
  for (std::size_t at = 0; at < kStart.size(); ++at)
    for (unsigned bit = 0; bit < 8; ++bit) {
      std::string line{kStart};
      line[at] = static_cast<char>(static_cast<unsigned char>(line[at]) ^ (1U << bit));
      const auto request = decode_request(line);
      EXPECT_TRUE(request || !request.error().error.message.empty());
    }
}

TEST(ControlRequest, SurvivesRandomPiecesOfJson) {
  constexpr unsigned kSeed = 20261121;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  const std::string_view alphabet = "{}[]\",:\\u0e1-.tn jsonrpcidmethodparams2\n\x80\xff";
  for (int trial = 0; trial < 20'000; ++trial) {
    std::string line(random() % 64, ' ');
    for (char& byte : line) byte = alphabet[random() % alphabet.size()];
    if (trial % 2) line.insert(0, kStart.substr(0, random() % kStart.size()));
    const auto request = decode_request(line);
    EXPECT_TRUE(request || !request.error().error.message.empty());
    (void)decode_server_line(line);
  }
}

TEST(ControlReply, HasTheGoldenForm) {
  EXPECT_EQ(encode_result(7, {{"state", "ready"}, {"error_mm", 0.042}, {"poses", 30}, {"x", 1.0}}),
            R"({"jsonrpc":"2.0","id":7,"result":{"state":"ready","error_mm":0.042,"poses":30,"x":1.0}})"
            "\n");
  EXPECT_EQ(encode_error("a", {ErrorCode::InvalidParams, "params.n: is missing", "params.n"}),
            R"({"jsonrpc":"2.0","id":"a","error":{"code":-32602,"message":"params.n: is missing",)"
            R"("data":{"code":"E_PARAMS","path":"params.n"}}})"
            "\n");
  EXPECT_EQ(encode_error({}, {ErrorCode::WrongState, "no campaign runs", "", "ready", {"campaign.start"}}),
            R"({"jsonrpc":"2.0","id":null,"error":{"code":-32003,"message":"no campaign runs",)"
            R"("data":{"code":"E_STATE","state":"ready","allowed":["campaign.start"]}}})"
            "\n");
  EXPECT_EQ(encode_event_text(5, "2026-01-02T03:04:05.678Z", Topic::Fault, R"({"text":"line\nbreak"})"),
            R"({"jsonrpc":"2.0","method":"event","params":{"seq":5,"time":"2026-01-02T03:04:05.678Z",)"
            R"("topic":"fault","data":{"text":"line\nbreak"}}})"
            "\n");
  EXPECT_EQ(encode_request(1, "cell.status", {}),
            R"({"jsonrpc":"2.0","id":1,"method":"cell.status","params":{}})"
            "\n");
}

TEST(ControlReply, IsReadBackByTheClient) {
  const RpcError error{ErrorCode::WrongState, "no", "", "ready", {"campaign.start"}};
  const auto line = encode_error(3, error);
  const auto message = decode_server_line(std::string_view{line}.substr(0, line.size() - 1));
  ASSERT_TRUE(message);
  const auto& reply = std::get<Reply>(*message);
  EXPECT_EQ(reply.id, Id{3});
  ASSERT_FALSE(reply.result);
  EXPECT_EQ(reply.result.error().code, ErrorCode::WrongState);
  EXPECT_EQ(reply.result.error().state, "ready");
  EXPECT_THAT(reply.result.error().allowed, ElementsAre("campaign.start"));

  const auto event = decode_server_line(encode_event_text(9, "t", Topic::Log, R"({"text":"x"})"));
  ASSERT_TRUE(event);
  EXPECT_EQ(std::get<Event>(*event).seq, 9U);
  EXPECT_EQ(std::get<Event>(*event).topic, "log");
}

TEST(ControlReply, OfAStrangeServerIsAnErrorNotACrash) {
  for (const char* line :
       {"[]", "{}", R"({"jsonrpc":"2.0","id":1})", R"({"jsonrpc":"2.0","id":1,"result":1,"error":{}})",
        R"({"jsonrpc":"2.0","method":"event"})", R"({"jsonrpc":"2.0","id":[],"result":1})",
        R"({"jsonrpc":"2.0","method":"event","params":{"seq":-1,"data":{}}})"})
    EXPECT_FALSE(decode_server_line(line)) << line;
}

TEST(JsonText, KeepsEveryDigitAndTurnsWhatIsNoNumberIntoNull) {
  for (const double number : {0.1, -1e-300, 1.7976931348623157e308, 123456789.0, 5e-324})
    EXPECT_EQ(json::parse(json_text(number)).as_double(), number);
  EXPECT_EQ(
      json_text({1.0, std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}),
      "[1.0,null,null]");
}

TEST(JsonText, IsReadBackToTheLastBit) {
  std::mt19937_64 random{20261125};
  for (int trial = 0; trial < 20'000; ++trial) {
    const double number = std::bit_cast<double>(random());
    if (!std::isfinite(number)) continue;
    const auto again = parse_json(json_text(number));
    ASSERT_TRUE(again) << again.error();
    EXPECT_EQ(again->as_double(), number) << json_text(number);
  }
}

// What strtod makes of a text is what it says.
TEST(JsonText, IsTheDoubleNearestToWhatIsWritten) {
  for (const char* text : {"18446744073709254000000", "1.8446744073709254e+22", "9007199254740993.0",
                           "123456789012345678901234567890", "0.1234567890123456789012345678901234567890",
                           "2.2250738585072011e-308", "4.9406564584124654e-324", "1e-999", "-1e-999",
                           "9355950000000000000.00000000000000000000000000000000018446744073709551616e-7"}) {
    const auto read = parse_json(text);
    ASSERT_TRUE(read) << text << ": " << read.error();
    EXPECT_EQ(read->as_double(), std::strtod(text, nullptr)) << text;
  }
  for (const char* text : {"1e999", "-1e999", "1.7976931348623159e308"})
    EXPECT_FALSE(parse_json(text)) << text;
}

TEST(Schema, IsValidAndItsOutlineAndEachMethodFitOneLine) {
  const auto schema = parse_json(openrpc_text());
  ASSERT_TRUE(schema) << schema.error();
  EXPECT_LT(encode_result(1, openrpc_outline()).size(), kMaxLine);
  for (const std::string& method : rpc::method_names()) {
    ASSERT_TRUE(openrpc_method(method)) << method;
    EXPECT_LT(encode_result(1, *openrpc_method(method)).size(), kMaxLine) << method;
  }
}

/// Every "$ref" below `value`.
void collect_references(const json::value& value, std::vector<std::string>& references) {
  if (const auto* object = value.if_object()) {
    for (const auto& [key, member] : *object) {
      if (key == "$ref") references.emplace_back(member.as_string());
      collect_references(member, references);
    }
  } else if (const auto* array = value.if_array()) {
    for (const auto& element : *array) collect_references(element, references);
  }
}

TEST(Schema, RefersOnlyToWhatItDefinesOrToAFileOfItsFolder) {
  const json::value schema = *parse_json(openrpc_text());
  std::vector<std::string> references;
  collect_references(schema, references);
  EXPECT_GT(references.size(), 50U);
  for (const auto& reference : references) {
    if (reference == "report.schema.json") {
      EXPECT_TRUE(std::filesystem::exists(TRUEPOSE_SOURCE_DIR "/proto/control/" + reference));
      continue;
    }
    boost::system::error_code missing;
    EXPECT_NE(schema.find_pointer(reference.substr(1), missing), nullptr) << reference;
  }
}

TEST(Schema, ListsTheErrorCodesAsTheyAreSent) {
  const json::value schema = *parse_json(openrpc_text());
  for (const auto& [name, error] : schema.at_pointer("/components/errors").as_object()) {
    const auto code = static_cast<ErrorCode>(error.at("code").as_int64());
    EXPECT_EQ(std::string{error.at_pointer("/data/code").as_string()}, symbol(code)) << name;
  }
}

TEST(Schema, DescribesEveryTopic) {
  const json::value schema = *parse_json(openrpc_text());
  std::vector<std::string> topics;
  for (const auto& event : schema.at("x-events").as_array())
    topics.emplace_back(event.at("topic").as_string());
  ASSERT_EQ(topics.size(), kTopics.size());
  for (std::size_t i = 0; i < topics.size(); ++i) EXPECT_EQ(topic_from_name(topics[i]), kTopics[i].value);
}

}  // namespace
}  // namespace truepose::control
