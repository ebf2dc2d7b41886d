#include "daemon/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "daemon/device_probe.hpp"
#include "daemon/store/store.hpp"
#include "tests/certificates.hpp"
#include "tests/daemon/as_nobody.hpp"
#include "tests/daemon/stream_rig.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;
using Level = CheckFinding::Level;
using testing::Contains;
using testing::Each;
using testing::Field;
using testing::HasSubstr;

RobotModel arm_of_seven_joints() {
  RobotModel arm = nominal_arm();
  arm.joints.push_back(arm.joints.back());
  return arm;
}

class CheckTest : public testing::Test {
 protected:
  CheckTest() {
    config_.robot.model = nominal_arm();
    config_.robot.eki_motion = {"10.0.0.1", 54600};
    config_.robot.eki_state = {"10.0.0.1", 54601};
    config_.tracker.address = {"10.0.0.2", 700};
    config_.stream.ethernet_xml = rsi_file("192.168.44.10", "127.0.0.1");
    config_.stream.listen = {"127.0.0.1", 49152};
    config_.control.token_file = folder_.write("token", "0123456789abcdef0123456789abcdef\n");
    fs::permissions(config_.control.token_file, fs::perms::owner_read | fs::perms::owner_write);
    config_.store = folder_.path() / "cell.sqlite";
    config_.recording.folder = folder_.path() / "recordings";
  }
  /// The shipped RSI configuration with another text in it.
  fs::path rsi_file(const std::string& from, const std::string& to) {
    std::ifstream shipped{fs::path{TRUEPOSE_SOURCE_DIR} / "config/kuka/rsi/truepose_rsi_ethernet.xml"};
    std::string text{std::istreambuf_iterator<char>{shipped}, {}};
    text.replace(text.find(from), from.size(), to);
    return folder_.write("rsi.xml", text);
  }
  std::vector<CheckFinding> findings() const { return check(config_); }
  std::string warnings() const {
    std::string all;
    for (const CheckFinding& finding : findings()) {
      if (finding.level == Level::Warning) all += finding.text + "\n";
    }
    return all;
  }
  static auto failure(const std::string& text) {
    return Contains(testing::AllOf(Field(&CheckFinding::level, Level::Failure),
                                   Field(&CheckFinding::text, HasSubstr(text))));
  }
  static auto warning(const std::string& text) {
    return Contains(testing::AllOf(Field(&CheckFinding::level, Level::Warning),
                                   Field(&CheckFinding::text, HasSubstr(text))));
  }

  TempFolder folder_;
  config::CellConfig config_;
};

TEST_F(CheckTest, RefusesAnArmThatTheDaemonCannotDriveByTheNameOfItsFile) {
  config_.robot.file = "rail.yaml";
  config_.robot.model = arm_of_seven_joints();
  EXPECT_THAT(findings(), failure("rail.yaml: the daemon drives six revolute joints, but "));
}

TEST_F(CheckTest, DoesNotAskAControllerForMoreJointsThanItTells) {
  config_.robot.model = arm_of_seven_joints();
  const auto asked = observe_robot(config_.robot);
  ASSERT_FALSE(asked);
  EXPECT_THAT(asked.error().detail, HasSubstr("the daemon drives six revolute joints"));
}

TEST_F(CheckTest, FindsEverythingGoodInTheShippedFilesAndChangesNothing) {
  EXPECT_THAT(findings(), Each(Field(&CheckFinding::level, Level::Good)));
  EXPECT_FALSE(fs::exists(config_.store));
}

TEST_F(CheckTest, SaysWhereTheRsiConfigurationFails) {
  config_.stream.ethernet_xml = folder_.path() / "none.xml";
  EXPECT_THAT(findings(), failure("none.xml: cannot be opened"));
  config_.stream.ethernet_xml = folder_.write("bad.xml", "<ROOT><CONFIG>");
  EXPECT_THAT(findings(), failure("bad.xml: "));
}

TEST_F(CheckTest, RefusesAnRsiConfigurationUnderWhichACorrectionCouldJump) {
  config_.stream.ethernet_xml = rsi_file("HOLDON=\"1\"", "HOLDON=\"0\"");
  EXPECT_THAT(findings(), failure("HOLDON"));
  config_.stream.ethernet_xml = rsi_file("DEF_Delay", "DEF_Tech.C1");
  EXPECT_THAT(findings(), failure("DEF_Delay"));
}

TEST_F(CheckTest, RefusesACpuThatThereIsNot) {
  config_.stream.cpu = drivers::scheduling_of(0).cpus.back();
  EXPECT_THAT(findings(), Each(Field(&CheckFinding::level, Level::Good)));
  config_.stream.cpu = 1023;
  EXPECT_THAT(findings(), failure("stream.cpu: this process has no CPU 1023"));
}

TEST_F(CheckTest, WarnsOfWhatTheRsiConfigurationLacks) {
  config_.stream.ethernet_xml = rsi_file("DEF_RIst", "DEF_Tech.C1");
  EXPECT_THAT(findings(), warning("DEF_RIst"));
}

