#include "daemon/campaign/store_journal.hpp"

#include <gmock/gmock.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <filesystem>

#include "config/model_file.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "tests/daemon/example_cell.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
using testing::HasSubstr;

StoredPoint example_point(int pose) {
  StoredPoint point;
  point.pose = pose;
  point.q_target = point.q_commanded = point.q_actual = JointVector::Constant(6, 0.1);
  point.smr = "1";
  point.p_WS_mm = Eigen::Vector3d(1, 2, 3);
  return point;
}

std::shared_ptr<CampaignResult> example_result(bool improves) {
  auto result = std::make_shared<CampaignResult>();
  result->identities = {{"#KR210R2700_2", "S1", "KSS"}, {"AT901", "T1", "1"}};
  auto& found = result->as<CalibrationResult>();
  found.calibration.cell = {test::kr210_with_errors(), {}, {{"1", {1, 2, 3}}}};
  found.calibration.coarse = {test::kr210(), {}, {{"1", {1, 2, 3}}}};
  found.calibration.validate.emplace();
  found.calibration.validate->before.mean = 3;
  found.calibration.validate->geometric.mean = 0.04;
  found.remeasured.emplace();
  found.remeasured->mean = 0.05;
  if (!improves)
    found.verdict.findings = {finding(FindingKind::NoBetter, "it is no better than the nominal arm")};
  return result;
}

struct StoreJournalTest : testing::Test {
  StoreJournal journal(bool activate = true) {
    config::CellConfig config;
    config.robot.model = test::kr210();
    return {{.campaign_id = "c1", .model_id = "m1", .config = config, .activate = activate},
            *store,
            thread,
            [this] { return wall; },
            clock};
  }
  template <typename T>
  T finish(asio::awaitable<T> work) {
    asio::io_context io;
    std::optional<T> result;
    asio::co_spawn(io, std::move(work), [&](std::exception_ptr failed, T value) {
      EXPECT_FALSE(failed);
      result.emplace(std::move(value));
    });
    io.run();
    return *std::move(result);
  }

  TempFolder folder;
  StoreResult<Store> store = Store::open(folder.path() / "cell.sqlite");
  Worker thread;
  std::chrono::system_clock::time_point wall;
  drivers::VirtualClock clock;
};

