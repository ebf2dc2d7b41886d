#pragma once

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "proto/emscon/packet_splitter.hpp"
#include "proto/emscon/packets.hpp"

namespace truepose::drivers {

/// A tracker whose every answer a test may script. Unscripted, it is initialised, locked and keeps what is
/// written to it.
class FakeTracker {
 public:
  using Bytes = std::vector<std::uint8_t>;
  using Script = std::function<void()>;

  explicit FakeTracker(boost::asio::io_context& io)
      : acceptor_{io, {boost::asio::ip::address_v4::loopback(), 0}} {
    boost::asio::co_spawn(io, serve(), boost::asio::detached);
  }

  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

  /// Called instead of the usual answer to this command, until another script is set.
  void script(emscon::CommandCode code, Script script) { scripts_[code] = std::move(script); }
  /// Back to the usual answer.
  void unscript(emscon::CommandCode code) { scripts_.erase(code); }

  void send(const auto& packet) { send_bytes(emscon::encode(packet)); }
  void answer(emscon::CommandCode code, std::int32_t status = 0, emscon::Body body = {}) {
    send(emscon::Answer{code, status, std::move(body)});
  }
  void event(emscon::SystemEvent event) { send(emscon::SystemStatusChange{event}); }
  void send_bytes(const Bytes& bytes) { outgoing_.insert(outgoing_.end(), bytes.begin(), bytes.end()); }
  /// Ends the connection after what was sent so far.
  void hang_up() { hang_up_ = true; }

  /// The usual answer to a command.
  void answer_as_usual(const emscon::Command& command) {
    using enum emscon::CommandCode;
    const emscon::CommandCode code = command.code;
    if (command.body.index() != 0 && getter_of(code)) {
      kept[*getter_of(code)] = command.body;
      answer(code);
    } else if (const auto found = kept.find(code); found != kept.end()) {
      answer(code, 0, found->second);
    } else if (code == GetReflectors) {
      answer(code, 0, emscon::ReflectorEntry{2, 4, emscon::TargetKind::CornerCube, 19.05, "CCR-1.5in"});
      answer(code, 0, emscon::ReflectorEntry{2, 7, emscon::TargetKind::CornerCube, 6.35, "RRR-0.5in"});
    } else if (code == StartMeasurement) {
      answer(code);
      send(result);
    } else {
      answer(code);
    }
  }

  /// What it sends for what has come, where there is no socket.
  Bytes answers_to(emscon::PacketSplitter& received) {
    handle_all(received);
    return std::exchange(outgoing_, {});
  }

  bool greedy = true;  ///< sends what it has in one piece; otherwise byte by byte
  int connections = 0;
  std::vector<emscon::CommandCode> commands;  ///< received, in order
  emscon::Command latest;
  std::map<emscon::CommandCode, emscon::Body> kept{
      {emscon::CommandCode::GetSystemStatus,
       emscon::SystemStatus{.processor = emscon::ProcessorStatus::Initialized,
                            .laser = emscon::LaserStatus::Ready,
                            .server_version = {3, 8, 900},
                            .weather = emscon::WeatherMonitor::ReadOnly,
                            .serial_number = 42}},
      {emscon::CommandCode::GetMeasurementStatusInfo,
       emscon::MeasurementStatusInfo{0, emscon::kReflectorFoundBit | emscon::kInitializedBit}},
      {emscon::CommandCode::GetSearchParams, emscon::SearchParams{}},
      {emscon::CommandCode::GetTrackerInfo, emscon::TrackerInfo{70, "AT401"}},
  };
  emscon::SingleMeasResult result{
      .v = {1000, 2000, -500}, .std = {0.005, 0.006, 0.007}, .environment = {21, 1000, 40}};

 private:
  static std::optional<emscon::CommandCode> getter_of(emscon::CommandCode code) {
    using enum emscon::CommandCode;
    switch (code) {
      case SetUnits:
      case SetStationOrientationParams:
      case SetTransformationParams:
      case SetMeasurementMode:
      case SetCoordinateSystemType:
      case SetStationaryModeParams:
      case SetReflector:
      case SetSearchParams:
      case SetSystemSettings:
      case SetEnvironmentParams:
      case SetRefractionParams:
        return emscon::CommandCode{std::to_underlying(code) + 1};
      default:
        return std::nullopt;
    }
  }

  boost::asio::awaitable<void> serve() {
    constexpr auto kToResult = boost::asio::as_tuple(boost::asio::use_awaitable);
    for (;;) {
      auto [accept_error, socket] = co_await acceptor_.async_accept(kToResult);
      if (accept_error) co_return;
      socket.set_option(boost::asio::ip::tcp::no_delay{true});
      ++connections;
      hang_up_ = false;
      outgoing_.clear();
      emscon::PacketSplitter splitter;
      std::array<std::uint8_t, 4096> received{};
      while (!hang_up_) {
        auto [error, size] = co_await socket.async_read_some(boost::asio::buffer(received), kToResult);
        if (error) break;
        splitter.push({received.data(), size});
        handle_all(splitter);
        const Bytes bytes = std::exchange(outgoing_, {});
        const std::size_t portion = greedy ? std::max<std::size_t>(bytes.size(), 1) : 1;
        for (std::size_t at = 0; at < bytes.size(); at += portion) {
          const auto part = boost::asio::buffer(bytes.data() + at, std::min(portion, bytes.size() - at));
          co_await boost::asio::async_write(socket, part, kToResult);
        }
      }
    }
  }

  void handle_all(emscon::PacketSplitter& splitter) {
    for (;;) {
      const auto bytes = splitter.next().value();
      if (!bytes) return;
      const auto packet = emscon::decode_client_packet(*bytes).value();
      const auto& command = std::get<emscon::Command>(packet);
      commands.push_back(command.code);
      latest = command;
      const auto script = scripts_.find(command.code);
      if (script == scripts_.end()) {
        answer_as_usual(command);
      } else {
        const Script now = script->second;  // it may replace itself
        now();
      }
    }
  }

  boost::asio::ip::tcp::acceptor acceptor_;
  std::map<emscon::CommandCode, Script> scripts_;
  Bytes outgoing_;
  bool hang_up_ = false;
};

}  // namespace truepose::drivers
