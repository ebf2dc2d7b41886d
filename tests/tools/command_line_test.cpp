// The table of the commands that the daemon answers, how words become values, and tables of text.
#include "tools/truepose/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <map>
#include <set>

#include "config/text_file.hpp"
#include "proto/control/schema.hpp"
#include "proto/rpc/methods.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/progress_line.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::HasSubstr;

// ---- The table and the schema ----

const json::array& schema_of_methods() {
  static const json::value schema = json::parse(control::openrpc_text());
  return schema.at("methods").as_array();
}

/// The schema of a parameter; null where the method has none of that name.
const json::value* schema_of(const std::string& method, const std::string& parameter) {
  for (const json::value& described : schema_of_methods()) {
    if (described.at("name").as_string() != method) continue;
    for (const json::value& one : described.at("params").as_array()) {
      if (one.at("name").as_string() == parameter) return &one;
    }
  }
  return nullptr;
}

/// As JSON schema names the values that this target takes.
std::string type_of(const OptionTarget& target) {
  return std::visit(
      []<class T>(T*) -> std::string {
        if constexpr (std::same_as<T, bool> || std::same_as<T, std::optional<bool>>) return "boolean";
        if constexpr (std::same_as<T, double> || std::same_as<T, std::optional<double>>) return "number";
        if constexpr (std::same_as<T, std::string> || std::same_as<T, std::filesystem::path>) return "string";
        if constexpr (requires(T value) { value.push_back(value.front()); }) return "array";
        return "integer";
      },
      target);
}

/// Methods that no command calls, and why.
const std::map<std::string, std::string> kWithoutCommand{
    {"session.challenge", "every command opens its session with it"},
    {"session.hello", "every command opens its session with it"},
    {"session.ping", "for sessions that last; a command's is short or has events"},
    {"job.get", "for programs, which ask for jobs; a command waits"},
    {"campaign.export", "the parts of the files of `truepose campaign export`"},
    {"campaign.points", "for programs; `truepose campaign export` writes files"},
    {"report.html", "for programs; `truepose report` writes the page"},
    {"store.get_backup", "the parts of the file of `truepose backup`"},
    {"system.info", "for programs; by hand with `truepose call`"},
    {"system.config", "for programs; by hand with `truepose call`"},
    {"drift.check", "`truepose drift`, which judges files too, and so is no row of the table"},
    {"targets.compensate", "for programs; files are compensated by `truepose compensate`"},
    {"events.unsubscribe", "a command ends with its session"}};

TEST(CommandTable, EveryMethodOfTheDaemonHasACommandOrAReasonForHavingNone) {
  std::set<std::string> called;
  for (const Command& command : online_commands().commands) called.insert(command.method);
  for (const std::string& method : rpc::method_names())
    EXPECT_NE(called.contains(method), kWithoutCommand.contains(method)) << method;
  for (const auto& [method, reason] : kWithoutCommand)
    EXPECT_THAT(rpc::method_names(), testing::Contains(method)) << "is no longer a method";
}

TEST(CommandTable, EveryCommandCallsAMethodOfTheDaemon) {
  for (const Command& command : online_commands().commands) {
    const bool needs_none = !command.run || command.name == "call";
    if (needs_none) {
      EXPECT_EQ(command.method, "") << command.name;
    } else {
      EXPECT_THAT(rpc::method_names(), testing::Contains(command.method)) << command.name;
    }
  }
}

TEST(CommandTable, EveryParameterThatACommandSendsIsInTheSchemaWithItsType) {
  for (const Command& command : online_commands().commands) {
    for (const Option& option : command.options) {
      if (option.rules.key.empty()) continue;
      const json::value* const parameter = schema_of(command.method, option.rules.key);
      ASSERT_TRUE(parameter) << command.name << " " << option.name << ": " << option.rules.key;
      EXPECT_EQ(parameter->at("schema").at("type").as_string(), type_of(option.target))
          << command.name << " " << option.name;
    }
  }
}

TEST(CommandTable, WhatAMethodRequiresItsCommandRequires) {
  for (const Command& command : online_commands().commands) {
    for (const Option& option : command.options) {
      const json::value* const parameter = schema_of(command.method, option.rules.key);
      if (!parameter || !parameter->as_object().contains("required")) continue;
      EXPECT_EQ(parameter->at("required").as_bool(), option.rules.required)
          << command.name << " " << option.name;
    }
  }
}

// ---- Words ----

struct Values {
  bool flag = false;
  std::optional<bool> choice;
  int number = 7;
  std::optional<double> share;
  std::string word;
  std::vector<double> list;
  std::string by_place;
};

