// Stores on disks that are full, fail, or lose their power at any moment.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <optional>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/store/campaign_plan.hpp"
#include "daemon/store/store.hpp"
#include "tests/daemon/failing_disk.hpp"
#include "tests/temp_folder.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

using test::FailingDisk;
using testing::HasSubstr;

CampaignRecord campaign(const std::string& id) {
  CampaignRecord record;
  record.id = id;
  record.started = "2026-08-17T10:00:00Z";
  record.state = "running";
  return record;
}

ModelRecord model(const std::string& id) {
  ModelRecord record;
  record.id = id;
  record.created = "2026-08-17T11:00:00Z";
  record.yaml = "name: " + id + "\n" + std::string(3000, '#');
  return record;
}

StoredPoint point(int pose) {
  StoredPoint point;
  point.pose = pose;
  point.q_target = point.q_commanded = point.q_actual = JointVector::Constant(6, 1.0 / pose);
  point.smr = "1";
  point.p_WS_mm = Eigen::Vector3d(1.0 * pose, 2, 3);
  return point;
}

EventBatch batch(std::uint64_t first, std::uint64_t last) {
  EventBatch events{.events = {}, .gaps = {}, .through = last};
  for (std::uint64_t seq = first; seq <= last; ++seq)
    events.events.push_back({seq, "2026-08-17T10:00:00Z", control::Topic::Fault, R"({"text":"x"})"});
  return events;
}

const std::set<control::Topic> kFaults{control::Topic::Fault};

/// What a store has, as far as the operations below change it.
struct Content {
  std::vector<std::string> campaigns;  ///< id, state and model of each
  std::vector<int> poses, skipped;
  std::vector<std::string> models;
  std::string active, armed;
  std::vector<std::uint64_t> events;
  std::size_t planned = 0, resumptions = 0;  ///< of c3
  bool operator==(const Content&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Content& content) {
  for (const auto& campaign : content.campaigns) out << campaign << "; ";
  out << content.poses.size() << " points, " << content.models.size() << " models, active " << content.active
      << ", armed " << content.armed << ", " << content.events.size() << " events, " << content.planned
      << " planned poses, " << content.resumptions << " resumptions";
  return out;
}

Content content_of(Store& store) {
  Content content;
  const std::vector<CampaignRecord> campaigns = store.campaigns().value();
  const std::vector<StoredPoint> points = store.points("c1").value();
  const std::vector<ModelRecord> models = store.models().value();
  const EventPage page = store.events(kFaults, 1, 1'000'000).value();
  for (const CampaignRecord& record : campaigns)
    content.campaigns.push_back(record.id + " " + record.state + " " + record.model_id + " " +
                                record.points_of);
  for (const StoredPoint& each : points) content.poses.push_back(each.pose);
  const std::vector<SkippedPose> skipped = store.skipped("c1").value();
  for (const SkippedPose& each : skipped) content.skipped.push_back(each.pose);
  for (const ModelRecord& record : models) content.models.push_back(record.id);
  if (const auto active = store.active_model().value()) content.active = active->id;
  if (const auto plan = store.plans().plan("c3").value()) content.planned = plan->poses.size();
  content.resumptions = store.plans().resumptions("c3").value().size();
  content.armed = store.armed_since().value();
  for (const KeptEvent& event : page.events) content.events.push_back(event.seq);
  return content;
}

struct Operation {
  const char* name;
  std::function<StoreResult<void>(Store&)> run;
  bool of_campaign = false;  ///< while it runs
};

/// Every operation that writes, in an order in which each makes sense.
std::vector<Operation> operations() {
  CampaignRecord ended = campaign("c1");
  ended.state = "done";
  ended.model_id = "m1";
  ended.document = "{}";
  ModelRecord made = model("m1");
  made.active = true;
  CampaignRecord again = campaign("c2");
  again.points_of = "c1";
  again.validate = {1};
  const auto done = [](auto result) -> StoreResult<void> {
    if (!result) return std::unexpected(result.error());
    return {};
  };
  return {
      {"begin_events", [=](Store& s) { return done(s.begin_events(1000)); }},
      {"begin_campaign", [](Store& s) { return s.begin_campaign(campaign("c1")); }},
      {"add_point", [](Store& s) { return s.add_point("c1", point(1)); }, true},
      {"another point", [](Store& s) { return s.add_point("c1", point(2)); }, true},
      {"add_skipped",
       [](Store& s) {
         return s.add_skipped("c1", {3, 2, "no beam"});
       },
       true},
      {"keep_events", [](Store& s) { return s.keep_events(batch(1, 300)); }},
      {"end_campaign", [=](Store& s) { return s.end_campaign(ended, made); }, true},
      {"begin_campaign with its order", [=](Store& s) { return s.begin_campaign(campaign("c3"), "{}", 7); }},
      {"add_planned",
       [](Store& s) {
         const JointVector q = point(1).q_target;
         const std::array planned{PlannedPose{.pose = 1, .q_target = q, .q_commanded = q}};
         return s.plans().add_planned("c3", planned, 8);
       },
       true},
      {"identification", [=](Store& s) { return s.begin_campaign(again); }},
      {"interrupt_running",
       [=](Store& s) { return done(s.plans().interrupt_running("2026-08-17T12:00:00Z")); }},
      {"resume", [](Store& s) { return s.plans().resume("c3"); }},
      {"add_resumption", [](Store& s) { return s.plans().add_resumption("c3", {}); }, true},
      {"add_model", [](Store& s) { return s.add_model(model("m2")); }},
      {"activate_model", [](Store& s) { return s.activate_model("m2"); }},
      {"keep_armed", [](Store& s) { return s.keep_armed("2026-08-17T12:00:00Z"); }},
      {"reserve", [=](Store& s) { return done(s.reserve_event_numbers(10)); }},
      {"prune_events", [=](Store& s) { return done(s.prune_events("2026-08-17T10:00:01Z")); }},
      {"end_events", [](Store& s) { return s.end_events(batch(301, 310)); }},
  };
}

class StoreFaults : public testing::Test {
 protected:
  Store open() {
    StoreResult<Store> store = Store::open(folder_.path() / "cell.db");
    if (!store) throw std::runtime_error(store.error().detail);
    return std::move(*store);
  }

