#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "tests/integration/live_cell.hpp"

namespace truepose {
namespace {

namespace json = boost::json;

constexpr double kCyclesPerSecond = 250;

/// How long the stream runs undisturbed: an acceptance run sets TRUEPOSE_STREAM_SECONDS.
double stream_seconds() {
  const char* const seconds = std::getenv("TRUEPOSE_STREAM_SECONDS");
  return seconds ? std::strtod(seconds, nullptr) : 5;
}

json::value stream_status(const LiveCell& cell) {
  const Finished status = cell.truepose({"stream", "status", "--json"});
  if (status.exit_code != 0) throw std::runtime_error{status.err};
  return json::parse(status.out);
}

/// Follows the daemon's own reports, one a second, until it corrects and the condition holds.
/// @throws std::runtime_error where it does not continue by itself, or the controller does not
template <typename Holds>
json::value wait_until_correcting(tools::RpcClient& client, Holds holds) {
  double cycles = -1;
  for (;;) {
    const auto event = client.next_event();
    if (!event) throw std::runtime_error{event.error().message};
    if (event->topic == "fault") throw std::runtime_error{json::serialize(event->data)};
    if (event->topic != "stream") continue;
    if (event->data.at("state") == "correcting" && holds(event->data)) return event->data;
    const double cycles_before = std::exchange(cycles, number(event->data, "/cycles"));
    const json::value& age_ms = event->data.at("packet_age_ms");
    if (!age_ms.is_null() && age_ms.to_number<double>() > 5000 && cycles == cycles_before)
      throw std::runtime_error{"the controller has ended: " + json::serialize(event->data)};
  }
}

/// Cycles without a reply in time, as the daemon or the controller counts them.
double missed_cycles(const json::value& stream) { return number(stream, "/late") + number(stream, "/lost"); }

/// Keeps a program from running for so many of the controller's cycles. Where the machine takes time away
/// from all, they get longer, not more: each is slept by itself.
void stall(const Process& program, int cycles) {
  std::thread{[&] {
    const sched_param fifo{.sched_priority = 50};
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo);
    program.send(SIGSTOP);
    for (int cycle = 0; cycle < cycles; ++cycle) std::this_thread::sleep_for(std::chrono::milliseconds{4});
    program.send(SIGCONT);
  }}.join();
}

/// A stream of a cell with a model that a campaign over the real protocols has made, and a client that is
/// notified.
class AStreamUnderWay : public testing::Test {
 protected:
  void SetUp() override {
    cell.start_daemon();
    const Finished campaign = small_campaign(cell);
    ASSERT_EQ(campaign.exit_code, 0) << campaign.err << cell.daemon().errors();
    client.emplace(cell.client());
    ASSERT_TRUE(client->call("events.subscribe", {{"topics", json::array{"stream", "fault"}}}));
    const Finished started = cell.truepose({"stream", "start"});
    ASSERT_EQ(started.exit_code, 0) << started.err << cell.daemon().errors();
  }

  LiveCell cell{{.speedup = 1000, .patient = true}};
  std::optional<tools::RpcClient> client;
};

TEST_F(AStreamUnderWay, AnswersEveryPacketHoldsThroughAStallAndRampsOutAtTheEnd) {
  const double cycles = stream_seconds() * kCyclesPerSecond;
  wait_until_correcting(*client,
                        [=](const json::value& stream) { return number(stream, "/cycles") >= cycles; });
  const json::value stream = stream_status(cell);
  const json::value undisturbed = cell.simulated().at("rsi");
  std::printf("daemon: %s\nsimulator: %s\n", json::serialize(stream).c_str(),
              json::serialize(undisturbed).c_str());
  const double answered = number(stream, "/answered"), unconfirmed = number(stream, "/unconfirmed");
  EXPECT_EQ(answered + unconfirmed, number(stream, "/cycles")) << "held ones are answered too";
  // At the start, until it is known that nothing is in effect: the controller has missed these replies. A
  // pause of the machine makes them more.
  EXPECT_LE(unconfirmed, missed_cycles(undisturbed));
  EXPECT_EQ(stream.at("unexpected_sender"), 0);
  EXPECT_EQ(stream.at("malformed"), 0);
  EXPECT_EQ(stream.at("wrong_ipoc"), 0);
  // What the machine kept from the daemon shows on both sides.
  EXPECT_LE(missed_cycles(stream), missed_cycles(undisturbed));
  EXPECT_LE(number(stream, "/max_step_deg"), kMaxStep_deg);
  EXPECT_GT(number(undisturbed, "/correction_deg"), 0.01);
  EXPECT_EQ(undisturbed.at("wrong_ipoc"), 0);
  EXPECT_EQ(undisturbed.at("rejected"), 0);
  EXPECT_EQ(undisturbed.at("clamped"), 0);
  EXPECT_LE(number(undisturbed, "/max_step_deg"), kMaxStep_deg);

  const json::value before = cell.simulated().at("rsi");
  // Longer than a silence of the controller may last, shorter than what the socket's buffer holds.
  stall(cell.daemon(), 140);
  const double until = number(stream, "/cycles") + 3 * kCyclesPerSecond;
  wait_until_correcting(*client, [=](const json::value& now) { return number(now, "/cycles") >= until; });
  const json::value stalled = cell.simulated().at("rsi");
  EXPECT_GE(missed_cycles(stalled), missed_cycles(before) + 110);
  EXPECT_EQ(stalled.at("timeouts"), 0);
  EXPECT_EQ(stalled.at("wrong_ipoc"), 0);
  EXPECT_LE(number(stalled, "/max_step_deg"), kMaxStep_deg) << json::serialize(stalled);

  cell.daemon().terminate();
  EXPECT_TRUE(cell.daemon_tells("STOPPING=1"));
  EXPECT_EQ(cell.daemon().wait(), 0) << cell.daemon().errors();
  const json::value end = cell.end_simulator().at("rsi");
  std::printf("simulator at the end: %s\n", json::serialize(end).c_str());
  EXPECT_EQ(end.at("timeouts"), 0) << "the controller was left without an answer";
  EXPECT_EQ(end.at("sessions"), 1);
  EXPECT_EQ(number(end, "/correction_deg"), 0) << "a correction was left in force";
  EXPECT_LE(number(end, "/max_step_deg"), kMaxStep_deg);
}

// Of a terminal, and of whoever read the log.
TEST_F(AStreamUnderWay, SurvivesItsLogAndRampsOutWhenItsTerminalIsClosed) {
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGUSR1, SIGUSR2}) cell.daemon().send(signal);
  const double later = number(stream_status(cell), "/cycles") + 2 * kCyclesPerSecond;
  wait_until_correcting(*client, [=](const json::value& now) { return number(now, "/cycles") >= later; });
  EXPECT_GT(number(cell.simulated().at("rsi"), "/correction_deg"), 0.01);

  cell.daemon().send(SIGHUP);
  EXPECT_EQ(cell.daemon().wait(), 0) << cell.daemon().errors();
  const json::value end = cell.end_simulator().at("rsi");
  EXPECT_EQ(number(end, "/correction_at_end_deg"), 0) << "a correction was left in force";
  EXPECT_LE(number(end, "/max_step_deg"), kMaxStep_deg);
}

}  // namespace
}  // namespace truepose
