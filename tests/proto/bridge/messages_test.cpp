#include "proto/bridge/messages.hpp"

#include <gmock/gmock.h>

#include <boost/json/parse.hpp>
#include <fstream>
#include <map>
#include <sstream>

namespace truepose::bridge {
namespace {

namespace json = boost::json;
using testing::HasSubstr;

std::string page() {
  std::ifstream in{std::string{TRUEPOSE_SOURCE_DIR} + "/docs/trackers.md"};
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Lines of the dialogue on the page of trackers, with who says them.
std::vector<std::pair<char, std::string>> dialogue() {
  std::vector<std::pair<char, std::string>> lines;
  std::istringstream text{page()};
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("> {") || line.starts_with("< {")) lines.emplace_back(line[0], line.substr(2));
  }
  return lines;
}

std::string written_again(const Asked& asked) {
  return std::visit([&](const auto& request) { return encode(asked.id, request); }, asked.request);
}

/// The answer read as that to the request and written again.
std::string written_again(const Reply& reply, const Request& request) {
  return std::visit(
      [&]<class Kind>(const Kind&) {
        if (!reply.outcome) return encode_refusal(reply.id, reply.outcome.error());
        const auto answer = answer_of<Kind>(*reply.outcome);
        EXPECT_TRUE(answer) << answer.error();
        return answer ? encode_answer(*reply.id, *answer) : "";
      },
      request);
}

void expect_same_json(const std::string& a, const std::string& b) {
  EXPECT_EQ(json::parse(a), json::parse(b)) << a << "\n" << b;
}

TEST(BridgeMessages, SayWhatTheDialogueOnTheirPageSays) {
  std::map<std::int64_t, Request> asked;
  int lines = 0;
  for (const auto& [who, line] : dialogue()) {
    SCOPED_TRACE(line);
    ++lines;
    if (who == '>') {
      const auto request = decode_request(line);
      ASSERT_TRUE(request) << request.error().refusal.text;
      asked.emplace(request->id, request->request);
      expect_same_json(written_again(*request), line);
      continue;
    }
    const auto message = decode_from_bridge(line);
    ASSERT_TRUE(message) << message.error();
    if (const auto* event = std::get_if<Event>(&*message)) {
      EXPECT_TRUE(event->kind());
      expect_same_json(encode(*event), line);
      continue;
    }
    const auto& reply = std::get<Reply>(*message);
    ASSERT_TRUE(asked.contains(*reply.id)) << "nobody asked";
    expect_same_json(written_again(reply, asked.at(*reply.id)), line);
    asked.erase(*reply.id);
  }
  EXPECT_GT(lines, 20);
  EXPECT_TRUE(asked.empty()) << "every request is answered";
}

template <std::size_t... kKinds>
std::vector<std::string> request_names(std::index_sequence<kKinds...>) {
  return {std::string{std::variant_alternative_t<kKinds, Request>::kName}...};
}

TEST(BridgeMessages, AreAllInTheTablesOfTheirPage) {
  const std::string text = page();
  for (const std::string& name : request_names(std::make_index_sequence<std::variant_size_v<Request>>{}))
    EXPECT_THAT(text, HasSubstr("\n| `" + name + "` |"));
  for (const auto& code : kErrorCodes) EXPECT_THAT(text, HasSubstr("\n| `" + std::string{code.name} + "` |"));
  for (const auto& event : kEvents) EXPECT_THAT(text, HasSubstr("\n| `" + std::string{event.name} + "` |"));
  for (const auto& state : kStates) EXPECT_THAT(text, HasSubstr("`" + std::string{state.name} + "`"));
  for (const auto& what : kRehearsals) EXPECT_THAT(text, HasSubstr("`" + std::string{what.name} + "`"));
}

/// The refusal of a request that cannot be carried out.
BadRequestReply bad_request_reply(std::string_view line) {
  const auto request = decode_request(line);
  EXPECT_FALSE(request) << line;
  return request ? BadRequestReply{} : request.error();
}

TEST(BridgeMessages, SayWhatIsWrongWithARequest) {
  EXPECT_EQ(bad_request_reply("no JSON").refusal.meaning(), ErrorCode::BadRequest);
  EXPECT_FALSE(bad_request_reply("no JSON").id);
  EXPECT_FALSE(bad_request_reply(R"({"do": "ping"})").id);
  EXPECT_FALSE(bad_request_reply(R"({"id": 0, "do": "ping"})").id);
  EXPECT_FALSE(bad_request_reply(R"({"id": 1.5, "do": "ping"})").id);
  EXPECT_FALSE(bad_request_reply(R"([1])").id);

  const BadRequestReply unknown = bad_request_reply(R"({"id": 3, "do": "dance"})");
  EXPECT_EQ(unknown.id, 3);
  EXPECT_EQ(unknown.refusal.meaning(), ErrorCode::NotOffered);
  EXPECT_THAT(unknown.refusal.text, HasSubstr("dance"));

  const BadRequestReply half =
      bad_request_reply(R"({"id": 4, "do": "aim", "x": 1, "y": 2, "z": 3, "timeout_ms": 5})");
  EXPECT_EQ(half.id, 4);
  EXPECT_EQ(half.refusal.meaning(), ErrorCode::BadRequest);
  EXPECT_THAT(half.refusal.text, HasSubstr("search_mm"));
  EXPECT_THAT(bad_request_reply(R"({"id": 5, "do": "face", "face": 3})").refusal.text, HasSubstr("face"));
  EXPECT_THAT(bad_request_reply(R"({"id": 6, "do": "measure", "time_ms": 1e99})").refusal.text,
              HasSubstr("time_ms"));
}

TEST(BridgeMessages, RefuseWhatNoBridgeSends) {
  for (const char* line : {"", "5", "{}", R"({"id": 1})", R"({"id": 1, "ok": 1})", R"({"ok": true})",
                           R"({"id": 1, "ok": false})", R"({"id": 1, "ok": false, "code": 5, "text": ""})",
                           R"({"event": 7})", R"({"id": 1, "ok": true} x)"}) {
    const auto message = decode_from_bridge(line);
    ASSERT_FALSE(message) << line;
    EXPECT_FALSE(message.error().empty());
  }
}

/// The answer to a measurement, with this in place of its spread.
std::expected<Measured, std::string> measured(const std::string& spread) {
  const auto message = decode_from_bridge(
      R"({"id": 1, "ok": true, "x": 1, "y": 2, "z": 3, "averaged_ms": 2000, "age_ms": 0, "temperature_c": 20,)"
      R"("pressure_mbar": 1000, "humidity_percent": 50)" +
      spread + "}");
  return answer_of<DoMeasure>(*std::get<Reply>(*message).outcome);
}

TEST(BridgeMessages, TellTheSpreadOfAPointEitherWay) {
  const auto by_std = measured(R"(, "std_mm": {"x": 0.01, "y": 0.02, "z": 0.03})");
  ASSERT_TRUE(by_std) << by_std.error();
  EXPECT_EQ(by_std->deviations_mm(), Eigen::Vector3d(0.01, 0.02, 0.03));
  const auto by_covariance = measured(R"(, "covariance_mm2": [0.0001, 0.0001, 0, 0.0004, 0, 0.0009])");
  ASSERT_TRUE(by_covariance) << by_covariance.error();
  EXPECT_TRUE(by_covariance->deviations_mm().isApprox(Eigen::Vector3d(0.01, 0.02, 0.03)));
}

TEST(BridgeMessages, RefuseAPointWithoutASpreadOrWithAnImpossibleOne) {
  EXPECT_FALSE(measured(""));
  EXPECT_FALSE(measured(R"(, "std_mm": {"x": -1, "y": 0, "z": 0})"));
  EXPECT_FALSE(measured(R"(, "std_mm": {"x": 1, "y": 1, "z": 1}, "covariance_mm2": [1, 0, 0, 1, 0, 1])"));
  EXPECT_FALSE(measured(R"(, "covariance_mm2": [1, 0, 0, 1, 0])"));
  EXPECT_FALSE(measured(R"(, "covariance_mm2": [-1, 0, 0, 1, 0, 1])"));
  EXPECT_FALSE(measured(R"(, "covariance_mm2": [1, 2, 0, 1, 0, 1])")) << "correlated by more than one";
  EXPECT_FALSE(measured(R"(, "covariance_mm2": [1, 0.9, -0.9, 1, 0.9, 1])")) << "not positive";
}

TEST(BridgeMessages, SayHowA6DTargetIsTurned) {
  const std::string spread = R"(, "std_mm": {"x": 0.01, "y": 0.02, "z": 0.03})";
  // Half a turn about z, and a quarter of one about the new x.
  const auto turned =
      measured(spread + R"(, "orientation": {"w": 0, "x": 0, "y": 0.70711, "z": 0.70711, "std_deg": 0.01})");
  ASSERT_TRUE(turned) << turned.error();
  ASSERT_TRUE(turned->orientation);
  EXPECT_DOUBLE_EQ(turned->orientation->std_deg, 0.01);
  Eigen::Matrix3d R_WT;
  R_WT << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  EXPECT_TRUE(turned->orientation->rotation().isApprox(R_WT, 1e-12));
  EXPECT_FALSE(measured(spread)->orientation);
  const std::string half = R"(, "orientation": {"w": 0.5, "x": 0, "y": 0, "z": 0, "std_deg": 0.01})";
  EXPECT_THAT(measured(spread + half).error(), HasSubstr("the length of w, x, y, z is 0.5"));
  EXPECT_FALSE(measured(spread + R"(, "orientation": {"w": 1, "x": 0, "y": 0, "z": 0})"));
  EXPECT_FALSE(measured(spread + R"(, "orientation": {"w": 1, "x": 0, "y": 0, "z": 0, "std_deg": -1})"));
}

TEST(BridgeMessages, TakeACodeAndAnEventOfANewerBridgeForWhatIsKnown) {
  const auto refused = decode_from_bridge(R"({"id": 1, "ok": false, "code": "on-fire", "text": "oh"})");
  ASSERT_TRUE(refused);
  const Refusal& refusal = std::get<Reply>(*refused).outcome.error();
  EXPECT_THAT(names_of(kErrorCodes), testing::Not(testing::Contains(refusal.code)));
  EXPECT_EQ(refusal.meaning(), ErrorCode::Failed);
  const auto event = decode_from_bridge(R"({"event": "on-fire", "heat": 3})");
  ASSERT_TRUE(event);
  EXPECT_FALSE(std::get<Event>(*event).kind());
}

}  // namespace
}  // namespace truepose::bridge
