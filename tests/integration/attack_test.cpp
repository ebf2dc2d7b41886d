// The control ports under attack, together with a stream that corrects and a well-behaved client.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "tests/integration/live_cell.hpp"
#include "tests/integration/load_figures.hpp"
#include "tests/integration/own_network.hpp"
#include "tests/integration/stranger.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

struct Attack {
  const char* name;
  /// Attacks until a stop is requested. @return how often it did what it does
  std::function<std::uint64_t(std::stop_token)> run;
};

/// What a client that means well has to wait, each time: for an answer, and for a session.
struct Waits {
  std::vector<double> answer_ms, session_ms;
};

double ms_of(const std::function<void()>& run) {
  const Clock::time_point begin = Clock::now();
  run();
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

std::string p99_and_max(std::vector<double> values) {
  std::ranges::sort(values);
  char text[64];
  std::snprintf(text, sizeof text, "%.1f / %.1f ms", values[values.size() * 99 / 100], values.back());
  return text;
}

/// A daemon whose stream corrects, and whoever comes to its ports.
class AttackedCell {
 public:
  /// @param to  the address that its TLS is at
  explicit AttackedCell(const std::string& to)
      : cell_{{.speedup = 1000,
               .cell = {{"  #tls:", "  tls:"},
                        {"  #  listen: 0.0.0.0:7211", "    listen: " + to + ":0"},
                        {"  #  certificate:", "    certificate:"},
                        {"  #  key:", "    key:"}}}} {
    const Finished made =
        run_program("truepose", {"tls", "init", "--dir", cell_.folder() / "tls", "--host", to});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    cell_.start_daemon();
    const Finished campaign = small_campaign(cell_);
    EXPECT_EQ(campaign.exit_code, 0) << campaign.err << cell_.daemon().errors();
    const Finished start = cell_.truepose({"stream", "start"});
    EXPECT_EQ(start.exit_code, 0) << start.err << cell_.daemon().errors();
  }
  const LiveCell& cell() const { return cell_; }

  /// @param honest  the client that means well
  void withstand(const std::vector<Attack>& attacks, const tools::DaemonAddress& honest) {
    const Clock::duration time = all_trials() ? Clock::duration{60s} : 1s,
                          quiet = all_trials() ? time / 4 : 100ms;
    wait_of(honest, 1s);
    const double before_MB = memory_MB();
    for (const Attack& attack : attacks) {
      Waits waits;
      std::uint64_t done = 0;
      const auto quiet_us = [&] { return p99_while(cell_, [&] { wait_of(honest, quiet); }); };
      const double before_us = quiet_us();
      const double attacked_us = p99_while(cell_, [&] {
        std::jthread attacker{[&](std::stop_token stop) { done = attack.run(std::move(stop)); }};
        waits = wait_of(honest, time);
      });
      const double after_us = quiet_us();
      std::printf(
          "%-34s %8llu in %.0f s: wire p99 %.0f us, quiet %.0f before and %.0f after; an answer (p99 / max) %s, a session %s; %.1f MB\n",
          attack.name, static_cast<unsigned long long>(done), std::chrono::duration<double>(time).count(),
          attacked_us, before_us, after_us, p99_and_max(waits.answer_ms).c_str(),
          p99_and_max(waits.session_ms).c_str(), memory_MB());
      EXPECT_LT(memory_MB() - before_MB, 20) << attack.name;
    }
    EXPECT_LT(memory_MB() - before_MB, 10) << "what an attack takes is given back";
    expect_corrected(honest);
  }

  static tools::RpcClient session(const tools::DaemonAddress& address) {
    auto client = tools::RpcClient::connect(address);
    if (!client) throw std::runtime_error{client.error().message};
    return *std::move(client);
  }

 private:
  double memory_MB() { return resident_MB(cell_.daemon().pid()); }

  static Waits wait_of(const tools::DaemonAddress& honest, Clock::duration time) {
    Waits waits;
    tools::RpcClient client = session(honest);
    const Clock::time_point end = Clock::now() + time;
    for (int i = 0; Clock::now() < end; ++i) {
      waits.answer_ms.push_back(
          ms_of([&] { EXPECT_TRUE(client.call("cell.status", {}).has_value()) << "an honest client"; }));
      if (i % 10 == 0) waits.session_ms.push_back(ms_of([&] { session(honest); }));
      std::this_thread::sleep_for(20ms);
    }
    return waits;
  }

  void expect_corrected(const tools::DaemonAddress& honest) {
    const auto stream = session(honest).call("stream.status", {});
    ASSERT_TRUE(stream);
    EXPECT_EQ(stream->at("state"), "correcting") << json::serialize(*stream);
    EXPECT_EQ(stream->at("sessions"), 1);
    const json::value rsi = cell_.simulated().at("rsi");
    EXPECT_EQ(rsi.at("timeouts"), 0);
    EXPECT_LE(number(rsi, "/max_step_deg"), kMaxStep_deg);
  }

  LiveCell cell_;
};

/// By one that the daemon knows, from four sessions.
std::uint64_t requests(const tools::DaemonAddress& known, const std::stop_token& stop) {
  std::atomic<std::uint64_t> answered = 0;
  {
    std::vector<std::jthread> sessions;
    for (int i = 0; i < 4; ++i) {
      sessions.emplace_back([&] {
        tools::RpcClient client = AttackedCell::session(known);
        while (!stop.stop_requested()) answered += client.call("cell.status", {}).has_value();
      });
    }
  }
  return answered;
}

std::uint64_t readers_that_never_read(const tools::DaemonAddress& known, const std::stop_token& stop) {
  std::vector<tools::RpcClient> readers;
  for (int i = 0; i < 8; ++i) {
    readers.push_back(AttackedCell::session(known));
    readers.back().call("events.subscribe", {{"topics", json::array{"cell", "stream", "log"}}});
  }
  while (!stop.stop_requested()) std::this_thread::sleep_for(10ms);
  return readers.size();
}

// Times are printed and not judged: the attackers have the daemon's processors too.
class ADaemonUnderAttack : public testing::Test {
 protected:
  ADaemonUnderAttack() { setenv("ASAN_OPTIONS", "quarantine_size_mb=0:detect_stack_use_after_return=0", 0); }
};

/// All of this machine's addresses are one peer, so that the client that means well comes by the Unix socket,
/// as the command line does.
TEST_F(ADaemonUnderAttack, ServesAClientThatMeansWellKeepsItsMemoryAndCorrectsOn) {
  AttackedCell attacked{"127.0.0.1"};
  const LiveCell& cell = attacked.cell();
  const Way clear{"127.0.0.2", "127.0.0.1", cell.control_port()};
  const Way tls{"127.0.0.2", "127.0.0.1", cell.tls_port()};
  const tools::DaemonAddress known{"127.0.0.1:" + std::to_string(cell.control_port()), cell.token_file()};
  attacked.withstand(
      {{"200 slow lines", [&](auto stop) { return hold_200(clear, "x", stop); }},
       {"200 TLS handshakes that never end", [&](auto stop) { return hold_200(tls, "\x16", stop); }},
       {"connects", [&](auto stop) { return connect_again_and_again(clear, stop); }},
       {"lines of 1 MB", [&](auto stop) { return send_lines_of_1_MB(clear, stop); }},
       {"requests of four known sessions", [&](auto stop) { return requests(known, stop); }},
       {"readers that never read", [&](auto stop) { return readers_that_never_read(known, stop); }}},
      {(cell.folder() / "run/control.sock").string(), {}});
}

/// Whoever attacks and who means well are on the cell's network both, and come over TLS.
TEST_F(ADaemonUnderAttack, OfAnotherMachineServesAPanelOfTheSameNetwork) {
  if (!OwnNetwork::possible()) GTEST_SKIP() << "makes a network, which needs root and iproute2";
  const std::string here = "10.77.0.1", there = "10.77.0.2";
  const OwnNetwork network{{here, there}};
  AttackedCell attacked{here};
  const LiveCell& cell = attacked.cell();
  const Way bare{there, here, cell.tls_port()};
  const Way tls{there, here, cell.tls_port(), true};
  const tools::DaemonAddress panel{
      here + ":" + std::to_string(cell.tls_port()), cell.token_file(), {.ca = cell.folder() / "tls/ca.pem"}};
  attacked.withstand(
      {{"200 slow lines", [&](auto stop) { return hold_200(tls, "x", stop); }},
       {"200 TLS handshakes that never end", [&](auto stop) { return hold_200(bare, "\x16", stop); }},
       {"connects", [&](auto stop) { return connect_again_and_again(bare, stop); }},
       {"handshakes", [&](auto stop) { return connect_again_and_again(tls, stop); }},
       {"lines of 1 MB", [&](auto stop) { return send_lines_of_1_MB(tls, stop); }},
       {"requests of four known sessions", [&](auto stop) { return requests(panel, stop); }},
       {"readers that never read", [&](auto stop) { return readers_that_never_read(panel, stop); }}},
      panel);
}

}  // namespace
}  // namespace truepose
