// Tools that campaigns measure, and that are taken into use.
#include "daemon/cell/tool_service.hpp"

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value_to.hpp>

#include "config/frame_file.hpp"
#include "config/number_text.hpp"
#include "config/sealed_text.hpp"
#include "proto/control/schema.hpp"
#include "proto/text/digest.hpp"
#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::Each;
using testing::ElementsAreArray;
using testing::HasSubstr;
using testing::ResultOf;
using testing::SizeIs;

struct ToolServiceTest : CellTest {
  ToolServiceTest() { load(); }
  /// Runs a campaign that measures a tool. @return its id
  std::string measure(json::object params = {}) {
    params["kind"] = "tool";
    params["number"] = 3;
    play([&]() -> Wait {
      mock.put_reflector(kTcp_mm);
      const Answer started = co_await ask("campaign.start", params);
      EXPECT_TRUE(started) << started.error().message;
      co_await campaign_ended();
    });
    return store->last_campaign().value()->id;
  }
  /// What the arm is led to for this tool.
  json::value compensated() {
    return call("targets.compensate",
                {{"poses", json::array(1, json::array{1500, 0, 1200, 0, 90, 0})}, {"tool", 3}})
        .value();
  }

  std::string document_of_tool() const {
    return sqlite_rows(file, "SELECT document FROM campaign WHERE kind='tool'").at(0).at(0);
  }
  /// Puts another document in the place of the tool's; its hash stays.
  void put_document(const std::string& text) const {
    std::string quoted;
    for (const char c : text) quoted += c == '\'' ? "''" : std::string(1, c);
    execute("UPDATE campaign SET document='" + quoted + "' WHERE kind='tool'");
  }
  /// The same with new hashes of the whole: a forged record.
  void change_tool(const std::string& from, const std::string& to) const {
    json::value document = json::parse(document_of_tool());
    std::string yaml{document.at("yaml").as_string()};
    const std::size_t at = yaml.find(from);
    ASSERT_NE(at, std::string::npos) << yaml;
    yaml.replace(at, from.size(), to);
    document.as_object()["yaml"] = config::sealed(yaml.substr(0, yaml.rfind("sha256: ")));
    const std::string text = json::serialize(document);
    put_document(text);
    execute("UPDATE campaign SET document_sha256='" + text::sha256_hex(text) + "' WHERE kind='tool'");
  }

  const Eigen::Vector3d kTcp_mm{-40, 110, 230};
};

TEST_F(ToolServiceTest, ACampaignMeasuresAToolByTheActiveModel) {
  measure();
  const json::value found = *call("campaign.get");
  EXPECT_EQ(found.at_pointer("/campaign/kind"), "tool");
  EXPECT_THAT(event_data(control::Topic::Campaign),
              Each(ResultOf([](const auto& it) { return it.at("kind"); }, "tool")));
  EXPECT_EQ(found.at_pointer("/campaign/state"), "done");
  EXPECT_EQ(found.at("points_total"), 10);
  EXPECT_EQ(found.at_pointer("/frame/number"), 3);
  EXPECT_NEAR(found.at_pointer("/frame/frame/x").to_number<double>(), kTcp_mm.x(), 1);
  EXPECT_NEAR(found.at_pointer("/frame/frame/z").to_number<double>(), kTcp_mm.z(), 1);
  EXPECT_THAT(std::string{found.at_pointer("/frame/krl").as_string()}, HasSubstr("TOOL_DATA[3]={X "));
  EXPECT_EQ(call("campaign.get", {{"points_limit", 20}})->at_pointer("/points/0/purpose"), "frame");
  EXPECT_THAT(call("campaign.export")->at("data").as_string().c_str(),
              HasSubstr("point,q1,q2,q3,q4,q5,q6,x,y,z\norigin,"));
}

TEST_F(ToolServiceTest, AToolIsUsedOnceSomebodyTakesItIntoUse) {
  const std::string id = measure();
  EXPECT_THAT(call("tool.list")->at("tools").as_array(), SizeIs(0)) << "never by itself";
  EXPECT_THAT(refused("targets.compensate", {{"poses", {{1500, 0, 1200, 0, 90, 0}}}, {"tool", 3}}),
              HasSubstr("no tool of this number"));
  const json::value used = *call("tool.activate", {{"id", id}});
  EXPECT_EQ(used.at("number"), 3);
  EXPECT_EQ(used.at("campaign_id").as_string(), id);
  const json::value with = compensated();
  EXPECT_EQ(call("tool.list")->at_pointer("/tools/0"), used);

  ASSERT_TRUE(finish(cell.load_tools())) << "as a daemon does that starts";
  EXPECT_EQ(compensated(), with);

  EXPECT_EQ(call("tool.deactivate", {{"number", 3}})->at("deactivated").as_string(), id);
  EXPECT_THAT(refused("tool.deactivate", {{"number", 3}}), HasSubstr("no tool of this number"));
  EXPECT_THAT(call("tool.list")->at("tools").as_array(), SizeIs(0));
}

