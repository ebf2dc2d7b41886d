// The control ports under attack, beside a stream that corrects and a client that means well.
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "core/math/statistics.hpp"
#include "tests/integration/live_cell.hpp"
#include "tests/integration/load_figures.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using boost::asio::ip::tcp;
using boost::system::error_code;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// A connection over TCP. All of this machine's addresses are one peer, so that the client that means well
/// comes by the Unix socket, as the command line does.
class Stranger {
 public:
  explicit Stranger(std::uint16_t port) : to_{boost::asio::ip::make_address("127.0.0.1"), port} {}

  /// Connected anew where it was not any more. @return whether it is
  bool connect() {
    if (socket_ && !ended()) return true;
    socket_.emplace(context_);
    error_code failed;
    socket_->open(tcp::v4());
    // The port is chosen when it connects: else ports run out, and strangers come from everybody's address.
    const int later = 1;
    ::setsockopt(socket_->native_handle(), IPPROTO_IP, IP_BIND_ADDRESS_NO_PORT, &later, sizeof later);
    socket_->bind({boost::asio::ip::make_address("127.0.0.2"), 0}, failed);
    if (!failed) socket_->connect(to_, failed);
    if (failed) socket_.reset();
    return !failed;
  }
  void send(std::string_view bytes) {
    error_code failed;
    boost::asio::write(*socket_, boost::asio::buffer(bytes), failed);
    if (failed) socket_.reset();
  }
  void hang_up() { socket_.reset(); }

 private:
  bool ended() {
    error_code failed;
    char byte = 0;
    socket_->non_blocking(true);
    socket_->receive(boost::asio::buffer(&byte, 1), 0, failed);
    socket_->non_blocking(false);
    return failed && failed != boost::asio::error::would_block;
  }

  boost::asio::io_context context_;
  tcp::endpoint to_;
  std::optional<tcp::socket> socket_;
};

struct Attack {
  const char* name;
  /// Attacks until it is told to stop. @return how often it did what it does
  std::function<std::uint64_t(std::stop_token)> run;
};

/// Of 200 connections that stay, each gets these bytes ten times a second.
std::uint64_t hold(std::uint16_t port, std::string_view bytes, const std::stop_token& stop) {
  std::vector<std::unique_ptr<Stranger>> strangers;
  for (int i = 0; i < 200; ++i) strangers.push_back(std::make_unique<Stranger>(port));
  std::uint64_t sent = 0;
  while (!stop.stop_requested()) {
    for (const auto& stranger : strangers) {
      if (!stranger->connect()) continue;
      stranger->send(bytes);
      ++sent;
    }
    std::this_thread::sleep_for(100ms);
  }
  return sent;
}

std::uint64_t connect_again_and_again(std::uint16_t port, const std::stop_token& stop) {
  Stranger stranger{port};
  std::uint64_t connects = 0;
  while (!stop.stop_requested()) {
    connects += stranger.connect();
    stranger.hang_up();
  }
  return connects;
}

std::uint64_t long_lines(std::uint16_t port, const std::stop_token& stop) {
  const std::string line(1'000'000, 'x');
  Stranger stranger{port};
  std::uint64_t lines = 0;
  while (!stop.stop_requested()) {
    if (!stranger.connect()) continue;
    stranger.send(line);
    ++lines;
  }
  return lines;
}

/// One that the daemon knows, from four sessions.
std::uint64_t requests(const LiveCell& cell, const std::stop_token& stop) {
  std::atomic<std::uint64_t> answered = 0;
  {
    std::vector<std::jthread> sessions;
    for (int i = 0; i < 4; ++i) {
      sessions.emplace_back([&] {
        tools::RpcClient client = cell.client();
        while (!stop.stop_requested()) answered += client.call("cell.status", {}).has_value();
      });
    }
  }
  return answered;
}

std::uint64_t readers_that_never_read(const LiveCell& cell, const std::stop_token& stop) {
  std::vector<tools::RpcClient> readers;
  for (int i = 0; i < 8; ++i) {
    readers.push_back(cell.client());
    readers.back().call("events.subscribe", {{"topics", json::array{"cell", "stream", "log"}}});
  }
  while (!stop.stop_requested()) std::this_thread::sleep_for(10ms);
  return readers.size();
}

