// Twenty panels that follow a cell through campaigns and daemons that end, over what every kind of panel
// speaks.
#include <gmock/gmock.h>
#include <signal.h>

#include <atomic>
#include <boost/json/value.hpp>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "tests/await.hpp"
#include "tests/daemon/web_client.hpp"
#include "tests/integration/live_cell.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;

/// What the daemon keeps over its end.
const json::array kKept{"cell", "campaign", "measurement", "model", "fault", "control"};

constexpr double kSpeedup = 300;

/// Where the daemon listens now.
struct Ports {
  std::uint16_t control = 0, tls = 0, web = 0;
};

/// A session that gets events, over any of the protocols.
struct Subscription {
  json::value answer;
  std::function<std::optional<control::Event>()> next;  ///< none where the daemon has closed
};

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// None where no daemon answers.
std::optional<Subscription> subscribe(const tools::DaemonAddress& address, std::uint64_t after) {
  auto connected = tools::RpcClient::connect(address);
  if (!connected) return std::nullopt;
  auto client = std::make_shared<tools::RpcClient>(*std::move(connected));
  auto answer = client->call("events.subscribe", {{"topics", kKept}, {"after", after}});
  if (!answer) return std::nullopt;
  return Subscription{*answer, [client]() -> std::optional<control::Event> {
                        auto event = client->next_event();
                        if (!event) return std::nullopt;
                        return *std::move(event);
                      }};
}

/// Over WebSocket, without a library of ours.
std::optional<Subscription> subscribe(std::uint16_t web_port, const std::string& token,
                                      std::uint64_t after) try {
  auto client = std::make_shared<daemon::test::WebSocketClient>(web_port);
  if (!client->hello(token).result) return std::nullopt;
  const auto reply = client->call("events.subscribe", {{"topics", kKept}, {"after", after}});
  if (!reply.result) return std::nullopt;
  return Subscription{*reply.result, [client]() -> std::optional<control::Event> {
                        try {
                          return client->event();
                        } catch (const std::exception&) {
                          return std::nullopt;
                        }
                      }};
} catch (const std::exception&) {
  return std::nullopt;
}

/// Follows the cell from its first event on, from daemon to daemon.
class Panel {
 public:
  using Connect = std::function<std::optional<Subscription>(std::uint64_t after)>;

  Panel(Connect connect, const std::atomic<bool>& over)
      : thread_{[this, connect = std::move(connect), &over] {
          while (!over) follow(connect);
        }} {}

  void wait() { thread_.join(); }
  const std::vector<std::uint64_t>& seen() const { return seen_; }
  /// Whether a notification said that this one may be missing.
  bool was_reported_missing(std::uint64_t seq) const {
    return std::ranges::any_of(missing_,
                               [&](const auto& range) { return range.first <= seq && seq <= range.second; });
  }

 private:
  void follow(const Connect& connect) {
    auto subscription = connect(seen_.empty() ? 0 : seen_.back());
    if (!subscription) return std::this_thread::sleep_for(20ms);
    for (const json::value& range : subscription->answer.at("missing").as_array())
      missing_.emplace_back(range.at("first").to_number<std::uint64_t>(),
                            range.at("last").to_number<std::uint64_t>());
    for (auto event = subscription->next(); event; event = subscription->next()) seen_.push_back(event->seq);
  }

  std::vector<std::uint64_t> seen_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> missing_;
  std::thread thread_;
};

class TwentyPanels : public testing::Test {
 protected:
  TwentyPanels()
      : cell_{{.speedup = kSpeedup,
               .cell = {{"  #tls:", "  tls:"},
                        {"  #  listen: 0.0.0.0:7211", "    listen: 127.0.0.1:0"},
                        {"  #  certificate:", "    certificate:"},
                        {"  #  key:", "    key:"}}}} {
    const Finished made =
        run_program("truepose", {"tls", "init", "--dir", cell_.folder() / "tls", "--host", "127.0.0.1"});
    if (made.exit_code != 0) throw std::runtime_error{made.err};
    start_daemon();
    for (int i = 0; i < 20; ++i) panels_.push_back(std::make_unique<Panel>(connection(i), over_));
  }
  ~TwentyPanels() override {
    over_ = true;
    cell_.daemon().send(SIGKILL);
    for (const auto& panel : panels_)
      if (waiting_) panel->wait();
  }

