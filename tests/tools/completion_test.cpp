// What the shells offer, by the scripts that are installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::IsSupersetOf;

using Offered = std::vector<std::string>;

Offered lines_in(const std::string& text) {
  Offered lines;
  std::istringstream in{text};
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

class BashCompletion : public testing::Test {
 protected:
  /// What bash offers in the place of the last word.
  Offered offered(const std::vector<std::string>& words) const {
    std::string typed = "truepose";
    for (const std::string& word : words) typed += " '" + word + "'";
    const std::string script =
        std::string{"export PATH="} + TRUEPOSE_BIN_DIR + ":$PATH; cd " + folder_.path().string() +
        "; source " + TRUEPOSE_SOURCE_DIR + "/tools/truepose/completion/truepose.bash; COMP_WORDS=(" + typed +
        "); COMP_CWORD=" + std::to_string(words.size()) + "; _truepose; printf '%s\\n' \"${COMPREPLY[@]}\"";
    Offered lines = lines_in(run_program("/bin/bash", {"-c", script}).out);
    std::erase(lines, "");
    return lines;
  }
  TempFolder folder_;
};

TEST_F(BashCompletion, OffersTheCommandsAndTheirGroups) {
  EXPECT_THAT(offered({"cali"}), ElementsAre("calibrate"));
  EXPECT_THAT(offered({""}), IsSupersetOf({"calibrate", "campaign", "doctor", "help"}));
  EXPECT_THAT(offered({"campaign", "s"}), ElementsAre("start", "show"));
  EXPECT_THAT(offered({"help", "campaign", "st"}), ElementsAre("start"));
  EXPECT_THAT(offered({"campain", ""}), IsEmpty());
}

TEST_F(BashCompletion, OffersTheOptionsOfTheCommandAndTheirValues) {
  EXPECT_THAT(offered({"calibrate", "--spl"}), ElementsAre("--split"));
  EXPECT_THAT(offered({"campaign", "start", "--no-re"}), ElementsAre("--no-remeasure"));
  EXPECT_THAT(offered({"calibrate", "--loss", "h"}), ElementsAre("huber"));
  EXPECT_THAT(offered({"calibrate", "--loss", "=", "h"}), ElementsAre("huber")) << "as bash splits --loss=h";
  EXPECT_THAT(offered({"calibrate", "--split", ""}), IsEmpty());
}

TEST_F(BashCompletion, OffersFilesWhereAFileIsExpected) {
  folder_.write("arm.yaml", "");
  folder_.write("points.csv", "");
  const auto both = testing::UnorderedElementsAre("arm.yaml", "points.csv");
  EXPECT_THAT(offered({"calibrate", ""}), both);
  EXPECT_THAT(offered({"calibrate", "arm.yaml", "p"}), ElementsAre("points.csv"));
  EXPECT_THAT(offered({"calibrate", "--robot", "arm.yaml", "p"}), ElementsAre("points.csv"));
  EXPECT_THAT(offered({"calibrate", "arm.yaml", "points.csv", "-o", "a"}), ElementsAre("arm.yaml"));
  EXPECT_THAT(offered({"tls", "init", "--dir", ""}), IsEmpty()) << "a folder is expected";
}

/// The commands that a help shows.
std::set<std::string> commands_in_help() {
  std::set<std::string> commands;
  bool are_commands = false;
  for (const std::string& line : lines_in(run_program("truepose", {"--help"}).out)) {
    if (!line.starts_with(' ')) are_commands = line.starts_with("Commands");
    if (are_commands && line.starts_with("  ") && line[2] != ' ')
      commands.insert(line.substr(2, line.find(' ', 2) - 2));
  }
  return commands;
}

TEST(Completion, OffersEveryCommandThatTheHelpShows) {
  std::set<std::string> offered;
  for (const std::string& line : lines_in(run_program("truepose", {"__complete", ""}).out))
    offered.insert(line.substr(0, line.find('\t')));
  EXPECT_EQ(offered, commands_in_help());
  EXPECT_GT(offered.size(), 30);
}

}  // namespace
}  // namespace truepose
