#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "config/text_file.hpp"
#include "daemon/control/audit_files.hpp"
#include "daemon/control/audit_trail.hpp"
#include "daemon/store/backup.hpp"
#include "daemon/store/correction_mark.hpp"
#include "daemon/store/restore.hpp"
#include "daemon/store/store.hpp"
#include "tests/temp_folder.hpp"
#include "tests/trials.hpp"
#include "tests/world/pc_files.hpp"

namespace truepose::world {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

/// A PC whose power goes at any of the changes of its files.
class PcOfASeed {
 public:
  explicit PcOfASeed(std::uint64_t seed)
      : random{seed}, disk_{seed}, files_{folder_.path(), "run", seed, disk_} {}

  /// Does some work until the power goes, at one of so many changes or behind them.
  void work_until_dark(int changes, const std::function<void()>& work) {
    disk_.fail_after(static_cast<int>(random() % static_cast<std::uint64_t>(changes)),
                     test::FailingDisk::Fault::Broken);
    work();
    lose_power();
  }
  void lose_power() {
    files_.lose_power();
    disk_.repair();
    disk_.restore_power();
  }

  /// Lets one to three changes of the next ones fail.
  void disturb(int changes) {
    using Fault = test::FailingDisk::Fault;
    const auto which = static_cast<int>(random() % static_cast<std::uint64_t>(changes));
    const Fault fault = random() % 2 == 0 ? Fault::Full : Fault::Broken;
    disk_.fail_after(which, fault, 1 + static_cast<int>(random() % 3));
  }

  fs::path at(const char* name) const { return folder_.path() / name; }

  std::mt19937_64 random;