TEST_F(StoreJournalTest, KeepsACampaignWithItsPointsSkippedPosesDocumentAndActiveModel) {
  ASSERT_TRUE(store) << store.error().detail;
  StoreJournal kept = journal();
  ASSERT_TRUE(finish(kept.begin(0)));
  ASSERT_TRUE(finish(kept.know({{"#KR210R2700_2", "S1", "KSS"}, {"AT901", "T1", "1"}})));
  ASSERT_TRUE(finish(kept.add_point(example_point(0))));
  ASSERT_TRUE(finish(kept.add_skipped({1, 3, "no reflector found"})));
  const auto ended = finish(kept.end(example_result(true), std::nullopt));
  ASSERT_TRUE(ended) << ended.error().detail;
  EXPECT_TRUE(kept.activated());

  const auto campaign = store->campaign("c1");
  ASSERT_TRUE(campaign && *campaign);
  EXPECT_EQ((*campaign)->state, "done");
  EXPECT_EQ((*campaign)->model_id, "m1");
  EXPECT_THAT((*campaign)->document, HasSubstr("\"remeasured\":{\"mean\":0.05"));
  EXPECT_EQ(store->points("c1")->front().time, "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(store->skipped("c1")->front().reason, "no reflector found");
  const auto active = store->active_model();
  ASSERT_TRUE(active && *active);
  EXPECT_EQ((*active)->id, "m1");
  const config::ModelFile model = config::parse_model((*active)->yaml, "model");
  EXPECT_EQ(model.serial, "S1");
  EXPECT_EQ(model.cell.robot.joints[2].beta_rad, test::kr210_with_errors().joints[2].beta_rad);
}

TEST_F(StoreJournalTest, TellsWhenPointsWereMeasuredByAClockThatNobodySets) {
  ASSERT_TRUE(store) << store.error().detail;
  wall += std::chrono::hours{100};
  StoreJournal kept = journal();
  ASSERT_TRUE(finish(kept.begin(2)));
  const auto first = finish(kept.add_point(example_point(1)));
  ASSERT_TRUE(first) << first.error().detail;
  wall -= std::chrono::hours{1};
  clock.pass_to(clock.now() + std::chrono::seconds{20});
  const auto second = finish(kept.add_point(example_point(2)));
  ASSERT_TRUE(second) << second.error().detail;
  EXPECT_THAT(first->time, HasSubstr("T04:00:00"));
  EXPECT_THAT(second->time, HasSubstr("T04:00:20"));
}

TEST(PointClock, TellsNoPointOfAResumedCampaignBeforeTheOnesOfBefore) {
  drivers::VirtualClock steady;
  const std::chrono::system_clock::time_point wall = std::chrono::sys_days{std::chrono::year{2026} / 11 / 26};
  PointClock set_back([&] { return wall; }, steady, "2026-11-26T00:30:00Z");
  EXPECT_EQ(set_back.now(), wall + std::chrono::minutes{30});
  steady.pass_to(steady.now() + std::chrono::seconds{20});
  EXPECT_EQ(set_back.now(), wall + std::chrono::minutes{30} + std::chrono::seconds{20});
  PointClock a_day_later([&] { return wall + std::chrono::days{1}; }, steady, "2026-11-26T00:30:00Z");
  EXPECT_EQ(a_day_later.now(), wall + std::chrono::days{1});
}

TEST_F(StoreJournalTest, KeepsButDoesNotActivateAModelThatIsNoBetterThanTheNominalArm) {
  StoreJournal kept = journal();
  ASSERT_TRUE(finish(kept.begin(0)));
  ASSERT_TRUE(finish(kept.end(example_result(false), std::nullopt)));
  EXPECT_FALSE(kept.activated());
  EXPECT_FALSE(*store->active_model());
  EXPECT_EQ(store->models()->size(), 1U);
  EXPECT_THAT(store->campaign("c1").value()->reason, HasSubstr("no better than the nominal arm"));
}

TEST_F(StoreJournalTest, KeepsButDoesNotActivateAModelThatItsDataContradictAndSaysWhy) {
  StoreJournal kept = journal();
  ASSERT_TRUE(finish(kept.begin(0)));
  const auto result = example_result(true);
  result->as<CalibrationResult>().verdict.findings = {
      finding(FindingKind::ReferenceMoved, "the reference pose did not stay where it was"),
      finding(FindingKind::NestsMoved, "the tracker moved"),
      finding(FindingKind::UnknownElsewhere, "measure more poses")};
  ASSERT_TRUE(finish(kept.end(result, std::nullopt)));
  EXPECT_FALSE(kept.activated());
  EXPECT_FALSE(*store->active_model());
  const auto campaign = store->campaign("c1").value().value();
  EXPECT_EQ(campaign.state, "done");
  EXPECT_EQ(campaign.model_id, "m1");
  EXPECT_EQ(campaign.reason, kept.record().reason);
  EXPECT_EQ(campaign.reason,
            "the model was not activated: the reference pose did not stay where it was; the tracker moved; "
            "look into "
            "that and identify again, or activate it by hand");
  const auto verdict = config::parse_model(store->model("m1").value()->yaml, "model").verdict;
  ASSERT_TRUE(verdict) << "whoever exports the model is to know";
  EXPECT_EQ(verdict->color(), VerdictColor::Red);
  EXPECT_EQ(verdict->findings.front().sentence, "the reference pose did not stay where it was");
}

TEST_F(StoreJournalTest, DoesNotActivateWhereThatIsNotWanted) {
  StoreJournal kept = journal(false);
  ASSERT_TRUE(finish(kept.begin(0)));
  ASSERT_TRUE(finish(kept.end(example_result(true), std::nullopt)));
  EXPECT_FALSE(*store->active_model());
}

TEST_F(StoreJournalTest, RecordsWhyACampaignFailedOrWasAborted) {
  StoreJournal kept = journal();
  ASSERT_TRUE(finish(kept.begin(0)));
  ASSERT_TRUE(finish(kept.end(nullptr, CampaignError{CampaignFault::Aborted, "asked for by an operator"})));
  EXPECT_EQ((*store->campaign("c1"))->state, "aborted");
  EXPECT_EQ((*store->campaign("c1"))->reason, "asked for by an operator");
  EXPECT_TRUE(store->models()->empty());
}

}  // namespace
}  // namespace truepose::daemon