  void start_daemon() {
    cell_.start_daemon();
    const std::lock_guard lock{mutex_};
    ports_ = {cell_.control_port(), cell_.tls_port(), cell_.web_port()};
  }
  void end_daemon(int signal) {
    cell_.daemon().send(signal);
    cell_.daemon().wait();
  }
  /// All panels come from one address here, and only so many of one are let in at once.
  tools::RpcClient operator_panel() {
    std::optional<tools::RpcClient> panel;
    await("the operator's panel is let in", [&] {
      auto client = tools::RpcClient::connect(
          {"127.0.0.1:" + std::to_string(cell_.control_port()), cell_.token_file()});
      if (client) panel = *std::move(client);
      return panel.has_value();
    });
    return *std::move(panel);
  }
  /// Begins a campaign, in whose middle the daemon is ended; the next one continues with it to its end.
  void campaign_through(int signal) {
    tools::RpcClient before = operator_panel();
    before.call("events.subscribe", {{"topics", json::array{"measurement"}}});
    const auto begun = before.call("campaign.start", {{"identify_poses", 12}, {"validate_poses", 6}});
    ASSERT_TRUE(begun) << begun.error().message;
    for (int points = 0; points < 8; ++points) ASSERT_TRUE(before.next_event());
    end_daemon(signal);
    start_daemon();
    tools::RpcClient after = operator_panel();
    after.call("events.subscribe", {{"topics", json::array{"campaign"}}});
    const auto resumed = after.call("campaign.resume", {{"id", begun->at("id")}});
    ASSERT_TRUE(resumed) << resumed.error().message;
    for (auto event = after.next_event(); event; event = after.next_event()) {
      const json::value& phase = event->data.at("phase");
      ASSERT_TRUE(phase != "failed" && phase != "interrupted") << event->data;
      if (phase == "done") return;
    }
    FAIL() << "the daemon ended";
  }
  /// The number that the next event will have.
  std::uint64_t next_number() {
    return operator_panel().call("events.subscribe", {})->at("next").to_number<std::uint64_t>();
  }
  void end_panels() {
    over_ = true;
    end_daemon(SIGTERM);
    for (const auto& panel : panels_) panel->wait();
    waiting_ = false;
  }

  LiveCell cell_;
  std::vector<std::unique_ptr<Panel>> panels_;

 private:
  Panel::Connect connection(int number) {
    return [this, number](std::uint64_t after) {
      const Ports ports = now();
      const auto address = [&](std::uint16_t port) { return "127.0.0.1:" + std::to_string(port); };
      if (number % 3 == 0) return subscribe({address(ports.control), cell_.token_file()}, after);
      if (number % 3 == 1)
        return subscribe({address(ports.tls), cell_.token_file(), {.ca = cell_.folder() / "tls/ca.pem"}},
                         after);
      return subscribe(ports.web, token_, after);
    };
  }
  Ports now() {
    const std::lock_guard lock{mutex_};
    return ports_;
  }

  std::mutex mutex_;
  Ports ports_;
  const std::string token_ = first_line(text_of(cell_.token_file()));
  std::atomic<bool> over_ = false;
  bool waiting_ = true;
};

TEST_F(TwentyPanels, MissNothingAndSeeNothingTwiceWhileDaemonsComeAndGo) {
  const auto begin = std::chrono::steady_clock::now();
  const int rounds = all_trials() ? 8 : 1;
  for (int round = 0; round < rounds && !HasFatalFailure(); ++round)
    for (const int signal : {SIGTERM, SIGKILL, SIGTERM}) campaign_through(signal);
  const std::chrono::duration<double, std::ratio<3600>> lasted = std::chrono::steady_clock::now() - begin;
  const std::uint64_t next = next_number();
  end_panels();

  std::set<std::uint64_t> all;
  for (const auto& panel : panels_)
    for (const std::uint64_t seq : panel->seen())
      if (seq < next) all.insert(seq);
  EXPECT_GT(all.size(), static_cast<std::size_t>(rounds) * 3 * 18) << "a measurement each, at least";
  std::size_t reported_missing = 0;
  for (std::size_t i = 0; i < panels_.size(); ++i) {
    const std::vector<std::uint64_t>& seen = panels_[i]->seen();
    EXPECT_EQ(std::ranges::adjacent_find(seen, std::greater_equal{}), seen.end()) << "panel " << i;
    for (const std::uint64_t seq : all) {
      if (std::ranges::binary_search(seen, seq)) continue;
      ASSERT_TRUE(panels_[i]->was_reported_missing(seq)) << "panel " << i << " missed " << seq;
      ++reported_missing;
    }
  }
  std::printf(
      "%.1f h of the cell, %d ends of its daemon: %zu events to %zu panels; one was missing %zu times, and said to be\n",
      kSpeedup * lasted.count(), 3 * rounds, all.size(), panels_.size(), reported_missing);
}

}  // namespace
}  // namespace truepose
