#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/parse.hpp>
#include <deque>
#include <filesystem>
#include <fstream>
#include <future>
#include <map>
#include <thread>

#include "daemon/control/control_server.hpp"
#include "proto/control/access.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/request.hpp"
#include "tests/await.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon::test {

namespace asio = boost::asio;
namespace fs = std::filesystem;
namespace json = boost::json;
using asio::ip::tcp;
using control::Event;
using control::Reply;
using namespace std::chrono_literals;

inline constexpr std::string_view kToken = "0123456789abcdef0123456789abcdef";

/// Time that passes on request. Used on the event loop's thread.
class ManualClock : public drivers::Clock {
 public:
  drivers::TimePoint now() const override { return now_; }
  asio::awaitable<void> sleep_until(drivers::TimePoint when) override {
    const auto executor = co_await asio::this_coro::executor;
    const auto timer = std::make_shared<asio::steady_timer>(executor, asio::steady_timer::time_point::max());
    const auto place = sleepers_.emplace(when, timer);
    if (now_ < when) {
      const auto waited = co_await timer->async_wait(asio::as_tuple(asio::use_awaitable));
      static_cast<void>(waited);
    }
    sleepers_.erase(place);
    if (now_ < when) throw boost::system::system_error(asio::error::operation_aborted);
  }
  void advance(drivers::Duration time) {
    now_ += time;
    for (const auto& [when, timer] : sleepers_)
      if (when <= now_) timer->cancel();
  }
  /// How many wait for a moment that is no farther away.
  std::size_t sleepers_within(drivers::Duration time) const {
    const auto end = sleepers_.upper_bound(now_ + time);
    return static_cast<std::size_t>(std::distance(sleepers_.begin(), end));
  }

 private:
  drivers::TimePoint now_{1h};
  std::multimap<drivers::TimePoint, std::shared_ptr<asio::steady_timer>> sleepers_;
};

/// A cell with one method of each temper.
class FakeCell : public CellService {
 public:
  std::vector<std::string> methods() const override {
    return {"cell.status", "campaign.start", "model.get", "report.get"};
  }
  asio::awaitable<std::expected<json::value, control::RpcError>> call(std::string method, json::object,
                                                                      std::string by) override {
    if (method == "model.get") throw std::runtime_error("no such luck");
    if (method == "report.get") co_return json::string(100'000, 'x');
    if (method == "campaign.start") {
      asio::steady_timer never{co_await asio::this_coro::executor, asio::steady_timer::time_point::max()};
      started.set_value();
      release = [&never] { never.cancel(); };
      const auto waited = co_await never.async_wait(asio::as_tuple(asio::use_awaitable));
      static_cast<void>(waited);
    }
    json::object result{{"method", method}, {"by", by}};
    co_return result;
  }
  asio::awaitable<std::expected<json::value, control::RpcError>> pause(std::string, std::string) override {
    co_return json::object{};
  }
  std::string doing() const override { return doing_; }
  void set_doing(std::string doing) { doing_ = std::move(doing); }

  std::promise<void> started;     ///< campaign.start is under way
  std::function<void()> release;  ///< ends it

 private:
  std::string doing_ = "nothing";
};

/// What an earlier daemon has kept. Used by the worker's thread once the server runs.
struct MemoryArchive final : EventArchive {
  StoreResult<void> keep_events(const EventBatch&) override { return {}; }
  StoreResult<EventPage> events(const std::set<control::Topic>& topics, std::uint64_t first,
                                std::uint64_t end) override {
    if (broken) return std::unexpected(StoreError{"cell.db: disk I/O error"});
    EventPage page{.events = {}, .next = end};
    for (const KeptEvent& event : kept) {
      if (event.seq < first || event.seq >= end) continue;
      // Two at a time, so that there are several parts.
      if (page.events.size() == 2) return page;
      if (topics.contains(event.topic)) page.events.push_back(event);
      page.next = event.seq + 1;
    }
    page.next = end;
    return page;
  }
  StoreResult<std::vector<EventGap>> event_gaps(std::uint64_t first, std::uint64_t end) override {
    std::vector<EventGap> found;
    for (const EventGap& gap : gaps)
      if (gap.last >= first && gap.first < end) found.push_back(gap);
    return found;
  }
  StoreResult<bool> prune_events(const std::string&) override { return false; }