TEST_F(ToolServiceTest, TheToolInForceIsTheOneThatWasTakenIntoUse) {
  const std::string id = measure();
  play([&]() -> Wait {
    mock.use_tool(3);
    co_await pass(5s);
    auto now = co_await ask("stream.status");
    EXPECT_FALSE(now->at_pointer("/tool/measured").as_bool());
    json::object params;
    params["id"] = id;
    const Answer used = co_await ask("tool.activate", params);
    EXPECT_TRUE(used) << used.error().message;
    now = co_await ask("stream.status");
    EXPECT_TRUE(now->at_pointer("/tool/measured").as_bool());
  });
}

TEST_F(ToolServiceTest, NothingIsCorrectedWhileAToolInUseIsOfAnotherArm) {
  ASSERT_TRUE(call("tool.activate", {{"id", measure()}}));
  change_tool("serial: \"MOCK-0001", "serial: \"MOCK-0002");
  execute("UPDATE campaign SET robot_serial='MOCK-0002' WHERE kind='tool'");
  ASSERT_TRUE(finish(cell.load_tools())) << "as a daemon does that starts";
  const std::string other = "tool 3 belongs to arm MOCK-0002, not to MOCK-0001";
  for (const char* method : {"stream.start", "stream.arm"})
    EXPECT_EQ(refused(method), other + "; allowed: tool.activate, tool.deactivate");
  EXPECT_THAT(refused("campaign.start",
                      {{"kind", "base"}, {"number", 5}, {"touch", 3}, {"points", {"origin", "x", "xy"}}}),
              HasSubstr(other));
  ASSERT_TRUE(call("tool.deactivate", {{"number", 3}}));
  EXPECT_TRUE(call("stream.arm"));
}

TEST_F(ToolServiceTest, AToolInUseOfWhichNobodyKnowsTheArmIsCorrected) {
  ASSERT_TRUE(call("tool.activate", {{"id", measure()}}));
  change_tool("serial: \"MOCK-0001\"\n", "");
  execute("UPDATE campaign SET robot_serial='' WHERE kind='tool'");
  ASSERT_TRUE(finish(cell.load_tools()));
  EXPECT_TRUE(call("stream.arm"));
}

TEST_F(ToolServiceTest, AToolInUseWhoseRecordWasChangedIsRefusedAndNothingIsCorrected) {
  const std::string id = measure();
  ASSERT_TRUE(call("tool.activate", {{"id", id}}));
  const std::string document = document_of_tool();
  const std::string why = "tool 3 of campaign " + id + " is refused: ";
  int changed = 0;
  for (std::size_t i = 0; i < document.size(); ++i) {
    if (!std::isdigit(static_cast<unsigned char>(document[i]))) continue;
    std::string other = document;
    other[i] = other[i] == '9' ? '0' : static_cast<char>(other[i] + 1);
    put_document(other);
    ASSERT_TRUE(finish(cell.load_tools()));
    ASSERT_THAT(refused("stream.start"), HasSubstr(why + "its document is not the one that was stored"))
        << "byte " << i;
    ++changed;
  }
  EXPECT_GT(changed, 500);
  EXPECT_THAT(refused("stream.arm"), HasSubstr("allowed: tool.activate, tool.deactivate"));
  EXPECT_THAT(refused("targets.compensate", {{"poses", {{1500, 0, 1200, 0, 90, 0}}}, {"tool", 3}}),
              HasSubstr(why));
  EXPECT_THAT(refused("tool.activate", {{"id", id}}), HasSubstr("is not the one that was stored"));
  const json::value listed = call("tool.list")->at_pointer("/tools/0");
  EXPECT_TRUE(listed.at("krl").is_null()) << "the operator must not type it in";
  EXPECT_THAT(std::string{listed.at("refused").as_string()}, HasSubstr(why));
  put_document(document);
  ASSERT_TRUE(finish(cell.load_tools()));
  EXPECT_TRUE(call("stream.arm"));
}

TEST_F(ToolServiceTest, AToolInUseIsRefusedWhereItsCampaignIsNotTheOneThatMeasuredIt) {
  ASSERT_TRUE(call("tool.activate", {{"id", measure()}}));
  const auto refused_after = [this](const std::string& change, const std::string& back) {
    execute(change);
    EXPECT_TRUE(finish(cell.load_tools()));
    const std::string why = refused("stream.arm");
    execute(back);
    return why;
  };
  EXPECT_THAT(refused_after("UPDATE campaign SET state='aborted' WHERE kind='tool'",
                            "UPDATE campaign SET state='done' WHERE kind='tool'"),
              HasSubstr("measured no tool, or is not done"));
  EXPECT_THAT(refused_after("UPDATE campaign SET robot_serial='MOCK-0002' WHERE kind='tool'",
                            "UPDATE campaign SET robot_serial='MOCK-0001' WHERE kind='tool'"),
              HasSubstr("its tool is of arm 'MOCK-0001', its campaign of arm 'MOCK-0002'"));
  EXPECT_THAT(refused_after("UPDATE tool SET number=4", "UPDATE tool SET number=3"),
              HasSubstr("its campaign measured tool 3"));
  EXPECT_THAT(refused_after("UPDATE tool SET campaign_id='c1'",
                            "UPDATE tool SET campaign_id=(SELECT id FROM campaign WHERE kind='tool')"),
              HasSubstr("measured no tool, or is not done"));
}

