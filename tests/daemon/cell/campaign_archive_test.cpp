#include "daemon/cell/campaign_archive.hpp"

#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::SizeIs;

struct CampaignArchiveTest : CellTest {};

TEST_F(CampaignArchiveTest, ListsCampaignsTheLastOneFirstAPageAtATime) {
  const json::value all = call("campaign.list").value();
  EXPECT_EQ(all.at("total"), 2);
  EXPECT_EQ(all.at_pointer("/campaigns/0/id"), "c1");
  const json::value second = call("campaign.list", {{"offset", 1}, {"limit", 5}}).value();
  EXPECT_THAT(second.at("campaigns").as_array(), SizeIs(1));
  EXPECT_EQ(second.at_pointer("/campaigns/0/id"), "c2");
}

TEST_F(CampaignArchiveTest, GivesTheLastCampaignOrTheOneThatIsNamedWithAPageOfItsPoints) {
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/id"), "c1");
  const json::value named =
      call("campaign.get", {{"id", "c2"}, {"points_offset", 20}, {"points_limit", 100}}).value();
  EXPECT_EQ(named.at_pointer("/campaign/id"), "c2");
  EXPECT_EQ(named.at("points_total"), 28);
  EXPECT_EQ(named.at("points").as_array().size(), 8U);
  EXPECT_EQ(named.at_pointer("/points/0/pose"), 21);
  EXPECT_EQ(named.at_pointer("/points/0/purpose"), "validate");
  EXPECT_EQ(refused("campaign.get", {{"id", "c3"}}), "no such campaign");
  EXPECT_THAT(refused("campaign.get", {{"points_limit", 101}}), HasSubstr("points_limit"));
}

TEST_F(CampaignArchiveTest, GivesTheCampaignThatIsUnderWayAlsoBeforeTheStoreHasIt) {
  play([this]() -> Wait {
    const Answer started = co_await ask("campaign.start");
    for (const drivers::Duration time : {100ms, 100'000ms}) {
      co_await pass(time);
      const Answer found = co_await ask("campaign.get");
      EXPECT_EQ(found->at_pointer("/campaign/id"), started->at("id"));
      EXPECT_EQ(found->at_pointer("/progress/id"), started->at("id"));
      EXPECT_EQ(found->at_pointer("/campaign/state"), "running");
    }
    co_await ask("campaign.abort");
  });
}

TEST_F(CampaignArchiveTest, ReportsTheLastCalibrationOrTheOneThatIsNamed) {
  EXPECT_EQ(call("report.get")->at("id"), "c1");
  const json::value report =
      call("report.get", {{"id", "c2"}, {"points_offset", 4}, {"points_limit", 10}}).value();
  EXPECT_EQ(report.at("points_total"), 28);
  EXPECT_EQ(report.at_pointer("/document/points").as_array().size(), 10U);
  EXPECT_EQ(report.at_pointer("/document/points/0/pose"), 5);
  EXPECT_EQ(refused("report.get", {{"id", "c3"}}), "no such campaign, or it has no report");
  execute("UPDATE campaign SET document='{' WHERE id='c2'");
  EXPECT_THAT(refused("report.get", {{"id", "c2"}}), testing::StartsWith("the stored document: "));
  execute("UPDATE campaign SET state='failed'");
  EXPECT_EQ(refused("report.get"), "no such campaign, or it has no report");
}

TEST_F(CampaignArchiveTest, SaysOfAStoreThatCannotBeReadWhatIsWrongWithIt) {
  for (const char* table : {"skipped", "point", "campaign"}) {
    execute(std::string{"DROP TABLE "} + table);
    EXPECT_THAT(refused("campaign.get"), HasSubstr("no such table"));
  }
  for (const char* method : {"campaign.list", "report.get"})
    EXPECT_THAT(refused(method), HasSubstr("no such table"));
}

}  // namespace
}  // namespace truepose::daemon