 private:
  TempFolder folder_;
  test::FailingDisk disk_;
  PcFiles files_;
};

void for_many_seeds(const std::function<void(PcOfASeed& pc)>& see) {
  const int all = trials(2000) / share();
  for (int seed = 0; seed < all && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    PcOfASeed pc{static_cast<std::uint64_t>(seed)};
    see(pc);
  }
}

TEST(WhereverThePowerGoes, ATextFileIsTheOldOneOrTheNewOne) {
  for_many_seeds([](PcOfASeed& pc) {
    const fs::path file = pc.at("cell.access");
    config::write_text_file(file, "old");
    bool written = false;
    pc.work_until_dark(8, [&] {
      try {
        config::write_text_file(file, "new");
        written = true;
      } catch (const config::ConfigError&) {
      }
    });
    const std::string text = config::read_text_file(file);
    EXPECT_TRUE(text == "new" || (text == "old" && !written)) << text;
  });
}

TEST(WhereverThePowerGoes, TheMarkOfACorrectionIsThereOnceItIsKept) {
  for_many_seeds([](PcOfASeed& pc) {
    bool kept = false;
    pc.work_until_dark(3, [&] { kept = daemon::keep_corrected(pc.at("cell.sqlite")).has_value(); });
    EXPECT_TRUE(!kept || daemon::may_have_corrected(pc.at("cell.sqlite")));
  });
}

constexpr const char* kTime = "2026-11-24T12:00:00.000Z";
constexpr std::uint64_t kFull = 2000;  // bytes: some records

TEST(WhereverThePowerGoes, AnAuditTrailHasEveryRecordThatWasWritten) {
  for_many_seeds([](PcOfASeed& pc) {
    const fs::path file = daemon::audit_file_of(pc.at("cell.sqlite"));
    control::AuditHead written;
    for (int life = 0; life < 4; ++life) {
      std::vector<control::AuditHead> known;
      if (pc.random() % 2 == 0 && written.count > 0) known.push_back(written);
      pc.work_until_dark(60, [&] {
        auto trail = daemon::AuditTrail::open(file, kTime, known, kFull);
        if (!trail) return;
        EXPECT_THAT(trail->fault(), IsEmpty());
        while (trail->append({{"who", "Anna"}, {"method", "stream.arm"}})) written = trail->end();
      });
      if (written.count == 0) continue;
      const auto report = daemon::verify_audit(file, std::vector{written});
      ASSERT_TRUE(report) << report.error();
      EXPECT_THAT(report->faults, IsEmpty());
      EXPECT_GE(report->end.count, written.count);
      EXPECT_LE(report->end.count, written.count + 1);
      written = report->end;
    }
  });
}

TEST(WhereverThePowerGoes, AnAuditTrailHasEveryRecordThatADisturbedDiskTook) {
  for_many_seeds([](PcOfASeed& pc) {
    const fs::path file = daemon::audit_file_of(pc.at("cell.sqlite"));
    control::AuditHead written;
    {
      auto trail = daemon::AuditTrail::open(file, kTime, {}, kFull);
      ASSERT_TRUE(trail) << trail.error();
      pc.disturb(120);
      for (int i = 0; i < 40; ++i)
        if (trail->append({{"who", "Anna"}, {"method", "stream.arm"}})) written = trail->end();
    }
    pc.lose_power();
    const auto report = daemon::verify_audit(file, std::vector{written});
    ASSERT_TRUE(report) << report.error();
    EXPECT_THAT(report->faults, IsEmpty());
    EXPECT_GE(report->end.count, written.count);
  });
}

// ---- The store ----

void keep(daemon::Store& store, const std::string& campaign) {
  daemon::CampaignRecord record;
  record.id = campaign;
  record.started = "2026-08-17T10:00:00Z";
  record.state = "running";
  const auto kept = store.begin_campaign(record);
  EXPECT_TRUE(kept) << kept.error().detail;
}

std::set<std::string> campaigns_in(const fs::path& store) {
  std::set<std::string> ids;
  auto opened = daemon::Store::open(store);
  if (!opened) return {opened.error().detail};
  const std::vector<daemon::CampaignRecord> records = opened->campaigns().value();
  for (const daemon::CampaignRecord& record : records) ids.insert(record.id);
  return ids;
}

daemon::StoreResult<void> back_up(daemon::Store& store, const fs::path& file) {
  auto backup = store.begin_backup(file);
  if (!backup) return std::unexpected(backup.error());
  for (daemon::StoreResult<bool> all = false; !*all;) {
    all = backup->step();
    if (!all) return std::unexpected(all.error());
  }
  if (const auto finished = backup->finish(); !finished) return std::unexpected(finished.error());
  return {};
}

TEST(WhereverThePowerGoes, ABackupIsTheOldOneOrTheNewOne) {
  for_many_seeds([](PcOfASeed& pc) {
    const fs::path file = pc.at("cell.sqlite"), backup = pc.at("cell.sqlite.backup");
    bool made = false;
    {
      auto store = daemon::Store::open(file);
      ASSERT_TRUE(store) << store.error().detail;
      keep(*store, "first");
      const auto before = back_up(*store, backup);
      ASSERT_TRUE(before) << before.error().detail;
      keep(*store, "second");
    }
    pc.work_until_dark(90, [&] {
      auto store = daemon::Store::open(file);
      made = store && back_up(*store, backup);
    });
    const auto left = campaigns_in(backup);
    const std::set<std::string> before{"first"}, now{"first", "second"};
    EXPECT_TRUE(left == now || (left == before && !made)) << testing::PrintToString(left);
    EXPECT_EQ(campaigns_in(file), now);
  });
}

TEST(WhereverThePowerGoes, ARestoredStoreIsTheOldOneOrTheOneOfTheBackup) {
  for_many_seeds([](PcOfASeed& pc) {
    const fs::path file = pc.at("cell.sqlite"), backup = pc.at("cell.sqlite.backup");
    bool restored = false;
    {
      auto store = daemon::Store::open(file);
      ASSERT_TRUE(store) << store.error().detail;
      keep(*store, "first");
      ASSERT_TRUE(back_up(*store, backup));
      keep(*store, "second");
    }
    pc.work_until_dark(
        150, [&] { restored = daemon::restore_store(backup, file, "20261124T235959Z").has_value(); });
    const auto left = campaigns_in(file);
    const std::set<std::string> old{"first", "second"}, of_backup{"first"};
    EXPECT_TRUE(left == of_backup || (left == old && !restored)) << testing::PrintToString(left);
  });
}

}  // namespace
}  // namespace truepose::world
