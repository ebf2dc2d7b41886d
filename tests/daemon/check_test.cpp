#include "daemon/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/daemon/stream_rig.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;
using Level = Finding::Level;
using testing::Contains;
using testing::Each;
using testing::Field;
using testing::HasSubstr;

class CheckTest : public testing::Test {
 protected:
  CheckTest() {
    config_.robot.model = nominal_arm();
    config_.stream.ethernet_xml = fs::path{TRUEPOSE_SOURCE_DIR} / "config/kuka/rsi/truepose_rsi_ethernet.xml";
    config_.stream.listen.port = 0;
    config_.control.token_file = folder_.write("token", "0123456789abcdef0123456789abcdef\n");
    fs::permissions(config_.control.token_file, fs::perms::owner_read | fs::perms::owner_write);
    config_.store = folder_.path() / "cell.sqlite";
  }
  std::vector<Finding> findings() const { return check(config_); }
  static auto failure(const std::string& text) {
    return Contains(
        testing::AllOf(Field(&Finding::level, Level::Failure), Field(&Finding::text, HasSubstr(text))));
  }
  static auto warning(const std::string& text) {
    return Contains(
        testing::AllOf(Field(&Finding::level, Level::Warning), Field(&Finding::text, HasSubstr(text))));
  }

  TempFolder folder_;
  config::CellConfig config_;
};

TEST_F(CheckTest, FindsEverythingGoodInTheShippedFilesAndChangesNothing) {
  EXPECT_THAT(findings(), Each(Field(&Finding::level, Level::Good)));
  EXPECT_FALSE(fs::exists(config_.store));
}

TEST_F(CheckTest, SaysWhereTheRsiConfigurationFails) {
  config_.stream.ethernet_xml = folder_.path() / "none.xml";
  EXPECT_THAT(findings(), failure("none.xml: cannot be read"));
  config_.stream.ethernet_xml = folder_.write("bad.xml", "<ROOT><CONFIG>");
  EXPECT_THAT(findings(), failure("bad.xml: "));
}

TEST_F(CheckTest, WarnsOfWhatMakesTheRsiConfigurationBehaveBadly) {
  std::ifstream shipped{config_.stream.ethernet_xml};
  std::string text{std::istreambuf_iterator<char>{shipped}, {}};
  const auto hold = text.find("HOLDON=\"1\"");
  ASSERT_NE(hold, text.npos);
  text.replace(hold, 10, "HOLDON=\"0\"");
  config_.stream.ethernet_xml = folder_.write("rsi.xml", text);
  EXPECT_THAT(findings(), warning("HOLDON"));
}

TEST_F(CheckTest, WarnsOfAControllerThatSendsToAnotherPort) {
  config_.stream.listen.port = 1;
  EXPECT_THAT(findings(), warning("stream.listen is port 1"));
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

TEST_F(CheckTest, RefusesAStoreThatCannotBeMade) {
  config_.store = folder_.path() / "none" / "cell.sqlite";
  EXPECT_THAT(findings(), failure("there is no folder"));
  config_.store = folder_.path();
  EXPECT_THAT(findings(), failure("is no file"));
}

}  // namespace
}  // namespace truepose::daemon
