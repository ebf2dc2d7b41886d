#include "tools/truepose/online/online_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json/object.hpp>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "tests/tools/terminal.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using testing::HasSubstr;

TEST(CampaignText, SaysWhyAStoredDocumentCannotBeRead) {
  rpc::CampaignGet::Result found;
  for (json::value* const document : {&found.targets, &found.iso9283, &found.frame}) {
    EXPECT_THAT(campaign_text(found), testing::Not(HasSubstr("document")));
    *document = json::object{};
    EXPECT_THAT(campaign_text(found), HasSubstr("the daemon's document: missing key"));
    *document = nullptr;
  }
}

TEST(StreamText, SaysWhyTheMeasuredCorrectionIsNotKnownAndShowsItWhereItIs) {
  const auto of = [](const std::vector<std::optional<double>>& measured_deg) {
    rpc::StreamStatus stream;
    stream.measured_deg = measured_deg;
    return stream_text(stream);
  };
  const std::optional<double> unknown;
  EXPECT_THAT(of({unknown, unknown, unknown, unknown, unknown, unknown}),
              HasSubstr("not separated from the drives' lag yet"));
  EXPECT_THAT(of({0.499, unknown, 0, 0, 0, 0}), HasSubstr("0.499 - 0.000 0.000 0.000 0.000 deg"));
  EXPECT_THAT(of({}), HasSubstr("measured      -"));
}

TEST(StreamText, ShowsOfTheRobotWhatIsKnownAndNothingElse) {
  rpc::CellStatus status;
  rpc::StreamStatus& stream = status.stream;
  stream.armed = true;
  stream.robot = {
      .mode = "AUT", .override_percent = 50, .program = "active", .emergency_stop = true, .gate_open = false};
  const std::string all =
      "mode AUT, override 50 %, program active, emergency stop pressed, safety gate closed";
  EXPECT_THAT(stream_text(stream), HasSubstr("robot         " + all + "\n"));
  EXPECT_THAT(status_text(status), HasSubstr("not connected; " + all));
  stream.robot = {.unknown = "refused"};
  EXPECT_THAT(stream_text(stream), HasSubstr("mode -, override -, program -, emergency stop -, safety gate - "
                                             "(not known: refused)"));
}

TEST(StreamText, TellsHowFastAndHowItRuns) {
  rpc::StreamStatus stream;
  stream.late_by = {.daemon = 1, .machine = 22, .network = 3};
  stream.turnaround_us = {.p50 = 41.2, .p99 = 80, .p999 = 99, .max = 250};
  stream.compute_us = {.p50 = 6.4, .p99 = 9, .p999 = 12, .max = 31};
  stream.scheduling = {.policy = "SCHED_FIFO", .priority = 80, .cpus = {2, 3}, .locked_kB = 81920};
  const std::string text = stream_text(stream);
  EXPECT_THAT(text, HasSubstr("late by       daemon 1, machine 22, network 3\n"));
  EXPECT_THAT(text, HasSubstr("wire          p50 41, p99 80, p99.9 99, max 250 us\n"));
  EXPECT_THAT(text, HasSubstr("compute       p50 6, p99 9, p99.9 12, max 31 us\n"));
  EXPECT_THAT(text, HasSubstr("scheduling    SCHED_FIFO 80 on CPU 2 3, 81920 kB locked\n"));
  EXPECT_THAT(stream_text({}), HasSubstr("scheduling    -\n"));
}

TEST(Verdict, IsColouredOnATerminalUnlessNoColorIsSet) {
  const auto on_terminal = [](const char* no_color) {
    ::setenv("NO_COLOR", no_color, 1);
    ::setenv("TERM", "xterm", 1);
    const Terminal terminal;
    return with_shown_verdict("errors\n\nVerdict: red. Do not use it.\n");
  };
  EXPECT_EQ(on_terminal(""), "errors\n\nVerdict: \x1b[31mred\x1b[0m. Do not use it.\n");
  EXPECT_EQ(on_terminal("1"), "errors\n\nVerdict: red. Do not use it.\n");
  ::unsetenv("NO_COLOR");
}

}  // namespace
}  // namespace truepose::tools
