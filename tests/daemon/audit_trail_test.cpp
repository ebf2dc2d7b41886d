#include "daemon/control/audit_trail.hpp"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>

#include "daemon/control/disk_advice.hpp"
#include "tests/daemon/full_disk.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using testing::HasSubstr;

class AuditTrailTest : public testing::Test {
 protected:
  fs::path file() const { return audit_file_of(folder_.path() / "cell.sqlite"); }
  fs::path head() const { return file().string() + ".head"; }
  AuditTrail open() {
    auto trail = AuditTrail::open(file(), "2026-11-24T12:00:00.000Z");
    if (!trail) throw std::runtime_error{trail.error()};
    return *std::move(trail);
  }
  /// A trail of so many records.
  void write(int count) {
    AuditTrail trail = open();
    for (int i = 0; i < count; ++i)
      ASSERT_TRUE(trail.append({{"who", "Anna"}, {"method", std::to_string(i)}}));
  }
  void put(const fs::path& where, const std::string& text) { folder_.write(where.filename(), text); }

  TempFolder folder_;
};

TEST_F(AuditTrailTest, GoesOnBehindWhatIsThere) {
  write(3);
  AuditTrail trail = open();
  EXPECT_EQ(trail.append({{"who", "Bert"}}), 4U);
  const json::array found = trail.records(100, 2).value();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].at("who").as_string(), "Bert");
  EXPECT_EQ(found[1].at("method").as_string(), "2");
  EXPECT_EQ(trail.records(2, 5).value().size(), 1U);
  EXPECT_EQ(verify_audit(file())->count, 4U);
}

TEST_F(AuditTrailTest, ShowsAnyByteThatWasChangedInEitherFile) {
  write(6);
  for (const fs::path& changed : {file(), head()}) {
    const std::string good = text_of(changed);
    for (std::size_t i = 0; i < good.size(); ++i) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ 1);
      put(changed, bad);
      EXPECT_FALSE(verify_audit(file())) << changed << ", byte " << i;
    }
    put(changed, good);
  }
  EXPECT_TRUE(verify_audit(file()));
}

TEST_F(AuditTrailTest, ShowsAnyLineThatWasTakenAwayDoubledOrMoved) {
  write(6);
  std::vector<std::string> lines;
  std::istringstream text{text_of(file())};
  for (std::string line; std::getline(text, line);) lines.push_back(line + "\n");
  const auto put_lines = [&](const std::vector<std::string>& some) {
    std::string all;
    for (const std::string& line : some) all += line;
    put(file(), all);
  };
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::vector<std::string> without = lines, twice = lines, moved = lines;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    put_lines(without);
    EXPECT_FALSE(verify_audit(file())) << "without line " << i + 1;
    twice.insert(twice.begin() + static_cast<std::ptrdiff_t>(i), lines[i]);
    put_lines(twice);
    EXPECT_FALSE(verify_audit(file())) << "line " << i + 1 << " twice";
    std::swap(moved[i], moved[(i + 1) % moved.size()]);
    put_lines(moved);
    EXPECT_FALSE(verify_audit(file())) << "line " << i + 1 << " moved";
  }
  fs::remove(file());
  EXPECT_FALSE(verify_audit(file())) << "without the file";
  put_lines(lines);
  fs::remove(head());
  EXPECT_FALSE(verify_audit(file())) << "without its end";
}

TEST_F(AuditTrailTest, IsNotCalledSoundWhereThereIsNone) {
  EXPECT_THAT(verify_audit(file()).error(), HasSubstr("there is none"));
  open();  // makes both files, of no record
  EXPECT_EQ(verify_audit(file())->count, 0U);
}

TEST_F(AuditTrailTest, IsNeitherSoundNorChangedWhereItCannotBeRead) {
  write(3);
  for (const fs::path& unreadable : {file(), head()}) {
    const std::string good = text_of(unreadable);
    fs::remove(unreadable);
    fs::create_symlink(unreadable, unreadable);  // opening fails, and not because there is none
    EXPECT_THAT(verify_audit(file()).error(), HasSubstr(unreadable.string() + " cannot be read: Too many"));
    EXPECT_FALSE(AuditTrail::open(file(), "2026-11-24T12:00:00.000Z"));
    fs::remove(unreadable);
    fs::create_directory(unreadable);  // reading fails
    EXPECT_THAT(verify_audit(file()).error(), HasSubstr(unreadable.string() + " cannot be read: Is a dir"));
    EXPECT_FALSE(AuditTrail::open(file(), "2026-11-24T12:00:00.000Z"));
    fs::remove(unreadable);
    put(unreadable, good);
    EXPECT_EQ(open().put_aside(), "");
  }
  EXPECT_EQ(verify_audit(file())->count, 3U);
}

