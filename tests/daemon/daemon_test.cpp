#include "daemon/daemon.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <utility>

#include "daemon/threads/signal.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "drivers/net/spawn.hpp"
#include "tests/daemon/cell_fixture.hpp"
#include "tests/daemon/stream_rig.hpp"
#include "tests/drivers/memory_network.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;

/// A port that no client comes to.
class QuietListener final : public net::Listener {
 public:
  explicit QuietListener(asio::any_io_executor executor) : executor_{std::move(executor)} {}
  asio::any_io_executor executor() override { return executor_; }
  asio::awaitable<net::Result<std::unique_ptr<net::Stream>>> accept() override {
    while (open_) co_await closed_.wait();
    co_return std::unexpected(asio::error::operation_aborted);
  }
  void close() noexcept override {
    open_ = false;
    closed_.notify();
  }
  bool is_open() const override { return open_; }
  net::Stream::End local() const override { return {"127.0.0.1", 7210}; }

 private:
  asio::any_io_executor executor_;
  Signal closed_;
  bool open_ = true;
};

/// An RSI port that no controller sends to.
class QuietRsiLink final : public drivers::RsiLink {
 public:
  std::uint16_t port() const override { return 49152; }
  Counters counters() const override { return {}; }
  std::uint64_t heartbeats() const override { return ++beats_; }
  drivers::Scheduling scheduling() const override { return {}; }
  std::string refused() const override { return {}; }

 private:
  mutable std::uint64_t beats_ = 0;
};

/// A whole daemon in virtual time, whose network is in memory and whose controller and tracker are off.
struct DaemonInVirtualTime : testing::Test {
  DaemonInVirtualTime() {
    config.robot.model = nominal_arm();
    config.robot.rsi_peer = "192.168.44.1";
    config.robot.eki_motion = {"10.0.0.1", kMotionPort};
    config.robot.eki_state = {"10.0.0.1", kStatePort};
    config.tracker.address = {"10.0.0.2", kTrackerPort};
    config.stream.ethernet_xml = fs::path{TRUEPOSE_SOURCE_DIR} / "config/kuka/rsi/truepose_rsi_ethernet.xml";
    config.control.token_file = folder.write("token", "0123456789abcdef0123456789abcdef\n");
    fs::permissions(config.control.token_file, fs::perms::owner_read | fs::perms::owner_write);
    config.store = folder.path() / "cell.sqlite";
    config.recording.folder = folder.path() / "recordings";
    config.recording.ring_mb = 1;
  }

  Machine machine(asio::io_context& io, drivers::MemoryNetwork& network) {
    Machine machine{io.get_executor(),
                    clock,
                    store_thread,
                    compute_thread,
                    recorder_thread,
                    [this] { return std::chrono::system_clock::time_point{clock.now().time_since_epoch()}; }};
    machine.network.stream = [&](const asio::any_io_executor& executor) {
      ++connections;
      return network.streams()(executor);
    };
    const auto quiet = [](const asio::any_io_executor& executor, auto&&...) {
      return std::make_shared<QuietListener>(executor);
    };
    machine.network.listen_tcp = quiet;
    machine.network.listen_local = quiet;
    machine.start_rsi_link = [](const auto&, auto&) { return std::make_unique<QuietRsiLink>(); };
    return machine;
  }

  /// The life of a process: until nothing of it runs or waits any more. @return whether the daemon ended
  bool live_for(drivers::Duration time, const std::function<void()>& meanwhile = {}) {
    asio::io_context io{1};
    drivers::MemoryNetwork network{io, clock};
    network.power({kMotionPort, kStatePort, kTrackerPort}, false);
    const auto daemon = Daemon::start(machine(io, network), config, {});
    if (meanwhile) meanwhile();
    bool ended = false;
    net::spawn(io.get_executor(), daemon->live(clock.sleep_until(clock.now() + time)),
               [&](std::exception_ptr failed) {
                 net::rethrow(failed);
                 ended = true;
               });
    clock.run(io, [] { return false; });
    daemon->settle();
    return ended;
  }

  static constexpr std::uint16_t kMotionPort = 54600, kStatePort = 54601, kTrackerPort = 700;
  TempFolder folder;
  config::CellConfig config;
  drivers::VirtualClock clock{drivers::time_of(1'000'000'000'000)};
  InPlaceWorker store_thread, compute_thread, recorder_thread;
  int connections = 0;
};

TEST_F(DaemonInVirtualTime, EndsInOrderAfterAnHourWithoutDevices) {
  const drivers::TimePoint end = clock.now() + std::chrono::hours{1};
  EXPECT_TRUE(live_for(std::chrono::hours{1}));
  EXPECT_GE(clock.now(), end);
  EXPECT_LT(clock.now(), end + std::chrono::minutes{1});
  EXPECT_EQ(clock.sleepers(), 0U);
  EXPECT_GT(connections, 0);
}

TEST_F(DaemonInVirtualTime, LeavesItsStoreToTheNextAndToNoOtherMeanwhile) {
  constexpr std::chrono::seconds kTime{10};
  const auto another = [&] { EXPECT_THROW(live_for(kTime), StartError); };
  for (int life = 0; life < 3; ++life) EXPECT_TRUE(live_for(kTime, another));
}

}  // namespace
}  // namespace truepose::daemon
