#include <gtest/gtest.h>

#include <algorithm>

#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

constexpr char kHeader[] = "q1,q2,q3,q4,q5,q6,x,y,z\n";

class BadInput : public testing::Test {
 protected:
  Finished calibrate(std::vector<std::string> more) {
    more.insert(more.begin(), "calibrate");
    return run_program("truepose", more);
  }
  Finished calibrate_data(const std::string& text) {
    return calibrate({"--robot", kRobot, "--data", folder_.write("data.csv", text)});
  }
  std::string path(const std::string& name) { return (folder_.path() / name).string(); }
  TempFolder folder_;
};

void expect_one_line(const Finished& run, int exit_code, const std::string& line) {
  EXPECT_EQ(run.exit_code, exit_code);
  EXPECT_EQ(run.err, "truepose: " + line + "\n");
  EXPECT_EQ(run.out, "");
}

TEST_F(BadInput, OfACsvInUtf16IsThatOfWhatIsInIt) {
  for (const bool is_little : {true, false}) {
    std::string text(is_little ? "\xFF\xFE" : "\xFE\xFF");
    for (const char c : std::string(kHeader) + "1,2,3,4,5,6,7,8,9\n") {
      if (!is_little) text += '\0';
      text += c;
      if (is_little) text += '\0';
    }
    const Finished run = calibrate_data(text);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.err, path("data.csv") + ": read as: UTF-16\ntruepose: " + path("data.csv") +
                           ": 1 poses to identify from; base and reflector alone need 5\n");
    EXPECT_EQ(run.out, "");
  }
}

TEST_F(BadInput, ANumberOfAnOptionThatIsNotFinite) {
  const auto refused = [](std::vector<std::string> words, const std::string& line) {
    expect_one_line(run_program("truepose", words), 2, line + " (see truepose " + words.front() + " --help)");
  };
  refused({"calibrate", "--robot", kRobot, "--data", "d.csv", "--tolerance", "nan"},
          "--tolerance: not a finite number: 'nan'");
  refused({"iso9283", "--cube", "1,2,-inf,800"}, "--cube: not a finite number: '-inf'");
  refused({"tool", "--robot", kRobot, "--model", "m", "--data", "d", "--orientation", "0", "NaN", "0"},
          "--orientation: not a finite number: 'NaN'");
  const auto compensate = [&](const std::string& option, const std::string& value, const std::string& why) {
    refused({"compensate", "--robot", kRobot, "--model", "m", "--poses", "p", option, value},
            option + ": " + why);
  };
  compensate("--near", "0,-90,90,0,30,nan", "not a finite number: 'nan'");
  compensate("--singularity-limit", "inf", "not a finite number: 'inf'");
  compensate("--max-correction", "1e999", "a number out of range: '1e999'");
}

TEST_F(BadInput, ACubeWithoutAnEdge) {
  for (const std::string edge : {"0", "-800"})
    expect_one_line(run_program("truepose", {"iso9283", "--cube", "1700,0,1100," + edge}), 2,
                    "--cube: the edge is " + edge + " mm, it must be above 0 (see truepose iso9283 --help)");
}

TEST_F(BadInput, WrongUsage) {
  const std::string see = " (see truepose calibrate --help)";
  expect_one_line(calibrate({"--robot", kRobot}), 2, "--data: missing. Give DATA or --data FILE" + see);
  expect_one_line(
      calibrate({"--robot", kRobot, "--data", "d.csv", "--loss", "cauchy"}), 2,
      "--loss: 'cauchy' is not available in this version (available: outlier-rejection, squared, huber, igg3, tukey)" +
          see);
  expect_one_line(calibrate({"--robot", kRobot, "--data", "d.csv", "--split", "0.7", "--validate", "v.csv"}),
                  2, "--validate: excludes --split. Give one of them" + see);
  expect_one_line(calibrate({"--robot", kRobot, "--data", "d.csv", "--folds", "5", "--split", "0.7"}), 2,
                  "--split: excludes --folds. Give one of them" + see);
  expect_one_line(calibrate({"--robot", kRobot, "--data", "d.csv", "--folds", "1"}), 2,
                  "--folds: 1 is out of range. Give 2 to 10000" + see);
  expect_one_line(calibrate({"--robot", kRobot, "--data", "d.csv", "--seed", "1"}), 2,
                  "--seed: requires --split or --folds. Give one of them" + see);
  for (std::vector<std::string> options :
       {std::vector<std::string>{"--harmonics", "1,2"}, {"--harmonics", "3", "--non-geometric", "none"}}) {
    options.insert(options.begin(), {"--robot", kRobot, "--data", "d.csv"});
    expect_one_line(calibrate(options), 2, "--harmonics: requires --non-geometric auto. Give both" + see);
  }
  EXPECT_EQ(calibrate({"--robot", kRobot, "--data", "d.csv", "--non-geometric", "some"}).exit_code, 2);
  EXPECT_EQ(calibrate({"--robot", kRobot, "--data", "d.csv", "--residual", "some"}).exit_code, 2);
  EXPECT_EQ(calibrate({"--robot", kRobot, "--data", "d.csv", "--split", "1.5"}).exit_code, 2);
}

