// truepose compensate --program, as its users run it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/algorithm/string/replace.hpp>
#include <boost/json.hpp>
#include <filesystem>

#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/process.hpp"
#include "tests/proto/krl_corpus.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

namespace json = boost::json;

constexpr char kMotion[] = "LIN {X 1663.329,Y 693.037,Z 1976.8222,A -160.488,B -46.9562,C 22.8781,S 6,T 51}";

class ProgramCommand : public testing::Test {
 protected:
  ProgramCommand() {
    const config::ModelFile model{.name = nominal_.name, .cell = {.robot = with_published_errors(nominal_)}};
    model_ = folder_.write("model.yaml", config::model_yaml(model));
  }

  Finished compensate(const std::string& src, std::vector<std::string> more) {
    more.insert(more.begin(), {"compensate", "--robot", kRobot, "--model", model_, "--program", src});
    return run_program("truepose", more);
  }
  Finished compensate_text(const std::string& text, const std::vector<std::string>& more) {
    return compensate(folder_.write("p.src", text), more);
  }
  void expect_refused(const Finished& run, const std::string& line) {
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.err, "truepose: " + line + "\n");
    EXPECT_EQ(run.out, "");
    EXPECT_FALSE(std::filesystem::exists(out("src")));
    EXPECT_FALSE(std::filesystem::exists(out("dat")));
  }
  std::string out(const std::string& kind) { return (folder_.path() / ("out." + kind)).string(); }
  static std::string corpus(const std::string& name) { return (krl_corpus::kFolder / name).string(); }

  TempFolder folder_;
  RobotModel nominal_ = config::load_robot(kRobot);
  std::string model_;
};

TEST_F(ProgramCommand, TheDocumentNamesEveryChangeAndWhatWasLeft) {
  const Finished run = compensate(corpus("computed.src"), {"--dat", corpus("computed.dat"), "--config-dat",
                                                           corpus("config.dat"), "--json"});
  EXPECT_EQ(run.exit_code, 1);
  const json::object document = printed_document(run.out).as_object();
  EXPECT_EQ(document.at("changed"), 2);
  EXPECT_EQ(document.at("changes").at(0).at("name"), "");  // XP1:{..}, in its numbers
  EXPECT_EQ(document.at("changes").at(1).at("name"), "XP4");
  EXPECT_GT(document.at("largest_mm").at("mm").to_number<double>(), 0.1);
  EXPECT_EQ(document.at("left").as_array().size(), 14U);
  const json::value& computed = document.at("left").at(1);
  EXPECT_EQ(computed.at("name"), "XP2");
  EXPECT_EQ(computed.at("file").as_string(), corpus("computed.src"));
  EXPECT_EQ(computed.at("line"), 9);
  EXPECT_EQ(computed.at("because").at("line"), 8);
  EXPECT_EQ(computed.at("code"), "K_CHANGED");
  EXPECT_EQ(computed.at("why"), "is changed by the program");
  EXPECT_TRUE(computed.at("what_to_do").as_string().starts_with("give it one value"));
  EXPECT_EQ(computed.at("absolute"), true);
  EXPECT_EQ(document.at("notes").as_array().size(), 1U);
}

TEST_F(ProgramCommand, KeepsAByteOrderMarkAndEveryOtherByte) {
  const std::string head = "\xEF\xBB\xBF&ACCESS RVP\r\nDEF P()\t ; \xE4\xF6\xFC\n", tail = "\tC_DIS  ; end";
  const Finished run = compensate_text(
      head + kMotion + tail, {"--tool", "0,0,0,0,0,0", "--base=-10,0,0,0,0,0", "--out", out("src")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string text = text_of(out("src"));
  EXPECT_TRUE(text.starts_with(head + "LIN {X 16")) << text;
  EXPECT_TRUE(text.ends_with(",S 6,T 51}" + tail)) << text;
}

TEST_F(ProgramCommand, BadInputIsOneLineThatSaysWhereAndWhatToDo) {
  const std::string src = (folder_.path() / "p.src").string();
  expect_refused(compensate_text(std::string("DEF P()\n  ") + kMotion, {"--out", out("src")}),
                 src +
                     ":2:7: the program does not set the tool of this motion. Set it before with $TOOL or "
                     "BAS(#TOOL,n), or give --tool x,y,z,a,b,c with --program.");
  expect_refused(compensate_text("DEF P()\nLIN {X 1,Y 2\n", {"--out", out("src")}),
                 src + ":2:5: a brace that is not closed; close it in the same statement");
  expect_refused(
      compensate_text("DEF P()\n", {"--config-dat", folder_.write("c.dat", "TOOL_DATA[1]={X 1E400}\n"),
                                    "--out", out("src")}),
      (folder_.path() / "c.dat").string() + ":1:17: a number out of range; give one that KRL can hold");
  const std::string robot = folder_.write("arm.yaml", text_of(kRobot));
  expect_refused(compensate(robot, {"--out", out("src")}),
                 robot + ": has no DEF, so it is no KRL program. Give the program's .src");
  expect_refused(compensate((folder_.path() / "none.src").string(), {}),
                 (folder_.path() / "none.src").string() + ": cannot be opened: No such file or directory");
}

TEST_F(ProgramCommand, NothingIsWrittenUnlessAllCanBe) {
  const std::vector<std::string> texts{"--dat", corpus("gluing.dat"), "--config-dat", corpus("config.dat")};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), texts.begin(), texts.end());
    return compensate(corpus("gluing.src"), more);
  };
  expect_refused(with({"--out", out("src")}),
                 corpus("gluing.dat") + ": positions in it change too; say where to write it with --out-dat");
  const std::string nowhere = (folder_.path() / "no/out.dat").string();
  expect_refused(with({"--out", out("src"), "--out-dat", nowhere}),
                 nowhere + ": cannot be written: No such file or directory");
  expect_refused(with({"--out", out("src"), "--out-dat", folder_.path()}),
                 folder_.path().string() + ": is a folder, expected a file");
  expect_refused(with({"--out", corpus("gluing.src"), "--out-dat", out("dat")}),
                 "--out: " + corpus("gluing.src") +
                     " is the file of --program too, which would be lost; write to another file");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);
}

TEST_F(ProgramCommand, AnArmWithoutAClosedFormInverseIsRefused) {
  const std::string robot = folder_.write(
      "robot.yaml",
      "name: two\njoints:\n  - {a: 0, alpha: 0, d: 0, theta: 0, sign: 1, min: -9, max: 9, speed: 1}\n"
      "  - {a: 9, alpha: 0, d: 0, theta: 0, sign: 1, min: -9, max: 9, speed: 1}\n"
      "flange: {x: 0, y: 0, z: 0, a: 0, b: 0, c: 0}\n");
  const RobotModel two = config::load_robot(robot);
  const std::string model =
      folder_.write("two.yaml", config::model_yaml({.name = two.name, .cell = {.robot = two}}));
  const Finished run = run_program(
      "truepose", {"compensate", "--robot", robot, "--model", model, "--program", corpus("gluing.src")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err, "truepose: " + robot + ": no closed-form inverse for two: it has 2 joints, not 6\n");
}

}  // namespace
}  // namespace truepose