double ms_of(const std::function<void()>& run) {
  const Clock::time_point begin = Clock::now();
  run();
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

tools::RpcClient honest_client(const LiveCell& cell) {
  auto client = tools::RpcClient::connect({(cell.folder() / "run/control.sock").string(), {}});
  if (!client) throw std::runtime_error{client.error().message};
  return *std::move(client);
}

/// What a client that means well has to wait, each time: for an answer, and for a session.
struct Waits {
  std::vector<double> answer_ms, session_ms;
};

Waits of_an_honest_client(const LiveCell& cell, Clock::duration time) {
  Waits waits;
  tools::RpcClient client = honest_client(cell);
  const Clock::time_point end = Clock::now() + time;
  for (int i = 0; Clock::now() < end; ++i) {
    waits.answer_ms.push_back(
        ms_of([&] { EXPECT_TRUE(client.call("cell.status", {}).has_value()) << "an honest client"; }));
    if (i % 10 == 0) waits.session_ms.push_back(ms_of([&] { honest_client(cell); }));
    std::this_thread::sleep_for(20ms);
  }
  return waits;
}

std::string p99_and_max(std::vector<double> values) {
  std::ranges::sort(values);
  char text[64];
  std::snprintf(text, sizeof text, "%.1f / %.1f ms", values[values.size() * 99 / 100], values.back());
  return text;
}

// Times are printed and not judged: the attackers have the daemon's processors too.
TEST(ADaemonUnderAttack, ServesAClientThatMeansWellKeepsItsMemoryAndCorrectsOn) {
  setenv("ASAN_OPTIONS", "quarantine_size_mb=0:detect_stack_use_after_return=0", 0);
  LiveCell cell{{.cell = {{"  #tls:", "  tls:"},
                          {"  #  listen: 0.0.0.0:7211", "    listen: 127.0.0.1:0"},
                          {"  #  certificate:", "    certificate:"},
                          {"  #  key:", "    key:"}}}};
  const Finished made =
      run_program("truepose", {"tls", "init", "--dir", cell.folder() / "tls", "--host", "127.0.0.1"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  cell.start_daemon();
  const Finished campaign = small_campaign(cell);
  ASSERT_EQ(campaign.exit_code, 0) << campaign.err << cell.daemon().errors();
  const Finished start = cell.truepose({"stream", "start"});
  ASSERT_EQ(start.exit_code, 0) << start.err << cell.daemon().errors();

  const std::vector<Attack> attacks{
      {"200 slow lines", [&](auto stop) { return hold(cell.control_port(), "x", stop); }},
      {"200 TLS handshakes that never end", [&](auto stop) { return hold(cell.tls_port(), "\x16", stop); }},
      {"connects", [&](auto stop) { return connect_again_and_again(cell.control_port(), stop); }},
      {"lines of 1 MB", [&](auto stop) { return long_lines(cell.control_port(), stop); }},
      {"requests of four known sessions", [&](auto stop) { return requests(cell, stop); }},
      {"readers that never read", [&](auto stop) { return readers_that_never_read(cell, stop); }}};
  const Clock::duration time = all_trials() ? 60s : 2s;
  of_an_honest_client(cell, 1s);
  const double before_MB = resident_MB(cell.daemon().pid());
  for (const Attack& attack : attacks) {
    Waits waits;
    std::uint64_t done = 0;
    const auto quiet_us = [&] { return p99_while(cell, [&] { of_an_honest_client(cell, time / 4); }); };
    const double before_us = quiet_us();
    const double attacked_us = p99_while(cell, [&] {
      std::jthread attacker{[&](std::stop_token stop) { done = attack.run(std::move(stop)); }};
      waits = of_an_honest_client(cell, time);
    });
    const double after_us = quiet_us();
    std::printf(
        "%-34s %8llu in %.0f s: wire p99 %.0f us, quiet %.0f before and %.0f after; an answer (p99 / max) %s, a session %s; %.1f MB\n",
        attack.name, static_cast<unsigned long long>(done), std::chrono::duration<double>(time).count(),
        attacked_us, before_us, after_us, p99_and_max(waits.answer_ms).c_str(),
        p99_and_max(waits.session_ms).c_str(), resident_MB(cell.daemon().pid()));
    EXPECT_LT(resident_MB(cell.daemon().pid()) - before_MB, 20) << attack.name;
  }
  EXPECT_LT(resident_MB(cell.daemon().pid()) - before_MB, 10) << "what an attack takes is given back";
  tools::RpcClient client = honest_client(cell);
  const auto stream = client.call("stream.status", {});
  ASSERT_TRUE(stream);
  EXPECT_EQ(stream->at("state"), "correcting") << json::serialize(*stream);
  EXPECT_EQ(stream->at("sessions"), 1);
  const json::value rsi = cell.simulated().at("rsi");
  EXPECT_EQ(rsi.at("timeouts"), 0);
  EXPECT_LE(number(rsi, "/max_step_deg"), kMaxStep_deg);
}

}  // namespace
}  // namespace truepose
