#pragma once

#include <gtest/gtest.h>

#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/math/angles.hpp"
#include "drivers/clock.hpp"
#include "drivers/kuka/eki_robot.hpp"
#include "proto/eki/document_splitter.hpp"

namespace truepose::drivers {

/// The controller's end of one connection.
class Peer {
 public:
  explicit Peer(boost::asio::ip::tcp::socket socket) : socket_{std::move(socket)} {}

  boost::asio::awaitable<eki::ToController> read() {
    for (;;) {
      const auto document = splitter_.next();
      if (*document) {
        const auto message = eki::decode_to_controller(**document);
        if (!message) throw std::runtime_error(message.error());
        co_return *message;
      }
      std::array<char, 512> bytes;
      const std::size_t size =
          co_await socket_.async_read_some(boost::asio::buffer(bytes), boost::asio::use_awaitable);
      splitter_.feed({bytes.data(), size});
    }
  }

  boost::asio::awaitable<void> write(std::string text) {
    co_await boost::asio::async_write(socket_, boost::asio::buffer(text), boost::asio::use_awaitable);
  }

  void close() { socket_.close(); }

 private:
  boost::asio::ip::tcp::socket socket_;
  eki::DocumentSplitter splitter_;
};

using Script = std::function<boost::asio::awaitable<void>(std::shared_ptr<Peer>)>;

inline const eki::Hello kHello{1, "#KR210R2700_2 C4 FLR", "864213", 0, 0, "KSS 8.6.11"};

inline eki::State ready_state(std::int32_t id) {
  eki::State state;
  state.id = id;
  state.mode = eki::OperatingMode::Ext;
  state.override_percent = 40;
  state.program = eki::ProgramState::Active;
  state.drives_ready = state.no_emergency_stop = state.gate_closed = state.in_position = true;
  state.axes_rad[1] = -90 * kRadPerDeg;
  state.pose = {1765, 0, 1910, 0, 90, 0};
  return state;
}

inline std::string text(const eki::FromController& message) { return eki::encode(message); }

/// A controller with both channels on free ports. Each connection to CellLink plays the next script;
/// CellState answers every control with `state`, unless it has a script of its own.
class EkiRobot : public testing::Test {
 protected:
  void serve(std::vector<Script> motion, Script state = {}) {
    motion_scripts_ = std::move(motion);
    state_script_ = state ? std::move(state) : answer_with_state();
    boost::asio::co_spawn(context_, accept_motion(), boost::asio::detached);
    boost::asio::co_spawn(context_, accept_state(), boost::asio::detached);
  }

  /// Runs the body against the robot until it ends.
  void run(std::function<boost::asio::awaitable<void>(KukaEkiRobot&)> body) {
    KukaEkiRobot robot{
        context_.get_executor(),
        clock_,
        {"127.0.0.1", motion_acceptor_.local_endpoint().port(), state_acceptor_.local_endpoint().port(), 6,
         [this](recording::Kind kind, std::string_view bytes) { heard_.emplace_back(kind, bytes); }}};
    bool ended = false;
    boost::asio::co_spawn(context_, body(robot), [&](std::exception_ptr error) {
      ended = true;
      context_.stop();
      if (error) std::rethrow_exception(error);
    });
    context_.run_for(std::chrono::seconds{60});
    EXPECT_TRUE(ended);
    robot.disconnect();
  }

  /// A script for CellState. controls_ keeps what it hears.
  /// @param states  that answer a control
  Script answer_by(std::function<std::vector<eki::State>(const eki::Control&)> states) {
    return [this, states](std::shared_ptr<Peer> peer) -> boost::asio::awaitable<void> {
      for (;;) {
        const eki::ToController message = co_await peer->read();
        const auto& control = std::get<eki::Control>(message);
        controls_.push_back(control.op);
        for (const eki::State& state : states(control)) co_await peer->write(text(state));
      }
    };
  }
  Script answer_with_state() {
    return answer_by([this](const eki::Control& control) {
      eki::State state = state_;
      state.id = control.id;
      return std::vector{state};
    });
  }

  TimePoint soon() const { return clock_.now() + std::chrono::seconds{30}; }
  TimePoint very_soon() const { return clock_.now() + std::chrono::milliseconds{50}; }

  SteadyClock clock_;
  boost::asio::io_context context_;
  boost::asio::ip::tcp::acceptor motion_acceptor_{context_, {boost::asio::ip::address_v4::loopback(), 0}};
  boost::asio::ip::tcp::acceptor state_acceptor_{context_, {boost::asio::ip::address_v4::loopback(), 0}};
  eki::State state_ = ready_state(0);
  std::vector<eki::ControlOp> controls_;
  std::vector<std::pair<recording::Kind, std::string>> heard_;  ///< on CellLink

 private:
  boost::asio::awaitable<void> accept_motion() {
    for (const Script& script : motion_scripts_) {
      boost::asio::ip::tcp::socket socket =
          co_await motion_acceptor_.async_accept(boost::asio::use_awaitable);
      const auto peer = std::make_shared<Peer>(std::move(socket));
      connections_.push_back(peer);
      boost::asio::co_spawn(context_, script(peer), boost::asio::detached);
    }
  }

  boost::asio::awaitable<void> accept_state() {
    for (;;) {
      boost::asio::ip::tcp::socket socket = co_await state_acceptor_.async_accept(boost::asio::use_awaitable);
      const auto peer = std::make_shared<Peer>(std::move(socket));
      connections_.push_back(peer);
      boost::asio::co_spawn(context_, state_script_(peer), boost::asio::detached);
    }
  }

  std::vector<Script> motion_scripts_;
  Script state_script_;
  std::vector<std::shared_ptr<Peer>> connections_;  // open until the test closes them
};

inline JointVector target() {
  JointVector q{6};
  q << 0.1, -1.5, 1.4, 0.2, -0.3, 3;
  return q;
}

inline eki::Ack ack(const eki::Command& command, eki::AckState state, int error = 0) {
  return {command.id, state, error, command.axes_rad};
}

/// Greets and then answers every command with the states.
inline Script greet_and_answer(std::vector<eki::AckState> states, int error = 0,
                               std::vector<eki::Command>* seen = nullptr) {
  return [=](std::shared_ptr<Peer> peer) -> boost::asio::awaitable<void> {
    co_await peer->write(text(kHello));
    for (;;) {
      const eki::ToController message = co_await peer->read();
      const auto& command = std::get<eki::Command>(message);
      if (seen) seen->push_back(command);
      for (const eki::AckState state : states) co_await peer->write(text(ack(command, state, error)));
    }
  };
}

}  // namespace truepose::drivers