TEST_F(AuditTrailTest, PutsATrailAsideThatWasChangedAndSaysSo) {
  write(3);
  std::string bad = text_of(file());
  bad[bad.find("Anna")] = 'H';
  put(file(), bad);
  AuditTrail trail = open();
  EXPECT_THAT(trail.put_aside(), HasSubstr("line 2 was changed, or the one before it"));
  EXPECT_EQ(text_of(file().string() + ".changed-2026-11-24T12:00:00.000Z"), bad);
  EXPECT_THAT(trail.records(9, 1).value()[0].at("put_aside").as_string().c_str(), HasSubstr("line 2"));
  EXPECT_TRUE(verify_audit(file()));
}

TEST_F(AuditTrailTest, ForgetsALineThatAPowerCutLeftInParts) {
  write(3);
  const std::string good = text_of(file());
  put(file(), good + "{\"n\":4,\"before\":\"");
  {
    AuditTrail trail = open();
    EXPECT_EQ(trail.put_aside(), "");
    EXPECT_EQ(trail.append({{"who", "Bert"}}), 4U);
  }
  EXPECT_EQ(verify_audit(file())->count, 4U);
}

TEST_F(AuditTrailTest, TakesALineWhoseEndWasNotYetKept) {
  write(3);
  const std::string three = text_of(head());
  {
    AuditTrail trail = open();
    ASSERT_TRUE(trail.append({{"who", "Bert"}}));
  }
  put(head(), three);
  EXPECT_EQ(open().put_aside(), "");
  EXPECT_EQ(verify_audit(file())->count, 4U);
}

TEST_F(AuditTrailTest, SaysThatTheDiskIsFullAndGoesOnOnceItIsNot) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  for (rlim_t room = 0; room < 200; room += 7) {
    AuditTrail trail = open();
    const std::uint64_t count = trail.count();
    const rlimit full{fs::exists(file()) ? fs::file_size(file()) + room : room, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
    const auto refused = trail.append({{"who", std::string(200, 'x')}});
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    EXPECT_FALSE(refused);
    EXPECT_EQ(verify_audit(file())->count, count);
    EXPECT_EQ(trail.append({{"who", "Anna"}}), count + 1);
  }
  std::signal(SIGXFSZ, SIG_DFL);
  EXPECT_TRUE(verify_audit(file()));
}

TEST(DiskAdvice, IsToMakeRoomOnAFullDiskAlone) {
  for (const int full : {ENOSPC, EDQUOT, EFBIG}) EXPECT_EQ(disk_advice(full), "make room on the disk");
  EXPECT_THAT(disk_advice(EROFS), HasSubstr("mount it to be written to"));
  EXPECT_EQ(disk_advice(EIO), "check the disk");
}

TEST_F(AuditTrailTest, OwesWhatTheDiskDoesNotTakeAndWritesItBeforeWhatFollows) {
  AuditTrail trail = open();
  ASSERT_TRUE(trail.append({{"who", "Anna"}, {"method", "0"}}));
  {
    const test::FullDisk full;
    for (std::uint64_t number : {2U, 3U}) {
      const AuditTrail::Taken taken = trail.take({{"method", std::to_string(number)}});
      EXPECT_EQ(taken.number, number);
      EXPECT_THAT(taken.why_owed, HasSubstr("File too large"));
    }
    EXPECT_FALSE(trail.append({{"method", "not done"}}));
  }
  EXPECT_EQ(trail.append({{"method", "4"}}), 4U);
  const json::array found = trail.records(9, 9).value();
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[1].at("method").as_string(), "3");
  EXPECT_EQ(found[1].at("owed"), true);
  EXPECT_FALSE(found[0].as_object().contains("owed"));
  EXPECT_EQ(verify_audit(file())->count, 4U);
}

TEST_F(AuditTrailTest, CountsWhatItCannotEvenKeepInMemory) {
  AuditTrail trail = open();
  constexpr int kOwed = 300;
  {
    const test::FullDisk full;
    for (int i = 0; i < kOwed; ++i) EXPECT_LE(trail.take({{"time", "t"}, {"who", "Anna"}}).number, 200U);
  }
  ASSERT_TRUE(trail.pay());
  EXPECT_EQ(trail.count(), 200U);
  const json::array last = trail.records(201, 1).value();
  EXPECT_EQ(last[0].at("missed").as_int64(), kOwed - 199);
  EXPECT_TRUE(verify_audit(file()));
}

}  // namespace
}  // namespace truepose::daemon
