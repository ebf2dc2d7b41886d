#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "core/math/statistics.hpp"
#include "tests/await.hpp"
#include "tests/integration/hostile_datagrams.hpp"
#include "tests/integration/live_cell.hpp"
#include "tests/integration/load_figures.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using boost::asio::ip::udp;
using Clock = HostileDatagrams::Clock;

constexpr int kPerTick = 12;  // from both senders together
constexpr std::chrono::milliseconds kTick{1};

/// How many hostile datagrams at least: an acceptance run sets TRUEPOSE_FLOOD_DATAGRAMS=1200000.
std::uint64_t flood_datagrams() {
  const char* const count = std::getenv("TRUEPOSE_FLOOD_DATAGRAMS");
  return count ? std::strtoull(count, nullptr, 10) : 20'000;
}

/// Two senders of hostile datagrams: one at another address, one at the controller's own with another port.
class Flood {
 public:
  Flood(std::uint16_t rsi_port, HostileDatagrams datagrams)
      : stream_{boost::asio::ip::address_v4::loopback(), rsi_port}, datagrams_{std::move(datagrams)} {}

  /// Sends, twelve thousand a second, until the time is up.
  void run_for(Clock::duration duration) {
    const Clock::time_point begin = Clock::now();
    for (Clock::time_point tick = begin; tick < begin + duration; tick += kTick) {
      std::this_thread::sleep_until(tick);
      for (int i = 0; i < kPerTick; ++i) send(i % 2 == 0 ? elsewhere_ : same_address_);
    }
  }

  std::uint64_t sent() const { return sent_; }

 private:
  void send(udp::socket& socket) {
    boost::system::error_code failed;
    socket.send_to(boost::asio::buffer(datagrams_.next()), stream_, 0, failed);
    if (!failed) ++sent_;
  }

  boost::asio::io_context context_;
  udp::socket elsewhere_{context_, {boost::asio::ip::make_address("127.0.0.2"), 0}};
  udp::socket same_address_{context_, {boost::asio::ip::make_address("127.0.0.1"), 0}};
  udp::endpoint stream_;
  HostileDatagrams datagrams_;
  std::uint64_t sent_ = 0;
};

/// Datagrams that the kernel dropped because no more fitted into the buffers of this port's sockets.
std::uint64_t dropped_by_the_kernel(std::uint16_t port) {
  std::ifstream table{"/proc/net/udp"};
  char local[32];
  std::snprintf(local, sizeof local, ":%04X ", port);
  std::uint64_t dropped = 0;
  for (std::string line; std::getline(table, line);) {
    if (line.find(local) > line.find(' ', line.find(':') + 2)) continue;
    dropped += std::stoull(line.substr(line.find_last_of(' ', line.find_last_not_of(' ')) + 1));
  }
  return dropped;
}

std::string missed(const json::value& rsi) {
  return "late " + json::serialize(rsi.at("late")) + ", lost " + json::serialize(rsi.at("lost"));
}

/// The time stamp that the controller's session began with, by the daemon's log.
std::uint64_t first_ipoc(const std::string& log) {
  const std::string before = "began a session at IPOC ";
  const std::size_t at = log.find(before);
  if (at == std::string::npos) throw std::runtime_error{"no session began: " + log};
  return std::stoull(log.substr(at + before.size()));
}