CommandLine line_of(Values& v, const std::function<int()>& run) {
  return {.options = {},
          .commands = {{.name = "group", .help = "some commands"},
                       {.name = "group work",
                        .help = "works",
                        .options = {{"--flag", &v.flag, "a flag"},
                                    {"--choice", &v.choice, "a choice"},
                                    {"--number", &v.number, "a number", {.check = in_range(5, 10)}},
                                    {"--share", &v.share, "a share", {.needs = {"--flag"}}},
                                    {"--word",
                                     &v.word,
                                     "a word",
                                     {.check = available({"red", "blue"}), .excludes = {"--share"}}},
                                    {"--list", &v.list, "a list", {.count = 2}},
                                    {"PLACE", &v.by_place, "a value by its place"}},
                        .run = run}}};
}

class Words : public testing::Test {
 protected:
  int run(
      const std::vector<std::string>& words, const std::function<int()>& work = [] { return 0; }) {
    values_ = {};
    std::vector<std::string> all{"group", "work"};
    all.insert(all.end(), words.begin(), words.end());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int exit_code = run_command_line(line_of(values_, work), all);
    out_ = testing::internal::GetCapturedStdout();
    err_ = testing::internal::GetCapturedStderr();
    return exit_code;
  }
  Values values_;
  std::string out_, err_;
};

TEST_F(Words, GoWhereTheirOptionsSay) {
  ASSERT_EQ(run({"here", "--flag", "--no-choice", "--number", "9", "--share=0.5", "--list", "1.5,-2"}), 0)
      << err_;
  EXPECT_TRUE(values_.flag);
  EXPECT_EQ(values_.choice, false);
  EXPECT_EQ(values_.number, 9);
  EXPECT_EQ(values_.share, 0.5);
  EXPECT_EQ(values_.list, (std::vector{1.5, -2.0}));
  EXPECT_EQ(values_.by_place, "here");
}

TEST_F(Words, ThatAreMissingLeaveValuesAsTheyAre) {
  ASSERT_EQ(run({}), 0) << err_;
  EXPECT_EQ(values_.number, 7);
  EXPECT_FALSE(values_.choice || values_.share);
}

TEST_F(Words, ThatDoNotFitAreRefusedInOneLine) {
  const std::string see = " (see truepose group work --help)\n";
  const auto refusal = [this](const std::vector<std::string>& words) {
    EXPECT_EQ(run(words), kBadInput);
    EXPECT_EQ(out_, "");
    return err_;
  };
  EXPECT_EQ(refusal({"--number", "11"}), "truepose: --number: 11 is out of range. Give 5 to 10" + see);
  EXPECT_EQ(refusal({"--word", "green"}),
            "truepose: --word: 'green' is not available in this version (available: red, blue)" + see);
  EXPECT_EQ(refusal({"--share", "0.5"}), "truepose: --share: requires --flag. Give both" + see);
  EXPECT_EQ(refusal({"--flag", "--share", "1", "--word", "red"}),
            "truepose: --share: excludes --word. Give one of them" + see);
  EXPECT_EQ(refusal({"--choice", "--no-choice"}),
            "truepose: --choice: excludes --no-choice. Give one of them" + see);
  EXPECT_EQ(refusal({"--list", "1,2,3"}), "truepose: --list: expected 2 values, found 3" + see);
  EXPECT_EQ(refusal({"--flga"}), "truepose: --flga: unknown option, did you mean '--flag'?" + see);
  EXPECT_EQ(refusal({"--number", "nine"}), "truepose: --number: expected a whole number, found 'nine'" + see);
  EXPECT_EQ(refusal({"--number", "010"}), "truepose: --number: expected a whole number, found '010'" + see)
      << "which is eight to some";
  EXPECT_EQ(refusal({"--number"}), "truepose: --number: expected N behind it, found nothing" + see);
  EXPECT_EQ(refusal({"--number", "7", "--number", "8"}),
            "truepose: --number: given 2 times (7, 8). Give it once" + see);
  EXPECT_EQ(refusal({"here", "there"}),
            "truepose: 'there' is one argument too many. Name the option it is for" + see);
}

TEST_F(Words, ThatNameNoCommandAreReportedWithTheNearest) {
  const std::string see = " (see truepose --help)\n";
  const auto refusal = [this](const std::vector<std::string>& words) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_command_line(line_of(values_, [] { return 0; }), words), kBadInput);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(refusal({"grou"}), "truepose: 'grou' is no command, did you mean 'group'?" + see);
  EXPECT_EQ(refusal({"calibrate", "--robot", "r.yaml"}), "truepose: 'calibrate' is no command" + see);
  EXPECT_EQ(refusal({"group", "wrok"}),
            "truepose: 'wrok' is no command of group, did you mean 'work'? (see truepose group --help)\n");
  EXPECT_EQ(refusal({"help", "grop"}), "truepose: help: 'grop' is no command, did you mean 'group'?\n");
  EXPECT_EQ(refusal({"help", "group", "wrok"}),
            "truepose: help: 'wrok' is no command of group, did you mean 'work'?\n");
}