TEST_F(CheckTest, SaysWhereTheControllerSendsToAndWhereTheDaemonListens) {
  const std::string file = config_.stream.ethernet_xml.string();
  config_.stream.listen.port = 29152;
  EXPECT_EQ(warnings(), file +
                            ": the controller sends to 127.0.0.1:49152 (IP_NUMBER and PORT), but "
                            "stream.listen is 127.0.0.1:29152. Make them the same.\n");
  config_.stream.listen = {"127.0.0.2", 49152};
  EXPECT_THAT(warnings(), HasSubstr("but stream.listen is 127.0.0.2:49152"));
  config_.stream.listen = {"127.0.0.2", 0};
  EXPECT_THAT(warnings(), HasSubstr("but stream.listen is 127.0.0.2:0"));
  config_.stream.listen = {"127.0.0.1", 0};
  EXPECT_EQ(warnings(), "");
  config_.stream.listen = {"0.0.0.0", 49152};
  EXPECT_EQ(warnings(), "");
}

TEST_F(CheckTest, WarnsOfAnAddressThatThisMachineDoesNotHave) {
  // 192.0.2.0/24 is for documentation: nobody has it.
  config_.stream.ethernet_xml = rsi_file("192.168.44.10", "192.0.2.1");
  config_.stream.listen = {"192.0.2.1", 49152};
  EXPECT_EQ(warnings(),
            "stream.listen: this machine does not have the address 192.0.2.1 now: the daemon cannot start "
            "before its "
            "network card has it\n");
  config_.stream.listen = {"0.0.0.0", 49152};
  EXPECT_THAT(warnings(), HasSubstr("the controller sends to 192.0.2.1:49152"));
  EXPECT_THAT(warnings(), HasSubstr("but this machine does not have that address now"));
}

TEST_F(CheckTest, RefusesAnAddressThatIsNone) {
  for (const char* bad : {"192.168.44", "192.168.44.256", "cell-pc", "::1", "0.0.0.0"}) {
    config_.stream.ethernet_xml = rsi_file("192.168.44.10", bad);
    EXPECT_THAT(findings(), failure("CONFIG/IP_NUMBER is \"" + std::string{bad} + "\"")) << bad;
  }
  config_.stream.ethernet_xml = rsi_file("192.168.44.10", "127.0.0.1");
  config_.stream.listen.host = "::1";
  EXPECT_THAT(findings(), failure("stream.listen: \"::1\" is not an IPv4 address"));
  config_.control.listen.host = "cell-pc";
  EXPECT_THAT(findings(), failure("control.listen: \"cell-pc\" is not an IP address"));
  config_.control.listen.host = "0.0.0.0";
  EXPECT_THAT(findings(), failure("can be reached from other machines"));
}

TEST_F(CheckTest, RefusesAWebPortForOthersWithoutTls) {
  config_.web = config::WebConfig{.listen = config::Endpoint{"0.0.0.0", 7280}};
  EXPECT_THAT(findings(), failure("web.listen: 0.0.0.0 can be reached from other machines, which needs TLS"));
  config_.web->listen = config_.control.listen;
  EXPECT_THAT(findings(), failure("control.listen and web.listen are both 127.0.0.1:7210"));
}

TEST_F(CheckTest, RefusesTwoKeysWithOnePort) {
  config_.robot.eki_state = config_.robot.eki_motion;
  EXPECT_THAT(findings(), failure("robot.eki_motion and robot.eki_state are both 10.0.0.1:54600"));
  config_.robot.eki_state = {"localhost", 7210};
  EXPECT_THAT(findings(), failure("robot.eki_state and control.listen are both 127.0.0.1:7210"));
  config_.control.listen.port = 0;
  EXPECT_THAT(findings(), Each(Field(&CheckFinding::level, Level::Good)));
}

TEST_F(CheckTest, WarnsOfACycleThatNoControllerHas) {
  config_.stream.cycle = std::chrono::milliseconds{40};
  EXPECT_EQ(warnings(), "stream.cycle_ms is 40, but controllers send every 4 ms (IPO_FAST) or 12 ms (IPO)\n");
  config_.stream.cycle = std::chrono::milliseconds{12};
  EXPECT_EQ(warnings(), "");
}

TEST_F(CheckTest, RefusesFewerPosesThanTheArmHasParameters) {
  config_.reflector.p_FS_mm = {60, -50, 190};  // off axis 6: its turn shows
  config_.campaign.coarse_after = 5;
  for (int poses : {5, 8, 9}) {
    config_.campaign.identify_poses = poses;
    EXPECT_THAT(findings(), failure("campaign.identify_poses: " + std::to_string(poses) + " are too few"));
  }
  config_.campaign.identify_poses = 10;
  EXPECT_THAT(findings(), Each(Field(&CheckFinding::level, Level::Good)));
}