// p99 is printed and not judged here: the machine that runs the tests has other load. Each round is a quiet
// block, a flooded one and a quiet one; how much the two quiet ones differ says what the ratio of the flooded
// one is worth.
TEST(AStreamUnderAFlood, KeepsItsStepsAnswersTheControllerAloneAndCountsWhatItDropped) {
  // The address sanitizer keeps what was freed, and moves frames to a stack of its own (11 MB a thread,
  // touched as they go round), which is no growth of ours.
  setenv("ASAN_OPTIONS", "quarantine_size_mb=0:detect_stack_use_after_return=0", 0);
  LiveCell cell{{.speedup = 1000}};
  cell.start_daemon();
  const Finished campaign = small_campaign(cell);
  ASSERT_EQ(campaign.exit_code, 0) << campaign.err << cell.daemon().errors();
  const Finished start = cell.truepose({"stream", "start"});
  ASSERT_EQ(start.exit_code, 0) << start.err << cell.daemon().errors();
  const Clock::time_point started = Clock::now();
  tools::RpcClient client = cell.client();
  await("the correction is ramped in",
        [&] { return called(client, "stream.status").at("state") != "ramping"; });

  const std::uint16_t port = cell.rsi_port();
  Flood flood{port, HostileDatagrams{20260519, first_ipoc(cell.daemon().errors()), started}};
  const std::uint64_t dropped_before = dropped_by_the_kernel(port);
  const auto block = std::chrono::milliseconds{flood_datagrams() > 100'000 ? 4000 : 1000};
  const auto quiet = [&] { std::this_thread::sleep_for(block); };
  const double before_MB = resident_MB(cell.daemon().pid());
  double first_MB = 0;
  std::vector<double> flooded, repeated, quiet_us, flooded_us;
  while (flood.sent() < flood_datagrams()) {
    const double a_us = p99_while(cell, quiet);
    const double b_us = p99_while(cell, [&] { flood.run_for(block); });
    const double c_us = p99_while(cell, quiet);
    flooded.push_back(b_us / std::sqrt(a_us * c_us));
    repeated.push_back(c_us / a_us);
    quiet_us.insert(quiet_us.end(), {a_us, c_us});
    flooded_us.push_back(b_us);
    if (first_MB == 0) first_MB = resident_MB(cell.daemon().pid());
  }
  const double after_MB = resident_MB(cell.daemon().pid());

  const std::uint64_t dropped = dropped_by_the_kernel(port) - dropped_before;
  const json::value stream = called(client, "stream.status"), rsi = cell.simulated().at("rsi");
  std::printf(
      "%llu hostile datagrams (%llu dropped by the kernel, %s counted as foreign), in blocks of %lld ms; p99 "
      "of "
      "the wire %.0f us quiet, %.0f us flooded: ratio of blocks %.3f, of two quiet ones %.3f; controller: "
      "max "
      "step %.6f deg, %s of %s cycles; resident %.1f, %.1f, %.1f MB\n",
      static_cast<unsigned long long>(flood.sent()), static_cast<unsigned long long>(dropped),
      json::serialize(stream.at("unexpected_sender")).c_str(), static_cast<long long>(block.count()),
      median(quiet_us), median(flooded_us), median(flooded), median(repeated), number(rsi, "/max_step_deg"),
      missed(rsi).c_str(), json::serialize(rsi.at("cycles")).c_str(), before_MB, first_MB, after_MB);

  EXPECT_EQ(stream.at("state"), "correcting") << json::serialize(stream);
  EXPECT_EQ(number(stream, "/unexpected_sender") + static_cast<double>(dropped),
            static_cast<double>(flood.sent()));
  EXPECT_EQ(stream.at("sessions"), 1);
  for (const char* counter : {"malformed", "wrong_ipoc", "duplicate"})
    EXPECT_EQ(stream.at(counter), 0) << counter;
  EXPECT_GT(number(rsi, "/correction_deg"), 0.01);
  EXPECT_EQ(rsi.at("timeouts"), 0);
  EXPECT_EQ(rsi.at("wrong_ipoc"), 0);
  EXPECT_EQ(rsi.at("rejected"), 0);
  EXPECT_LT(after_MB - before_MB, 2) << "the flood takes memory";

  cell.daemon().terminate();
  EXPECT_EQ(cell.daemon().wait(), 0) << cell.daemon().errors();
  const json::value end = cell.end_simulator().at("rsi");
  EXPECT_EQ(end.at("timeouts"), 0);
  EXPECT_EQ(number(end, "/correction_deg"), 0) << "a correction was left in force";
  EXPECT_LE(number(end, "/max_step_deg"), kMaxStep_deg);
}

}  // namespace
}  // namespace truepose