TEST_F(Words, WithoutACommandAreAnsweredByTheHelpAndFail) {
  for (const std::vector<std::string>& words : {std::vector<std::string>{}, {"group"}}) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(run_command_line(line_of(values_, [] { return 0; }), words), kBadInput);
    EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("Commands"));
  }
}

TEST(Subjects, OfSeveralExactlyOneIsGiven) {
  std::string file, points;
  const CommandLine line{.options = {},
                         .commands = {{.name = "work",
                                       .help = "works",
                                       .options = {{"--file", &file, "a file", {.is_subject = true}},
                                                   {"--points", &points, "points", {.is_subject = true}}},
                                       .run = [] { return 0; },
                                       .subjects = "what to work on"}}};
  const auto end_of = [&](const std::vector<std::string>& words) {
    testing::internal::CaptureStderr();
    const int exit_code = run_command_line(line, words);
    testing::internal::GetCapturedStderr();
    return exit_code;
  };
  EXPECT_EQ(end_of({"work", "--points", "p"}), 0);
  EXPECT_EQ(points, "p");
  EXPECT_EQ(end_of({"work"}), kBadInput);
  EXPECT_EQ(end_of({"work", "--file", "f", "--points", "p"}), kBadInput);
}

TEST_F(Words, EndAsTheCommandEnds) {
  EXPECT_EQ(run({}, [] { return 1; }), 1);
  EXPECT_EQ(run({}, []() -> int { throw CommandError{kUnreachable, "nobody\nthere"}; }), 3);
  EXPECT_EQ(err_, "truepose: nobody there\n");
  EXPECT_EQ(run({}, []() -> int { throw config::ConfigError{"a.yaml: bad"}; }), 2);
  EXPECT_EQ(err_, "truepose: a.yaml: bad\n");
  EXPECT_EQ(run({}, []() -> int { throw std::runtime_error{"broken"}; }), 1);
  EXPECT_EQ(run({}, []() -> int { throw bad_usage("a without b"); }), 2);
  EXPECT_EQ(err_, "truepose: a without b (see truepose group work --help)\n");
}

TEST_F(Words, AskForErrorsAsJson) {
  std::string json;
  const auto error_of = [&](bool is_last, const std::function<int()>& work) {
    CommandLine line = line_of(values_, work);
    bool as_json = false;
    line.commands.back().options.push_back({"--json", &as_json, "As JSON"});
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_command_line(line, is_last ? std::vector<std::string>{"group", "work", "--json"}
                                             : std::vector<std::string>{"--json", "group"}),
              kBadInput);
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    return json::parse(testing::internal::GetCapturedStderr()).at("error");
  };
  const json::value bad = error_of(true, []() -> int { throw bad_usage("a without b"); });
  EXPECT_EQ(bad,
            json::parse(R"({"exit_code":2,"message":"a without b","see":"truepose group work --help"})"));
  EXPECT_EQ(error_of(true, []() -> int { throw config::ConfigError{"a.yaml: bad"}; }),
            json::parse(R"({"exit_code":2,"message":"a.yaml: bad"})"));
  EXPECT_EQ(error_of(false, [] { return 0; }).at("see"), "truepose group --help");
}

// ---- Help ----

TEST_F(Words, AskForHelpOnStandardOutput) {
  ::setenv("COLUMNS", "60", 1);
  ASSERT_EQ(run({"--help"}), 0);
  ::unsetenv("COLUMNS");
  const std::string help = out_;
  EXPECT_EQ(help,
            "works.\n"
            "Usage: truepose group work [PLACE] [OPTIONS]\n"
            "\n"
            "Examples:\n"
            "  truepose group work\n"
            "\n"
            "Arguments:\n"
            "  PLACE                     a value by its place\n"
            "\n"
            "Options:\n"
            "  --flag                    a flag\n"
            "  --choice, --no-choice     a choice\n"
            "  --number N                a number. From 5 to 10.\n"
            "  --share NUMBER            a share. Needs --flag. Not with\n"
            "                            --word.\n"
            "  --word red|blue           a word. Not with --share.\n"
            "  --list NUMBER,..          a list\n"
            "  -q, --quiet               No progress and no notes on\n"
            "                            standard error\n"
            "  -h, --help                Print this help\n");
  ::setenv("COLUMNS", "60", 1);
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_command_line(line_of(values_, [] { return 0; }), {"help", "group", "work"}), 0);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), help);
  ::unsetenv("COLUMNS");
}

