#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <iterator>
#include <string>

#include "config/text_file.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::HasSubstr;

/// Where no file may become longer, as on a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t most_bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{most_bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signal_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*signal_)(int) = std::signal(SIGXFSZ, SIG_IGN);
};

long files_in(const std::filesystem::path& folder) {
  return std::distance(std::filesystem::directory_iterator{folder}, {});
}

TEST(ATextFile, IsTheOldOneWhereTheDiskHasNoRoomForTheNew) {
  const TempFolder folder;
  const std::filesystem::path file = folder.write("model.yaml", "the old model\n");
  const FullDisk full{4096};
  try {
    write_text_file(file, std::string(100'000, 'x'));
    ADD_FAILURE() << "written";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("model.yaml: cannot be written: File too large"));
  }
  EXPECT_EQ(read_text_file(file), "the old model\n");
  EXPECT_EQ(files_in(folder.path()), 1) << "a temporary file is left";
}

TEST(ATextFile, IsReadableByNobodyWhomTheOneBeforeKeptOut) {
  using std::filesystem::perms;
  const TempFolder folder;
  const std::filesystem::path file = folder.write("model.yaml", "the old model\n");
  const auto mode_after = [&file](perms before) {
    std::filesystem::permissions(file, before);
    write_text_file(file, "the new model\n");
    return std::filesystem::status(file).permissions();
  };
  const perms owner_alone = perms::owner_read | perms::owner_write;
  EXPECT_EQ(mode_after(owner_alone), owner_alone);
  EXPECT_EQ(mode_after(owner_alone | perms::group_read), owner_alone | perms::group_read);
  const mode_t usual = umask(0077);
  EXPECT_EQ(mode_after(owner_alone | perms::others_read), owner_alone) << "the writer keeps them out too";
  umask(usual);
}

TEST(TextFilesThatBelongTogether, AllStayTheOldOnesWhereOneCannotBeWritten) {
  const TempFolder folder;
  const std::filesystem::path first = folder.write("a.src", "old\n");
  EXPECT_THROW(write_together({{first, "new\n"}, {folder.path() / "none" / "a.dat", "new\n"}}), ConfigError);
  EXPECT_EQ(read_text_file(first), "old\n");
  EXPECT_EQ(files_in(folder.path()), 1);
  write_together({{first, "new\n"}, {folder.path() / "a.dat", "new\n"}});
  EXPECT_EQ(read_text_file(first) + read_text_file(folder.path() / "a.dat"), "new\nnew\n");
}

}  // namespace
}  // namespace truepose::config
