#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "proto/eki/messages.hpp"

namespace truepose::sim {

/// A port that cannot be listened on. what() is the operator's line: which, why, and what to do.
class PortError : public std::runtime_error {
 public:
  PortError(const std::string& whose, std::uint16_t port, const boost::system::error_code& reason)
      : std::runtime_error{
            whose + " port " + std::to_string(port) + ": " + reason.message() +
            "; choose another, or see who holds it: ss -ltnp 'sport = :" + std::to_string(port) + "'"} {}
};

/// Who acts on what comes over the two EKI channels. Called on the server's executor.
class EkiListener {
 public:
  virtual ~EkiListener() = default;
  virtual void motion_connected() = 0;
  virtual void motion_lost() = 0;
  virtual void command(const eki::Command& command) = 0;
  virtual void control(const eki::Control& control) = 0;
};

struct EkiServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t motion_port = 0;  ///< CellLink; 0 picks a free one
  std::uint16_t state_port = 0;   ///< CellState
};

/// The two EKI channels of a simulated controller, TCP servers for one client each.
///
/// A second client is closed at once. A document that cannot be understood is named on standard error and
/// skipped, as the controller shows a message and goes on.
class EkiServer {
 public:
  /// Listens at once. Throws PortError.
  /// @param executor  one thread or a strand; the server is destroyed there, or when that no longer runs
  /// @param listener  outlives the server
  EkiServer(boost::asio::any_io_executor executor, const EkiServerOptions& options, EkiListener& listener);
  ~EkiServer();

  std::uint16_t motion_port() const;
  std::uint16_t state_port() const;

  /// Sends where a client is connected; otherwise the document is lost, as on the controller.
  void send_motion(const eki::FromController& message);
  void send_state(const eki::FromController& message);

  /// Fault: both channels are cut, and closed to everybody for this long.
  void drop(std::chrono::milliseconds duration);

 private:
  class Channel;
  std::shared_ptr<Channel> motion_, state_;
};

}  // namespace truepose::sim
