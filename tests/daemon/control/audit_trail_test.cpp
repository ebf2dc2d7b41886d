#include "daemon/control/audit_trail.hpp"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <functional>

#include "daemon/control/disk_advice.hpp"
#include "proto/text/digest.hpp"
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
  EXPECT_EQ(verify_audit(file())->end.count, 4U);
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
  EXPECT_EQ(verify_audit(file())->end.count, 0U);
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
    EXPECT_EQ(open().fault(), "");
  }
  EXPECT_EQ(verify_audit(file())->end.count, 3U);
}

/// An acknowledgement, as the daemon puts it on record.
void acknowledge(AuditTrail& trail) {
  const auto asked =
      trail.append({{"who", "Anna"}, {"method", "audit.acknowledge"}, {"params", {{"name", "Anna Beer"}}}});
  ASSERT_TRUE(trail.append({{"of", asked.value()}, {"result", "ok"}}));
  trail.acknowledge();
}

TEST_F(AuditTrailTest, IsNotSoundAfterItWasPutAsideUntilSomebodyAcknowledgesThat) {
  write(3);
  std::string bad = text_of(file());
  bad[bad.find("Anna")] = 'H';
  put(file(), bad);
  {
    AuditTrail trail = open();
    EXPECT_THAT(trail.fault(), HasSubstr("record 2 was changed, or the one before it; it is kept as"));
    EXPECT_EQ(text_of(file().string() + ".changed-2026-11-24T12:00:00.000Z"), bad);
    EXPECT_THAT(trail.records(9, 1).value()[0].at("put_aside").as_string().c_str(), HasSubstr("record 2"));
    EXPECT_EQ(trail.count(), 4U) << "behind the last record that anybody knows of";
    EXPECT_EQ(verify_audit(file())->faults.at(0).acknowledged_by, "");
  }
  AuditTrail trail = open();
  EXPECT_THAT(trail.fault(), HasSubstr("record 2")) << "nor by a restart";
  acknowledge(trail);
  EXPECT_EQ(trail.fault(), "");
  EXPECT_EQ(verify_audit(file())->faults.at(0).acknowledged_by, "Anna Beer (Anna)");
  EXPECT_EQ(open().fault(), "");
}

TEST_F(AuditTrailTest, ShowsThirteenWaysOfTamperingBeforeAndAfterARestart) {
  write(6);
  const std::string trail = text_of(file()), end = text_of(head());
  const auto line = [&](std::size_t n) {
    std::size_t begin = 0;
    for (std::size_t i = 1; i < n; ++i) begin = trail.find('\n', begin) + 1;
    return std::pair{begin, trail.find('\n', begin) + 1 - begin};
  };
  // What an hour ago was there, whole.
  TempFolder earlier;
  const fs::path old = audit_file_of(earlier.path() / "cell.sqlite");
  {
    auto of_then = AuditTrail::open(old, "t");
    for (int i = 0; i < 3; ++i)
      ASSERT_TRUE(of_then->append({{"who", "Anna"}, {"method", std::to_string(i)}}));
  }
  std::vector<control::AuditHead> known{{6, control::read_head(end)->hash}};
  struct Way {
    const char* name;
    std::function<void()> tamper;
  };
  const std::vector<Way> ways{
      {"a byte changed", [&] { put(file(), std::string{trail}.replace(trail.find("Anna"), 1, "H")); }},
      {"a line removed", [&] { put(file(), std::string{trail}.erase(line(3).first, line(3).second)); }},
      {"the first line removed", [&] { put(file(), std::string{trail}.erase(0, line(1).second)); }},
      {"the last line removed", [&] { put(file(), trail.substr(0, line(6).first)); }},
      {"the last line removed, and the end written to fit",
       [&] {
         put(file(), trail.substr(0, line(6).first));
         const std::string last = trail.substr(line(5).first, line(5).second - 1);
         put(head(), control::head_text({5, text::sha256_hex(last)}));
       }},
      {"two lines swapped",
       [&] {
         const std::string two = trail.substr(line(2).first, line(2).second),
                           three = trail.substr(line(3).first, line(3).second);
         put(file(), std::string{trail}.replace(line(2).first, two.size() + three.size(), three + two));
       }},
      {"a line twice",
       [&] {
         put(file(), std::string{trail}.insert(line(3).first, trail.substr(line(3).first, line(3).second)));
       }},
      {"something appended", [&] { put(file(), trail + "{\"n\":7,\"before\":\"0\"}\n"); }},
      {"cut in the middle of a line", [&] { put(file(), trail.substr(0, trail.size() / 2)); }},
      {"emptied", [&] { put(file(), ""); }},
      {"deleted", [&] { fs::remove(file()); }},
      {"its end deleted", [&] { fs::remove(head()); }},
      {"its end changed", [&] { put(head(), std::string{end}.replace(30, 1, end[30] == '0' ? "1" : "0")); }},
      {"both deleted",
       [&] {
         fs::remove(file());
         fs::remove(head());
       }},
      {"replaced by that of an hour ago, with its end",
       [&] {
         put(file(), text_of(old));
         put(head(), text_of(audit_head_of(old)));
       }},
      {"replaced by a new one, with its end",
       [&] {
         fs::remove(file());
         fs::remove(head());
         auto made = AuditTrail::open(file(), "t");
         for (int i = 0; i < 9; ++i) ASSERT_TRUE(made->append({{"who", "Eve"}}));
       }},
  };
  for (const Way& way : ways) {
    SCOPED_TRACE(way.name);
    for (const fs::directory_entry& left : fs::directory_iterator{folder_.path()}) fs::remove(left);
    put(file(), trail);
    put(head(), end);
    ASSERT_TRUE(verify_audit(file(), known));
    way.tamper();
    EXPECT_FALSE(verify_audit(file(), known));
    for (int restarts = 0; restarts < 2; ++restarts) {
      auto opened = AuditTrail::open(file(), "t", known);
      ASSERT_TRUE(opened) << opened.error();
      EXPECT_NE(opened->fault(), "");
      ASSERT_TRUE(opened->append({{"who", "Anna"}}));
      const auto report = verify_audit(file(), known);
      ASSERT_TRUE(report) << report.error();
      EXPECT_EQ(report->faults.size(), 1U);
      EXPECT_EQ(report->faults[0].acknowledged_by, "");
    }
  }
}

