// Every command that a message, a comment or a page names is one that its reader can type.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <sstream>

#include "tests/process.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;

const std::filesystem::path kSource{TRUEPOSE_SOURCE_DIR};

/// What is written after the program's name, and the first place where it is.
using NamedCommands = std::map<std::string, std::string>;

/// Commands stand in backquotes, or begin a line that shows what to type.
void gather(const std::filesystem::path& file, NamedCommands& named) {
  static const std::regex quoted{"`truepose ([^`]+)`"};
  static const std::regex shown{"^[ $]*(?:ExecStart=\\S*/)?truepose ([a-z].*)"};
  std::istringstream text{text_of(file)};
  const bool page = file.extension() == ".md" || file.extension() == ".in";
  for (std::string line; std::getline(text, line);) {
    if (line.find("truepose ") == std::string::npos) continue;
    for (const std::regex* form : {&quoted, &shown}) {
      if (form == &shown && !page) continue;
      for (std::sregex_iterator found{line.begin(), line.end(), *form}, end; found != end; ++found)
        named.emplace((*found)[1], file.lexically_relative(kSource));
    }
  }
}

NamedCommands named_commands() {
  NamedCommands named;
  for (const auto& file : {"README.md", "CHANGELOG.md"}) gather(kSource / file, named);
  for (const auto& folder : {"config", "core", "daemon", "docs", "drivers", "proto", "systemd", "tools"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator{kSource / folder}) {
      if (entry.is_regular_file()) gather(entry.path(), named);
    }
  }
  return named;
}

TEST(NamedCommands, ExistWithTheirOptions) {
  const std::regex command_word{"[a-z][a-z0-9-]*"}, option{"--[a-z][a-z0-9-]*"};
  const NamedCommands named = named_commands();
  EXPECT_GT(named.size(), 20);
  std::map<std::vector<std::string>, Finished> helps;  // a command is named in many places
  for (const auto& [text, file] : named) {
    std::vector<std::string> arguments, options;
    std::istringstream words{text};
    for (std::string word; words >> word && word != "#" && word != "|" && word != ">";) {
      if (std::regex_match(word, option)) options.push_back(word);
      if (options.empty() && std::regex_match(word, command_word)) arguments.push_back(word);
    }
    std::string usage = "truepose";
    for (const std::string& word : arguments) usage += " " + word;
    arguments.push_back("--help");
    const auto [place, is_new] = helps.try_emplace(arguments);
    if (is_new) place->second = run_program("truepose", arguments);
    const Finished& help = place->second;
    EXPECT_EQ(help.exit_code, 0) << file << " names truepose " << text << '\n' << help.err;
    EXPECT_THAT(help.out, HasSubstr(usage)) << file << " names truepose " << text;
    for (const std::string& one : options)
      EXPECT_THAT(help.out, HasSubstr(one)) << file << " names truepose " << text;
  }
}

}  // namespace
}  // namespace truepose
