#pragma once

#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "drivers/clock.hpp"
#include "proto/bridge/messages.hpp"
#include "proto/control/line_splitter.hpp"
#include "tests/drivers/memory_network.hpp"

namespace truepose::drivers {

/// A bridge whose every answer a test may script. Unscripted, it is initialised, has locked what it was aimed
/// at, and measures at once.
class FakeBridge {
 public:
  static constexpr std::uint16_t kPort = 4;
  using Script = std::function<void(std::int64_t id, const bridge::Request& request)>;

  FakeBridge(boost::asio::io_context& io, MemoryNetwork& network, Clock& clock) : io_{io}, clock_{clock} {
    network.listen(kPort, [this](std::shared_ptr<MemoryStream> client) { return serve(std::move(client)); });
  }

  /// Called instead of the usual answer to requests of this name, until another script is set.
  void script(const std::string& name, Script script) { scripts_[name] = std::move(script); }
  void unscript(const std::string& name) { scripts_.erase(name); }

  template <class Answer = bridge::Done>
  void answer(std::int64_t id, const Answer& answer = {}) {
    send(bridge::encode_answer(id, answer));
  }
  void refuse(std::int64_t id, bridge::ErrorCode code, std::string text = "because") {
    send(bridge::encode_refusal(id, bridge::Refusal::of(code, std::move(text))));
  }
  void event(bridge::EventKind kind) { send(bridge::encode(bridge::Event::of(kind))); }
  void send(const std::string& line) { send_bytes(line + "\n"); }
  void send_bytes(std::string bytes) {
    if (client_) boost::asio::co_spawn(io_, write(client_, std::move(bytes)), boost::asio::detached);
  }
  /// Does it so much later.
  void later(Duration after, std::function<void()> act) {
    boost::asio::co_spawn(io_, act_later(clock_.now() + after, std::move(act)), boost::asio::detached);
  }
  void hang_up() {
    if (client_) client_->close();
  }

  /// The usual answer.
  void answer_as_usual(std::int64_t id, const bridge::Request& request) {
    std::visit([&](const auto& kind) { usual(id, kind); }, request);
  }

  int connections = 0;
  std::vector<std::string> asked;  ///< names of requests, in their order
  std::vector<bridge::Request> requests;
  bridge::Greeting greeting{
      .bridge = "fake", .model = "T3", .serial = "4711", .firmware = "2.8", .rehearses = {}};
  bridge::Status status{.state = bridge::State::Ready,
                        .why = "",
                        .initialised = true,
                        .locked = true,
                        .face = 1,
                        .reflector = "SMR 1.5",
                        .reflectors = {"SMR 1.5", "SMR 0.5"}};
  bridge::Measured result{.p_W_mm = {1000, 2000, -500},
                          .std_mm = Eigen::Vector3d{0.005, 0.006, 0.007},
                          .covariance_mm2 = {},
                          .averaged = std::chrono::seconds{60},
                          .air = {21, 1000, 40}};

 private:
  void usual(std::int64_t id, const bridge::Hello&) { answer(id, greeting); }
  void usual(std::int64_t id, const bridge::GetStatus&) { answer(id, status); }
  void usual(std::int64_t id, const bridge::Initialise&) {
    status.initialised = true;
    answer(id);
  }
  void usual(std::int64_t id, const bridge::SetReflector& request) {
    status.reflector = request.name;
    answer(id);
  }
  void usual(std::int64_t id, const bridge::DoMeasure&) { answer(id, result); }
  void usual(std::int64_t id, const bridge::SetFace& request) {
    status.face = request.face;
    answer(id);
  }
  void usual(std::int64_t id, const auto&) { answer(id); }

  static boost::asio::awaitable<void> write(std::shared_ptr<MemoryStream> client, std::string bytes) {
    co_await client->write(bytes);
  }
  boost::asio::awaitable<void> act_later(TimePoint when, std::function<void()> act) {
    co_await clock_.sleep_until(when);
    act();
  }

  boost::asio::awaitable<void> serve(std::shared_ptr<MemoryStream> client) {
    client_ = client;
    ++connections;
    control::LineSplitter lines{bridge::kMaxLine};
    std::array<char, 512> bytes;
    for (;;) {
      const auto [error, size] = co_await client->read(bytes);
      if (error) break;
      lines.push({bytes.data(), size});
      while (const auto line = lines.next()) handle(bridge::decode_request(*line).value());
    }
    if (client_ == client) client_.reset();
  }

  void handle(const bridge::Asked& made) {
    const std::string name =
        std::visit([]<class Kind>(const Kind&) { return std::string{Kind::kName}; }, made.request);
    asked.push_back(name);
    requests.push_back(made.request);
    const auto script = scripts_.find(name);
    if (script == scripts_.end()) return answer_as_usual(made.id, made.request);
    const Script now = script->second;  // it may replace itself
    now(made.id, made.request);
  }

  boost::asio::io_context& io_;
  Clock& clock_;
  std::map<std::string, Script> scripts_;
  std::shared_ptr<MemoryStream> client_;
};

}  // namespace truepose::drivers