/// All commands but those that main() adds to them: of the daemon.
TEST(Help, BeginsWithCapitalsAndShowsExamples) {
  for (const Command& command : online_commands().commands) {
    EXPECT_FALSE(std::islower(command.help.front())) << command.name;
    bool needs_more = false;
    for (const Option& option : command.options) {
      EXPECT_FALSE(std::islower(option.help.front())) << command.name << " " << option.name;
      needs_more |= option.rules.required;
    }
    EXPECT_TRUE(!needs_more || !command.examples.empty()) << command.name;
  }
}

TEST(Place, OfAnOptionTakesTheWordsWithoutANameInTheirOrder) {
  std::string robot, out;
  std::vector<std::string> data;
  const CommandLine line{
      .options = {},
      .commands = {
          {.name = "work",
           .help = "Works",
           .options = {{"--robot", &robot, "Robot", {.required = true, .place = "ROBOT"}},
                       {"--data", &data, "Data", {.required = true, .place = "DATA", .repeats = true}},
                       {"--out", &out, "Out"}},
           .run = [] { return 0; }}}};
  for (const std::vector<std::string>& words : {std::vector<std::string>{"r", "d", "-o", "x"},
                                                {"--out", "x", "r", "d"},
                                                {"--robot", "r", "d", "--out=x"},
                                                {"r", "--data", "d", "-ox"}}) {
    robot.clear(), out.clear(), data.clear();
    std::vector<std::string> all{"work"};
    all.insert(all.end(), words.begin(), words.end());
    EXPECT_EQ(run_command_line(line, all), 0);
    EXPECT_EQ(robot + " " + out, "r x");
    EXPECT_EQ(data, std::vector<std::string>{"d"});
  }
}

TEST(Environment, SaysTheValueOfAnOptionThatNoWordGives) {
  std::string token, other;
  const Option with_token{"--token", &token, "a token", {.environment = "TRUEPOSE_TEST_TOKEN"}};
  const auto command = [&](const char* name) {
    return Command{.name = name,
                   .help = "works",
                   .options = {with_token, {"--other", &other, "another", {.needs = {"--token"}}}},
                   .run = [] { return 0; }};
  };
  const auto token_of = [&](const std::vector<std::string>& words) {
    token.clear();
    EXPECT_EQ(
        run_command_line({.options = {with_token}, .commands = {command("work"), command("rest")}}, words),
        0);
    return token;
  };
  ::setenv("TRUEPOSE_TEST_TOKEN", "environment", 1);
  EXPECT_EQ(token_of({"work"}), "environment");
  EXPECT_EQ(token_of({"work", "--other", "x"}), "environment");
  EXPECT_EQ(token_of({"work", "--token", "word"}), "word");
  EXPECT_EQ(token_of({"--token", "word", "work"}), "word");
  ::setenv("TRUEPOSE_TEST_TOKEN", "", 1);
  EXPECT_EQ(token_of({"work"}), "");
  ::unsetenv("TRUEPOSE_TEST_TOKEN");
  EXPECT_EQ(token_of({"work"}), "");
}

// ---- Tables ----

TEST(TextTable, HasColumnsAsWideAsTheirWidestCellAndNoSpacesAtTheEnds) {
  EXPECT_EQ(text_table({{"a", "bcd", ""}, {"long", "x"}}), "a     bcd\nlong  x\n");
}

TEST(TextTable, IsNarrowedToAWidthByLinesOfItsWidestCellsThatBreakBetweenWords) {
  const std::vector<Cells> rows{{"state", "faulted"},
                                {"why", "no reflector was found where the tracker looked"}};
  EXPECT_EQ(text_table(rows, 30),
            "state  faulted\n"
            "why    no reflector was found\n"
            "       where the tracker\n"
            "       looked\n");
  EXPECT_EQ(text_table({{"11df5da4-0000", "x"}}, 8), "11df5da4-0000  x\n") << "a word is kept whole";
  EXPECT_EQ(text_table(rows, 0), text_table(rows, 200));
}

TEST(Progress, SaysTheTimeThatIsLeftOnceAShareIsKnown) {
  EXPECT_EQ(progress_text("calibration", 0, 12s), "calibration: 12 s");
  EXPECT_EQ(progress_text("calibration", 0.4, 12s), "40 % of the calibration, 18 s left");
  EXPECT_EQ(progress_text("plan", 0.25, 60s), "25 % of the plan, 3 min 0 s left");
}

TEST(TextTable, AlignsToEitherSideAndMovesWhatFollowsAWiderCell) {
  EXPECT_EQ(text_table({{-4}, {5}, {3, 1}}, {{"ab", "1.5", "x"}, {"abcdef", "12", "y"}, {}, {"ab"}}),
            "ab    1.5   x\nabcdef   12   y\n\nab\n");
}

}  // namespace
}  // namespace truepose::tools