TEST_F(CheckTest, RefusesATokenThatOthersCanReadOrGuessOrThatIsNotThere) {
  fs::permissions(config_.control.token_file, fs::perms::others_read, fs::perm_options::add);
  EXPECT_THAT(findings(), failure("chmod 600"));
  config_.control.token_file = folder_.write("short", "123\n");
  fs::permissions(config_.control.token_file, fs::perms::owner_read);
  EXPECT_THAT(findings(), failure("must have 16"));
  config_.control.token_file = folder_.path() / "none";
  EXPECT_THAT(findings(), failure("does not exist"));
}

TEST_F(CheckTest, ACertificateThatDoesNotHoldByTheClockMayPassAndOneThatCannotBeReadMayNot) {
  const Certificates certificates{folder_.path()};
  certificates.make("daemon");
  config_.control.tls =
      config::TlsConfig{{"127.0.0.1", 7211}, certificates.certificate("daemon"), certificates.key("daemon")};
  EXPECT_THAT(findings(), Each(Field(&CheckFinding::level, Level::Good)));
  const auto at = [this](std::chrono::days ahead) {
    return check(config_, std::chrono::system_clock::now() + ahead);
  };
  const auto passing = [](const std::string& text) {
    return Contains(testing::AllOf(Field(&CheckFinding::level, Level::Failure),
                                   Field(&CheckFinding::may_pass, true),
                                   Field(&CheckFinding::text, HasSubstr(text))));
  };
  EXPECT_THAT(at(std::chrono::days{-3}), passing("is not valid before"));
  EXPECT_THAT(at(std::chrono::days{300}), passing("expired on"));
  EXPECT_THAT(at(std::chrono::days{300}), passing("and the clock of this PC says 2"));
  config_.control.tls->key = folder_.write("other.key", "none");
  EXPECT_THAT(at(std::chrono::days{-3}), Contains(testing::AllOf(Field(&CheckFinding::level, Level::Failure),
                                                                 Field(&CheckFinding::may_pass, false))));
}

TEST_F(CheckTest, RefusesAnAccessListThatCannotBeRead) {
  fs::permissions(folder_.write("cell.sqlite.access", "{"), fs::perms::owner_read);
  EXPECT_THAT(findings(), failure("cell.sqlite.access: byte 1"));
}

TEST_F(CheckTest, RefusesAStoreThatCannotBeMade) {
  config_.store = folder_.path() / "none" / "cell.sqlite";
  EXPECT_THAT(findings(), failure("there is no folder"));
  config_.store = folder_.path();
  EXPECT_THAT(findings(), failure("is no file"));
}

TEST_F(CheckTest, SaysWhichFolderCannotBeWrittenWhyAndWhatToDo) {
  const fs::path folder = folder_.path() / "of root";
  fs::create_directory(folder);
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  config_.store = folder / "cell.sqlite";
  config_.recording.folder = folder / "recordings";
  const auto found = [this] {
    const test::AsNobody nobody;
    return findings();
  }();
  EXPECT_THAT(found,
              failure(folder.string() +
                      ": the store's folder cannot be written: Permission denied; give `store` a folder that "
                      "can be (a service: /var/lib/truepose/CELL)"));
  EXPECT_THAT(found,
              warning("recording.folder: " + config_.recording.folder.string() +
                      " cannot be written by this user (Permission denied): give a folder that can be, "
                      "or faults leave no recording"));
  config_.store = config_.control.token_file / "cell.sqlite";
  config_.recording.folder = config_.control.token_file;
  EXPECT_THAT(findings(), failure("the store's folder cannot be written: Not a directory"));
  EXPECT_THAT(findings(), warning("cannot be written by this user (Not a directory)"));
}

TEST_F(CheckTest, WarnsWhereNoRecordingCanBeWritten) {
  config_.recording.folder = folder_.path() / "none" / "recordings";
  EXPECT_THAT(findings(), warning("none/recordings cannot be written by this user"));
}

TEST_F(CheckTest, RefusesAStoreThatTheStartWouldRefuseAndLeavesItAsItIs) {
  config_.store = config_.control.token_file;
  EXPECT_THAT(findings(), failure("file is not a database"));
  config_.store = folder_.write("other.sqlite", "");
  EXPECT_THAT(findings(), warning("other.sqlite: is empty, and is taken as a new store"));

  config_.store = folder_.path() / "cell.sqlite";
  ASSERT_TRUE(Store::open(config_.store));
  const auto bytes = [this] {
    std::ifstream file{config_.store, std::ios::binary};
    return std::string{std::istreambuf_iterator<char>{file}, {}};
  };
  const std::string before = bytes();
  EXPECT_THAT(findings(), Each(Field(&CheckFinding::level, Level::Good)));
  EXPECT_EQ(bytes(), before);

  constexpr std::size_t kSecondPage = 4096;  // the root of the first table, and not the unused rest of a page
  std::string damaged = before;
  damaged.replace(kSecondPage, 2000, 2000, '\x7F');
  config_.store = folder_.write("damaged.sqlite", damaged);
  EXPECT_THAT(findings(), failure("damaged.sqlite"));
}

}  // namespace
}  // namespace truepose::daemon
