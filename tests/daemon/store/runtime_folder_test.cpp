#include "daemon/store/runtime_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RuntimeFolder : public testing::Test {
 protected:
  RuntimeFolder() { config_.name = "press line/3"; }
  fs::path in(const char* name) const { return folder_.path() / name; }

  TempFolder folder_;
  config::CellConfig config_;
};

TEST_F(RuntimeFolder, IsTheCellFilesElseTheUnitsElseTheUsersElseTheSystems) {
  RuntimePlaces places{
      .unit = in("unit").string() + ":" + in("second").string(), .user = in("user"), .system = in("system")};
  config_.runtime = in("configured");
  EXPECT_EQ(runtime_folder(config_, places), in("configured"));
  config_.runtime.clear();
  EXPECT_EQ(runtime_folder(config_, places), in("unit"));
  places.unit.clear();
  EXPECT_EQ(runtime_folder(config_, places), in("user") / "truepose-press-line-3");
  places.user.clear();
  EXPECT_EQ(runtime_folder(config_, places), in("system") / "press-line-3");
}

TEST_F(RuntimeFolder, IsMadeForItsOwnerAndGroupAndKeptWhereItIsThere) {
  config_.runtime = in("new");
  ASSERT_EQ(runtime_folder(config_), in("new"));
  EXPECT_EQ(fs::status(in("new")).permissions(), fs::perms{0750});
  folder_.write("new/page", "kept");
  ASSERT_EQ(runtime_folder(config_), in("new"));
  EXPECT_TRUE(fs::exists(in("new") / "page"));
}

TEST_F(RuntimeFolder, IsMadeWhereTheProcessStandsByItsBareName) {
  const StandsIn here{folder_.path()};
  config_.runtime = "run";
  EXPECT_EQ(runtime_folder(config_), "run");
  EXPECT_TRUE(fs::is_directory(in("run")));
}

TEST_F(RuntimeFolder, IsRefusedWhereOthersMayWriteOrWhereItCannotBeMade) {
  fs::create_directory(in("open"));
  fs::permissions(in("open"), fs::perms{0770});
  config_.runtime = in("open");
  EXPECT_THAT(runtime_folder(config_).error(), HasSubstr("others may write there; run: chmod 750"));

  fs::create_directory(in("real"));
  fs::create_symlink(in("real"), in("link"));
  config_.runtime = in("link");
  EXPECT_THAT(runtime_folder(config_).error(), HasSubstr("link: is no folder"));

  folder_.write("file", "");
  config_.runtime = in("file") / "below";
  EXPECT_THAT(runtime_folder(config_).error(), HasSubstr("cannot be made"));
}

}  // namespace
}  // namespace truepose::daemon