TEST_F(AuditTrailTest, GoesOnInANewFileWhereOneIsFullAndIsOneTrail) {
  constexpr std::uint64_t kFull = 600;
  for (int start = 0; start < 4; ++start) {
    auto trail = AuditTrail::open(file(), "t", {}, kFull);
    ASSERT_TRUE(trail) << trail.error();
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(trail->append({{"who", "Anna"}, {"method", std::to_string(i)}}));
    const json::array found = trail->records(100, 100).value();
    ASSERT_EQ(found.size(), trail->count());
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].at("n"), json::value(found.size() - i));
    EXPECT_EQ(trail->records(5, 2).value()[0].at("n"), 4);
  }
  const auto full = full_audit_files(file());
  ASSERT_TRUE(full) << full.error();
  ASSERT_GT(full->size(), 4U);
  EXPECT_EQ(full->front().first, 1U);
  const auto report = verify_audit(file());
  ASSERT_TRUE(report) << report.error();
  EXPECT_EQ(report->end.count, 40U);
  for (const FullAuditFile& one : *full) {
    const std::string good = text_of(one.file);
    put(one.file, std::string{good}.replace(good.find("Anna"), 1, "H"));
    EXPECT_FALSE(verify_audit(file())) << one.file;
    fs::remove(one.file);
    EXPECT_FALSE(verify_audit(file())) << one.file;
    put(one.file, good);
  }
  // The power went as the next one was begun.
  fs::rename(file(), full_audit_file(file(), full->back().last + 1, 40));
  EXPECT_EQ(open().fault(), "");
  EXPECT_EQ(verify_audit(file())->end.count, 40U);
}

TEST_F(AuditTrailTest, ForgetsALineThatAPowerCutLeftInParts) {
  write(3);
  const std::string good = text_of(file());
  put(file(), good + "{\"n\":4,\"before\":\"");
  {
    AuditTrail trail = open();
    EXPECT_EQ(trail.fault(), "");
    EXPECT_EQ(trail.append({{"who", "Bert"}}), 4U);
  }
  EXPECT_EQ(verify_audit(file())->end.count, 4U);
}

TEST_F(AuditTrailTest, TakesALineWhoseEndWasNotYetKept) {
  write(3);
  const std::string three = text_of(head());
  {
    AuditTrail trail = open();
    ASSERT_TRUE(trail.append({{"who", "Bert"}}));
  }
  put(head(), three);
  EXPECT_EQ(open().fault(), "");
  EXPECT_EQ(verify_audit(file())->end.count, 4U);
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
    EXPECT_EQ(verify_audit(file())->end.count, count);
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
      EXPECT_THAT(taken.why_pending, HasSubstr("File too large"));
    }
    EXPECT_FALSE(trail.append({{"method", "not done"}}));
  }
  EXPECT_EQ(trail.append({{"method", "4"}}), 4U);
  const json::array found = trail.records(9, 9).value();
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[1].at("method").as_string(), "3");
  EXPECT_EQ(found[1].at("written_later"), true);
  EXPECT_FALSE(found[0].as_object().contains("written_later"));
  EXPECT_EQ(verify_audit(file())->end.count, 4U);
}

TEST_F(AuditTrailTest, CountsWhatItCannotEvenKeepInMemory) {
  AuditTrail trail = open();
  constexpr int kPending = 300;
  {
    const test::FullDisk full;
    for (int i = 0; i < kPending; ++i) EXPECT_LE(trail.take({{"time", "t"}, {"who", "Anna"}}).number, 200U);
  }
  ASSERT_TRUE(trail.pay());
  EXPECT_EQ(trail.count(), 200U);
  const json::array last = trail.records(201, 1).value();
  EXPECT_EQ(last[0].at("missed").as_int64(), kPending - 199);
  EXPECT_TRUE(verify_audit(file()));
}

}  // namespace
}  // namespace truepose::daemon