  TempFolder folder_;
};

// A disk that is full at any one write: the operation fails with what to do, changes nothing, and does its
// work once there is room.
TEST_F(StoreFaults, ADiskThatIsFullAtAnyWriteLosesNothingAndIsGoneOnWith) {
  int faults = 0;
  for (int at = 0, failed = 1; failed > 0; ++at) {
    failed = 0;
    FailingDisk disk;
    Store store = open();
    for (const Operation& operation : operations()) {
      SCOPED_TRACE(testing::Message() << operation.name << ", full at its write " << at + 1);
      const Content before = content_of(store);
      disk.fail_after(at, FailingDisk::Fault::Full);
      const StoreResult<void> result = operation.run(store);
      disk.repair();
      if (result) continue;
      ++failed;
      EXPECT_TRUE(result.error().may_pass) << result.error().detail;
      EXPECT_THAT(result.error().detail, HasSubstr("make room on the disk"));
      EXPECT_EQ(content_of(store), before);
      const StoreResult<void> again = operation.run(store);
      ASSERT_TRUE(again) << again.error().detail;
    }
    faults += failed;
    const Content at_the_end = content_of(store);
    store = open();
    EXPECT_EQ(content_of(store), at_the_end);
  }
  EXPECT_GT(faults, 40);
}

// A disk that fails at any one change and works again: nothing more is taken until somebody has it tried
// again.
TEST_F(StoreFaults, ADiskThatFailsAtAnyChangeIsWrittenToAgainOnlyOnceItWasTried) {
  int faults = 0;
  for (int at = 0, failed = 1; failed > 0; ++at) {
    failed = 0;
    FailingDisk disk;
    Store store = open();
    for (const Operation& operation : operations()) {
      SCOPED_TRACE(testing::Message() << operation.name << ", broken at its change " << at + 1);
      const Content before = content_of(store);
      disk.fail_after(at, FailingDisk::Fault::Broken, 1);
      const StoreResult<void> result = operation.run(store);
      disk.repair();
      if (result) continue;
      ++failed;
      EXPECT_THAT(operation.run(store).error().detail, HasSubstr("check the disk"));
      const auto tried = store.try_again();
      ASSERT_TRUE(tried) << tried.error().detail;
      // The commit may or may not be on the disk when its sync failed. A campaign repeats the write, and the
      // store keeps it once.
      const Content tried_once = content_of(store);
      if (tried_once != before && !operation.of_campaign) continue;
      const StoreResult<void> again = operation.run(store);
      ASSERT_TRUE(again) << again.error().detail;
      if (tried_once != before) {
        EXPECT_EQ(content_of(store), tried_once);
      }
    }
    faults += failed;
    const Content at_the_end = content_of(store);
    store = open();
    EXPECT_EQ(content_of(store), at_the_end);
  }
  EXPECT_GT(faults, 40);
}

TEST_F(StoreFaults, AFullDiskIsReportedWhenItIsTriedAgain) {
  FailingDisk disk;
  Store store = open();
  ASSERT_TRUE(store.begin_campaign(campaign("c1")));
  disk.fail_after(0, FailingDisk::Fault::Full);
  EXPECT_FALSE(store.add_point("c1", point(1)));
  const auto tried = store.try_again();
  ASSERT_FALSE(tried);
  EXPECT_TRUE(tried.error().may_pass);
  disk.repair();
  EXPECT_TRUE(store.try_again());
  EXPECT_TRUE(store.add_point("c1", point(1)));
}

TEST_F(StoreFaults, TheStartOnADiskThatIsFullAtAnyWriteIsTriedAgain) {
  for (int at = 0;; ++at) {
    FailingDisk disk;
    disk.fail_after(at, FailingDisk::Fault::Full);
    const auto store = Store::open(folder_.path() / "cell.db");
    if (store) break;
    EXPECT_TRUE(store.error().may_pass) << store.error().detail;
    disk.repair();
    const auto again = Store::open(folder_.path() / "cell.db");
    EXPECT_TRUE(again) << again.error().detail;
  }
}

/// What was acknowledged, and what must be there after a power cut.
struct Witness {
  int points = 0;
  std::uint64_t kept_events = 0;
  std::string active;
  std::optional<std::string> active_asked;  ///< the power went before it was acknowledged
};

void work_until_dark(FailingDisk& disk, Store& store, std::mt19937_64& random, Witness& seen, int life) {
  const int until = static_cast<int>(random() % 60);
  disk.fail_after(until, FailingDisk::Fault::Broken);
  for (;;) {
    StoreResult<void> result;
    switch (random() % 4) {
      case 0: {
        const std::string id = "m" + std::to_string(life) + "-" + std::to_string(random());
        result = store.add_model(model(id));
        if (!result) break;
        seen.active_asked = id;
        result = store.activate_model(id);
        if (result) seen.active = id;
        if (result) seen.active_asked.reset();
        break;
      }
      case 1:
        result = store.keep_events(batch(seen.kept_events + 1, seen.kept_events + 10));
        if (result) seen.kept_events += 10;
        break;
      default:
        result = store.add_point("c1", point(seen.points + 1));
        if (result) ++seen.points;
    }
    if (!result) return;
  }
}

void expect_all(Store& store, Witness& seen) {
  const auto points = store.points("c1");
  ASSERT_TRUE(points) << points.error().detail;
  ASSERT_GE(static_cast<int>(points->size()), seen.points);
  ASSERT_LE(static_cast<int>(points->size()), seen.points + 1);
  for (std::size_t i = 0; i < points->size(); ++i) {
    EXPECT_EQ((*points)[i].pose, static_cast<int>(i) + 1);
    EXPECT_EQ((*points)[i].q_actual, point(static_cast<int>(i) + 1).q_actual);
  }
  const auto events = store.events(kFaults, 1, 1'000'000);
  ASSERT_TRUE(events) << events.error().detail;
  std::uint64_t last = 0;
  for (EventPage page = *events;;) {
    for (const KeptEvent& event : page.events) EXPECT_EQ(event.seq, ++last);
    if (page.next == 1'000'000) break;
    page = store.events(kFaults, page.next, 1'000'000).value();
  }
  EXPECT_TRUE(last == seen.kept_events || last == seen.kept_events + 10) << last << ", " << seen.kept_events;
  const auto active = store.active_model().value();
  const std::string id = active ? active->id : "";
  EXPECT_TRUE(id == seen.active || id == seen.active_asked) << id;
  seen = {static_cast<int>(points->size()), last, id, {}};
}

// Disks that lose, reorder and tear what was not synced when the power went.
TEST_F(StoreFaults, EveryAcknowledgedRecordOutlivesPowerCuts) {
  constexpr std::uint64_t kFirstSeed = 20261124;
  const int all = trials(2000) / share();
  for (int trial = 0; trial < all; ++trial) {
    const std::uint64_t seed = kFirstSeed + static_cast<std::uint64_t>(trial);
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    FailingDisk disk{seed};
    std::mt19937_64 random{seed};
    Witness seen;
    {
      Store store = open();
      ASSERT_TRUE(store.begin_campaign(campaign("c1")));
      ASSERT_TRUE(store.begin_events(100'000));
    }
    for (int life = 0; life < 3; ++life) {
      {
        Store store = open();
        work_until_dark(disk, store, random, seen, life);
        disk.cut_power();
      }
      disk.repair();
      disk.restore_power();
      StoreResult<Store> store = Store::open(folder_.path() / "cell.db");
      ASSERT_TRUE(store) << store.error().detail;
      expect_all(*store, seen);
      if (HasFailure()) return;
    }
  }
}

}  // namespace
}  // namespace truepose::daemon