TEST_F(BadInput, AnOldOptionIsRefusedWithItsNewName) {
  const std::vector<std::string> compensate{"compensate", "--robot", kRobot, "--model", "m", "--poses", "p"},
      calibrate{"calibrate", "--robot", kRobot, "--data", "d"}, identify{"campaign", "identify", "ID"},
      start{"campaign", "start"};
  struct Old {
    std::vector<std::string> words;
    std::string option, value, new_option;
  };
  for (const Old& old : {Old{calibrate, "--deviation", "auto", "--non-geometric"},
                         Old{identify, "--deviation", "auto", "--non-geometric"},
                         Old{compensate, "--singular-below", "20", "--singularity-threshold"},
                         Old{compensate, "--singular-bound", "0.5", "--singularity-limit"},
                         Old{compensate, "--largest-correction", "10", "--max-correction"},
                         Old{compensate, "--most-residual", "0.1", "--max-orientation-residual"},
                         Old{compensate, "--most-residual-mm", "0.01", "--max-position-residual"},
                         Old{start, "--known", "0,0,0", "--nominal"}})
    for (const bool in_one_word : {false, true}) {
      std::vector<std::string> words = old.words;
      if (in_one_word)
        words.push_back(old.option + "=" + old.value);
      else
        words.insert(words.end(), {old.option, old.value});
      const std::string command = words[0] == "campaign" ? words[0] + " " + words[1] : words[0];
      expect_one_line(run_program("truepose", words), 2,
                      old.option + ": unknown option, renamed to '" + old.new_option + "' (see truepose " +
                          command + " --help)");
    }
  const Finished loss =
      run_program("truepose", {"calibrate", "--robot", kRobot, "--data", "d", "--loss", "screened"});
  EXPECT_EQ(loss.exit_code, 2);
  EXPECT_NE(loss.err.find("tukey), renamed to 'outlier-rejection'"), std::string::npos) << loss.err;
}

TEST_F(BadInput, RowsThatValidateWhereTheSplitIsDrawn) {
  const std::string data = folder_.write(
      "d.csv", "q1,q2,q3,q4,q5,q6,x,y,z,set\n0,-90,90,0,0,0,1,2,3,identify\n0,-80,90,0,0,0,1,2,3,validate\n");
  for (const auto& [option, value] : {std::pair{"--split", "0.7"}, {"--folds", "2"}})
    expect_one_line(
        calibrate({"--robot", kRobot, "--data", data, option, value}), 2,
        data + ": row 2: set: validate, but " + option +
            " draws the poses that validate from all rows: leave that option out, or remove the column");
}

TEST_F(BadInput, TemperaturesThatNoRowHas) {
  for (const std::string columns : {"", ",temp1,temp2,temp3,temp4,temp5,temp6"}) {
    const std::string data =
        folder_.write("d.csv", "q1,q2,q3,q4,q5,q6,x,y,z" + columns + "\n0,-90,90,0,0,0,1,2,3" +
                                   (columns.empty() ? "" : ",,,,,,") + "\n");
    expect_one_line(
        calibrate({"--robot", kRobot, "--data", data, "--thermal", "temperatures"}), 2,
        data +
            ": no columns temp1.. with the drives' temperatures, which --thermal temperatures goes by: "
            "add them, or take auto, time or none");
  }
}

TEST_F(BadInput, ValidationThatTellsTimeInAnotherForm) {
  const std::string row = "0,-90,90,0,0,0,1,2,3,", head = "q1,q2,q3,q4,q5,q6,x,y,z,time\n";
  const std::string data = folder_.write("d.csv", head + row + "2026-11-26T08:00:30Z\n"),
                    validation = folder_.write("v.csv", head + row + "30\n");
  expect_one_line(calibrate({"--robot", kRobot, "--data", data, "--validate", validation}), 2,
                  validation +
                      ": time: '30', where the data to identify have '2026-11-26T08:00:30Z': write all times "
                      "in one form");
}

TEST_F(BadInput, ANoiseThatIsNotAboveZero) {
  const std::string see = " (see truepose calibrate --help)";
  for (const std::string noise : {"0.01", "0.01,x", "0.01,0", "-1,0.006", "0.01,0.006,1", "nan,1", ""}) {
    expect_one_line(calibrate({"--robot", kRobot, "--data", "d.csv", "--tracker-noise", noise}), 2,
                    "--tracker-noise: '" + noise +
                        "' is not RANGE_MM,TRANSVERSE_MM_PER_M, two numbers above 0 such as 0.01,0.006" +
                        see);
  }
  for (const std::string noise : {"0", "-0.1", "x", "0.1,0.2"}) {
    expect_one_line(calibrate({"--robot", kRobot, "--data", "d.csv", "--repeatability", noise}), 2,
                    "--repeatability: '" + noise + "' is not a length in mm above 0 such as 0.02" + see);
  }
}

TEST(Help, GoesToStandardOutputAndEndsWell) {
  for (const char* option : {"--help", "--version"}) {
    const Finished run = run_program("truepose", {option});
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_NE(run.out, "");
    EXPECT_EQ(run.err, "");
  }
  EXPECT_EQ(run_program("truepose", {"calibrate", "--help"}).exit_code, 0);
}

}  // namespace
}  // namespace truepose
