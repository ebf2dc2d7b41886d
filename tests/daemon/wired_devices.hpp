#pragma once

#include <map>
#include <memory>
#include <optional>

#include "daemon/threads/signal.hpp"
#include "drivers/mock/mock_cell.hpp"
#include "proto/eki/document_splitter.hpp"
#include "proto/eki/messages.hpp"
#include "proto/emscon/packet_splitter.hpp"
#include "tests/drivers/bridge/fake_bridge.hpp"
#include "tests/drivers/leica/fake_tracker.hpp"
#include "tests/drivers/memory_network.hpp"

namespace truepose::daemon {

/// The controller's programs of config/kuka, as far as a campaign needs them, around the mock cell's arm.
class WiredController {
 public:
  static constexpr std::uint16_t kMotion = 1, kState = 2;
  WiredController(drivers::MemoryNetwork& network, drivers::MockCell& cell);

  int motions = 0;  ///< begun

 private:
  using Client = std::shared_ptr<drivers::MemoryStream>;
  boost::asio::awaitable<void> serve_motion(Client client);
  boost::asio::awaitable<void> serve_state(Client client);
  boost::asio::awaitable<void> carry_out(Client client, eki::Command command);
  boost::asio::awaitable<void> acknowledge(Client client, eki::AckState state, eki::AckError error);
  eki::State state_for(const eki::Control& control) const;

  drivers::MockCell& cell_;
  bool serving_ = false;  ///< the program takes the next client once it has seen the last one go
  Signal served_;
  eki::Ack last_;
  bool stopped_ = false;
  int stops_ = 0;
};

/// A bridge to a tracker that sees the mock cell's reflector.
class WiredBridge {
 public:
  static constexpr std::uint16_t kPort = drivers::FakeBridge::kPort;
  WiredBridge(boost::asio::io_context& io, drivers::MemoryNetwork& network, drivers::MockCell& cell);

 private:
  void measure(std::int64_t id, std::chrono::milliseconds time);

  drivers::MockCell& cell_;
  drivers::FakeBridge protocol_;
};

/// An emScon tracker that sees the mock cell's reflector.
class WiredTracker {
 public:
  static constexpr std::uint16_t kPort = 3;
  WiredTracker(boost::asio::io_context& io, drivers::MemoryNetwork& network, drivers::MockCell& cell);

 private:
  boost::asio::awaitable<void> serve(std::shared_ptr<drivers::MemoryStream> client);

  drivers::MockCell& cell_;
  drivers::FakeTracker protocol_;
  bool asked_to_measure_ = false;
};

}  // namespace truepose::daemon