  std::vector<KeptEvent> kept{};
  std::vector<EventGap> gaps{{1, 999, "not kept then"}};
  bool broken = false;
};

/// A client that blocks, whatever carries its lines.
class ProtocolClient {
 public:
  virtual ~ProtocolClient() = default;
  virtual void send(std::string_view bytes) = 0;
  /// The next line; empty when the server closed.
  virtual std::string any_line() = 0;

  /// The next line but the greeting, which comes before all others.
  std::string line() {
    std::string line = any_line();
    if (!line.starts_with(R"({"jsonrpc":"2.0","method":"greeting")")) return line;
    greeting_ = std::move(line);
    return any_line();
  }
  /// What came before all else.
  json::value greeting() {
    if (greeting_.empty()) greeting_ = any_line();
    return json::parse(greeting_);
  }
  /// The next reply. Notifications that come before it are kept for notification().
  Reply reply() {
    auto said = control::decode_server_line(line()).value();
    for (; std::holds_alternative<control::Notification>(said);
         said = control::decode_server_line(line()).value())
      notifications_.push_back(std::get<control::Notification>(std::move(said)));
    return std::get<Reply>(std::move(said));
  }
  Event event() { return std::get<Event>(control::decode_server_line(line()).value()); }
  control::Notification notification() {
    if (notifications_.empty())
      return std::get<control::Notification>(control::decode_server_line(line()).value());
    control::Notification first = std::move(notifications_.front());
    notifications_.pop_front();
    return first;
  }
  bool closed() { return line().empty(); }

  Reply call(std::string_view method, const json::object& params = {}) {
    send(control::encode_request(++id_, method, params));
    Reply answer = reply();
    EXPECT_EQ(answer.id, control::Id{id_});
    return answer;
  }
  Reply hello(std::string_view token = kToken) {
    return call("session.hello", {{"protocol", 1}, {"token", std::string{token}}});
  }
  void send_hello(std::string_view token) {
    send(control::encode_request(++id_, "session.hello", {{"protocol", 1}, {"token", std::string{token}}}));
  }
  /// Code of the error of a call; 0 if it succeeded.
  int code(std::string_view method, const json::object& params = {}) { return code_of(call(method, params)); }
  static int code_of(const Reply& reply) {
    return reply.result ? 0 : static_cast<int>(reply.result.error().code);
  }

 private:
  std::string greeting_;
  std::deque<control::Notification> notifications_;
  std::int64_t id_ = 0;
};

/// Over TCP or a Unix socket; waits for at most the socket's timeout.
class Client : public ProtocolClient {
 public:
  explicit Client(std::uint16_t port, int receive_buffer = 0) {
    socket_.open(asio::generic::stream_protocol{tcp::v4()});
    if (receive_buffer > 0) socket_.set_option(tcp::socket::receive_buffer_size{receive_buffer});
    const timeval limit{.tv_sec = 30, .tv_usec = 0};
    ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    socket_.connect(tcp::endpoint{asio::ip::address_v4::loopback(), port});
  }
  explicit Client(const fs::path& socket) {
    socket_.connect(asio::local::stream_protocol::endpoint{socket.string()});
  }
  void send(std::string_view bytes) override {
    boost::system::error_code gone;
    asio::write(socket_, asio::buffer(bytes), gone);
  }
  void end_of_input() { socket_.shutdown(tcp::socket::shutdown_send); }
  std::string any_line() override {
    boost::system::error_code end;
    const std::size_t size = asio::read_until(socket_, asio::dynamic_buffer(buffer_), '\n', end);
    if (end) return {};
    std::string line = buffer_.substr(0, size - 1);
    buffer_.erase(0, size);
    return line;
  }
  /// Nothing but the greeting.
  bool nothing_came() {
    greeting();
    return buffer_.empty() && socket_.available() == 0;
  }

