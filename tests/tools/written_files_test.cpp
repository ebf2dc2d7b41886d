// What commands write: to files that are not to be lost, and to a standard output that may be full.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "config/robot_file.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/known_model.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kOneRow = "q1,q2,q3,q4,q5,q6\n20,-80,100,30,45,-40\n";

class WrittenFiles : public testing::Test {
 protected:
  fs::path path(const std::string& name) const { return folder_.path() / name; }

  Finished compensate(const std::string& out, std::vector<std::string> more = {}) const {
    more.insert(more.begin(),
                {"compensate", "--robot", robot_, "--model", model_, "--joints", joints_, "--out", out});
    return run_program("truepose", more);
  }
  void expect_refused(const std::string& out, const std::string& other,
                      const std::vector<std::string>& more = {}) const {
    const Finished run = compensate(out, more);
    EXPECT_EQ(run.exit_code, 2) << out;
    EXPECT_EQ(run.err, "truepose: --out: " + out + " is the file of " + other +
                           " too, which would be lost; write to another file\n");
    EXPECT_EQ(run.out, "");
  }

  TempFolder folder_;
  std::string robot_ = folder_.write("robot.yaml", text_of(kRobot)),
              model_ = folder_.write("model.yaml",
                                     config::model_yaml(known_model(config::load_robot(kRobot), 0.01))),
              joints_ = folder_.write("joints.csv", kOneRow);
};

TEST_F(WrittenFiles, AreNotThoseThatTheCommandReads) {
  const std::string model = text_of(model_);
  expect_refused(model_, "--model");
  expect_refused(robot_, "--robot");
  expect_refused(joints_, "--joints");
  EXPECT_EQ(text_of(model_), model);
  EXPECT_EQ(text_of(joints_), kOneRow);
}

TEST_F(WrittenFiles, AreNotThoseThatItReadsByAnotherName) {
  fs::create_directory(path("sub"));
  expect_refused(path("sub/../joints.csv"), "--joints");
  fs::create_symlink(joints_, path("link.csv"));
  expect_refused(path("link.csv"), "--joints");
  fs::create_hard_link(joints_, path("hard.csv"));
  expect_refused(path("hard.csv"), "--joints");
  EXPECT_EQ(text_of(joints_), kOneRow);
}

TEST_F(WrittenFiles, AreNotOneFileTwice) {
  const std::string both = path("both.x");
  const Finished run = compensate(both, {"--report", path("./both.x")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("both.x is the file of --report too, which would be lost"));
  EXPECT_FALSE(fs::exists(both));
  EXPECT_EQ(compensate("/dev/null", {"--report", "/dev/null"}).exit_code, 0) << "nothing is lost there";
}

TEST_F(WrittenFiles, AreRefusedBeforeAnythingElseIsLookedAt) {
  const std::string none = path("none.csv");
  const Finished run = run_program(
      "truepose", {"calibrate", "--robot", robot_, "--data", joints_, "--data", none, "--out", none});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--out: " + none + " is the file of --data too"));
}

TEST_F(WrittenFiles, HaveAName) {
  const Finished run = compensate("");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err, "truepose: --out: expected a file's name (see truepose compensate --help)\n");
  EXPECT_EQ(run.out, "");
}

class FullStandardOutput : public WrittenFiles {
 protected:
  /// A command whose output goes to a disk that is full.
  Finished run(const std::vector<std::string>& arguments) const {
    std::vector<std::string> words{"-c", "exec \"$0\" \"$@\" > /dev/full",
                                   fs::path{TRUEPOSE_BIN_DIR} / "truepose"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return run_program("/bin/sh", words);
  }
  void expect_told(const std::vector<std::string>& arguments) const {
    const Finished finished = run(arguments);
    EXPECT_EQ(finished.exit_code, 2) << arguments.front();
    const std::string why = "standard output cannot be written: No space left on device";
    if (arguments.back() == "--json")
      EXPECT_EQ(error_message(finished.err), why);
    else
      EXPECT_EQ(finished.err, "truepose: " + why + "\n") << arguments.front();
  }
};

TEST_F(FullStandardOutput, EndsACommandWithAWordOnIt) {
  const std::vector<std::string> fk{"fk", "--robot", robot_, "--joints", joints_};
  expect_told(fk);
  std::vector<std::string> as_json = fk;
  as_json.push_back("--json");
  expect_told(as_json);
  expect_told({"iso9283", "--cube", "1700,0,1100,500"});
  expect_told({"fk", "--help"});
}

TEST_F(FullStandardOutput, IsReportedForMoreThanIsKeptBeforeItIsWritten) {
  std::string many = "q1,q2,q3,q4,q5,q6\n";
  for (int i = 0; i < 2000; ++i) many += "20,-80,100,30,45,-40\n";
  const std::string file = folder_.write("many.csv", many);
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--json"}}) {
    std::vector<std::string> fk{"fk", "--robot", robot_, "--joints", file};
    fk.insert(fk.end(), more.begin(), more.end());
    const Finished finished = run(fk);
    EXPECT_EQ(finished.exit_code, 2);
    EXPECT_THAT(finished.err, HasSubstr("standard output cannot be written"));
  }
}

TEST_F(FullStandardOutput, LeavesAnotherTroubleAsItIs) {
  const Finished finished = run({"fk", "--robot", path("none.yaml"), "--joints", joints_});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_THAT(finished.err, HasSubstr("none.yaml: cannot be opened"));
  EXPECT_THAT(finished.err, testing::Not(HasSubstr("standard output")));
}

}  // namespace
}  // namespace truepose
