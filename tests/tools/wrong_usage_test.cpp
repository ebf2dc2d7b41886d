// Wrong usages of the command line with their answers, which stand in wrong_usage.txt.
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "tests/process.hpp"

namespace truepose {
namespace {

struct Usage {
  std::string line;  ///< "truepose calibrate --help"
  std::string
      answer;  ///< "2 --data: missing. Give DATA or --data FILE": the exit code and what standard error says
};

std::vector<Usage> wrong_usages() {
  std::vector<Usage> usages;
  std::istringstream table{
      text_of(std::filesystem::path{TRUEPOSE_SOURCE_DIR} / "tests/tools/wrong_usage.txt")};
  for (std::string line; std::getline(table, line);) {
    if (line.starts_with("$ "))
      usages.push_back({line.substr(2), ""});
    else if (!line.empty() && !line.starts_with('#'))
      usages.back().answer = line;
  }
  return usages;
}

/// Where no daemon is, among the files of the quickstart.
Finished answered(const std::string& line) {
  return run_program("/bin/bash", {"-c", std::string{"cd "} + TRUEPOSE_SOURCE_DIR +
                                             "/config/quickstart; export PATH=" + TRUEPOSE_BIN_DIR +
                                             ":$PATH XDG_RUNTIME_DIR=/nonexistent; unset "
                                             "TRUEPOSE_DAEMON TRUEPOSE_TOKEN_FILE TRUEPOSE_TLS_CA; " +
                                             line});
}

TEST(WrongUsage, IsAnsweredAsTheTableSays) {
  const std::vector<Usage> usages = wrong_usages();
  EXPECT_GE(usages.size(), 60);
  for (const auto& [line, answer] : usages) {
    const Finished run = answered(line);
    std::string found = run.err;
    if (found.starts_with("truepose: ")) found = found.substr(std::string_view{"truepose: "}.size());
    if (found.empty()) found = "(help)\n";
    EXPECT_EQ(std::to_string(run.exit_code) + " " + found, answer + "\n") << line;
    EXPECT_EQ(run.out.empty(), !answer.ends_with("(help)")) << line;
  }
}

}  // namespace
}  // namespace truepose