 private:
  asio::io_context context_;
  asio::generic::stream_protocol::socket socket_{context_};
  std::string buffer_;
};

class ControlServerTest : public testing::Test {
 protected:
  ControlServerTest() { write_token(kToken); }
  ~ControlServerTest() override {
    on_loop([this] { server_.reset(); });
    work_.reset();
    thread_.join();
  }

  void write_token(std::string_view token) {
    std::ofstream{token_file()} << token << '\n';
    fs::permissions(token_file(), fs::perms::owner_read | fs::perms::owner_write);
  }
  fs::path token_file() const { return folder_.path() / "token"; }
  fs::path access_file() const { return folder_.path() / "access"; }
  fs::path audit_file() const { return folder_.path() / "audit"; }
  void write_access(const control::AccessEntries& access) {
    const fs::path new_file = folder_.write("access.new", control::access_text(access));
    fs::permissions(new_file, fs::perms::owner_read | fs::perms::owner_write);
    fs::rename(new_file, access_file());
  }

  /// Runs something on the event loop's thread and waits for it.
  void on_loop(const std::function<void()>& task) {
    std::promise<void> done;
    asio::post(io_, [&] {
      task();
      done.set_value();
    });
    done.get_future().wait();
  }
  fs::path socket() const { return folder_.path() / "control.sock"; }

  /// @return why it did not start; no text where it did
  drivers::StartFailure try_start(const config::Endpoint& endpoint, const ControlLimits& limits = {},
                                  bool with_socket = false) {
    drivers::StartFailure failure{""};
    on_loop([&] {
      auto server =
          ControlServer::start(io_.get_executor(),
                               {clock_, [this] { return wall_; }, *served_, events_,
                                [this](const std::string& text) {
                                  warnings_ += text + "\n";
                                  if (text.find("too slowly") != std::string::npos) too_slow_.set_value();
                                },
                                worker_, with_socket ? socket() : fs::path{}, access_file(), audit_file()},
                               {endpoint, token_file(), tls_}, "cell 1", limits);
      if (server) server_ = std::move(*server);
      if (!server) failure = server.error();
    });
    return failure;
  }
  std::uint16_t serve(const ControlLimits& limits = {}) {
    EXPECT_EQ(try_start({"127.0.0.1", 0}, limits, true).text, "");
    on_loop([this] { server_->serve(); });
    return server_->port();
  }
  /// Until so many sleep for having guessed, or being in company of who did.
  void wait_for_hellos(std::size_t count) {
    std::size_t late = 0;
    await(std::to_string(count) + " are answered late", [&] {
      on_loop([&] { late = clock_.sleepers_within(1s); });
      return late >= count;
    });
  }
  /// Lets time pass until no more than so many sessions are open.
  /// @param meanwhile  done each second. @return how long it took
  drivers::Duration pass_until_open(
      std::size_t sessions, const std::function<void()>& meanwhile = [] {}) {
    for (auto passed = 0s; passed < 300s; passed += 1s) {
      std::size_t open = 0;
      on_loop([&] { open = server_->load().sessions; });
      if (open <= sessions) return passed;
      advance(1s);
      meanwhile();
    }
    ADD_FAILURE() << "more than " << sessions << " sessions stay open";
    return {};
  }
  void advance(drivers::Duration time) {
    on_loop([&] { clock_.advance(time); });
  }

  TempFolder folder_;
  MemoryArchive archive_;
  EventBus events_{{.first = 1000, .end = 1'000'000, .request_more = {}},
                   [] { return std::chrono::system_clock::time_point{}; },
                   &archive_};
  ManualClock clock_;
  std::chrono::system_clock::time_point wall_{};
  std::optional<config::TlsConfig> tls_;
  std::string warnings_;  ///< of the event loop's thread
  FakeCell cell_;
  CellService* served_ = &cell_;
  std::promise<void> too_slow_;
  Worker worker_;
  asio::io_context io_;
  asio::executor_work_guard<asio::io_context::executor_type> work_{io_.get_executor()};
  std::unique_ptr<ControlServer> server_;
  std::thread thread_{[this] { io_.run(); }};
};

}  // namespace truepose::daemon::test