TEST_F(ToolServiceTest, AForgedFrameThatItsReadingsDoNotGiveIsNotCorrected) {
  ASSERT_TRUE(call("tool.activate", {{"id", measure()}}));
  const Eigen::Isometry3d X =
      config::parse_tool(std::string{json::parse(document_of_tool()).at("yaml").as_string()}, "tool",
                         config.robot.model)
          .X_controller;
  change_tool("frame: {x: " + config::format_number(X.translation().x()), "frame: {x: 62");
  ASSERT_TRUE(finish(cell.load_tools()));
  EXPECT_THAT(refused("targets.compensate", {{"poses", {{1500, 0, 1200, 0, 90, 0}}}, {"tool", 3}}),
              HasSubstr("is refused"));
}

TEST_F(ToolServiceTest, RefusesWhatMeasuredNoTool) {
  EXPECT_THAT(refused("tool.activate", {{"id", "c1"}}), HasSubstr("measured no tool"));
  EXPECT_EQ(refused("tool.activate", {{"id", "none"}}), "no such campaign");
  EXPECT_THAT(refused("campaign.start", {{"kind", "tool"}}), HasSubstr("params.number"));
  EXPECT_THAT(refused("campaign.start", {{"kind", "tool"}, {"number", 3}, {"points", {"origin", "x"}}}),
              HasSubstr("the points say no frame"));
  EXPECT_THAT(refused("campaign.start", {{"kind", "tool"}, {"number", 3}, {"at", {{1, 2, 3}, {4, 5, 6}}}}),
              HasSubstr("a row for each of the points"));
  ASSERT_TRUE(call("model.deactivate"));
  EXPECT_THAT(refused("campaign.start", {{"kind", "tool"}, {"number", 3}}),
              AllOf(HasSubstr("no model is active"), HasSubstr("model.activate")));
}

/// The kinds of campaigns that a record of the control port may name.
std::vector<std::string> kinds_in_schema(const std::string& record) {
  const json::value schema = json::parse(std::string{control::openrpc_text()});
  return json::value_to<std::vector<std::string>>(
      schema.at_pointer("/components/schemas/" + record + "/properties/kind/enum"));
}

TEST_F(ToolServiceTest, TheSchemaNamesEveryKindOfCampaign) {
  EXPECT_THAT(kinds_in_schema("CampaignProgress"), ElementsAreArray(kCampaignKinds));
  EXPECT_THAT(kinds_in_schema("CampaignSummary"), ElementsAreArray(kCampaignKinds));
}

TEST_F(ToolServiceTest, AToolWhoseReadingsContradictEachOtherCannotBeUsed) {
  play([&]() -> Wait {
    mock.put_reflector(kTcp_mm);
    json::object params;
    params["kind"] = "tool";
    params["number"] = 3;
    co_await ask("campaign.start", params);
    while (event_data(control::Topic::Measurement).size() < 5) co_await pass(1s);
    mock.put_reflector(kTcp_mm + Eigen::Vector3d(15, 0, 0));
    while (event_data(control::Topic::Measurement).size() < 6) co_await pass(1s);
    mock.put_reflector(kTcp_mm);
    co_await campaign_ended();
  });
  const json::value found = *call("campaign.get");
  EXPECT_EQ(found.at_pointer("/frame/outliers").as_array().size(), 1U) << found.at("frame");
  EXPECT_FALSE(found.at("frame").as_object().contains("yaml"));
  EXPECT_THAT(refused("tool.activate", {{"id", found.at_pointer("/campaign/id")}}),
              HasSubstr("more than five standard deviations"));
}

TEST_F(ToolServiceTest, AToolWhoseReadingsShowThatTheTrackerMovedCannotBeUsed) {
  mock.put_reflector(kTcp_mm);
  mock.bump_tracker({4, 3, 0});  // the model is a millimetre off
  play([&]() -> Wait {
    json::object params;
    params["kind"] = "tool";
    params["number"] = 3;
    co_await ask("campaign.start", params);
    co_await campaign_ended();
  });
  const json::value found = *call("campaign.get");
  EXPECT_EQ(found.at_pointer("/frame/base_shift/significant"), true) << found.at("frame");
  EXPECT_FALSE(found.at("frame").as_object().contains("yaml"));
  EXPECT_THAT(json::serialize(found.at_pointer("/frame/notes")), HasSubstr("times as far as their noise"));
  EXPECT_THAT(std::string{found.at_pointer("/campaign/reason").as_string()},
              HasSubstr("the frame cannot be used: the robot's base or the tracker stands "));
  EXPECT_THAT(refused("tool.activate", {{"id", found.at_pointer("/campaign/id")}}),
              HasSubstr("from where the model has it"));
}

}  // namespace
}  // namespace truepose::daemon
