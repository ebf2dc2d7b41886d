#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/tracker_wire.hpp"
#include "proto/emscon/packet_splitter.hpp"
#include "proto/emscon/packets.hpp"

namespace truepose::drivers {

/// The fault that a refused command's status stands for, with the status in words.
TrackerError refusal(std::string_view what, std::int32_t status);

/// Packets over one TCP connection. After Disconnected and Protocol it is closed.
class EmsconConnection {
 public:
  /// @param clock    outlives it
  /// @param observe  sees every packet that comes in, also the ones that no call waits for
  EmsconConnection(std::unique_ptr<net::Stream> stream, Clock& clock,
                   std::function<void(const emscon::TrackerPacket&)> observe, WireTap tap);

  TrackerTask<void> open(std::string host, std::uint16_t port);
  bool is_open() const { return wire_.is_open(); }
  void close() noexcept;

  TrackerTask<void> send(emscon::Command command);
  TrackerTask<emscon::TrackerPacket> receive();

  /// Sends a command and waits for the packet that answers it, be it a refusal; whatever else comes is only
  /// observed. An answer names its command by code alone: when this is cancelled before it came, or it does
  /// not come in the time that this command takes a tracker, the connection is closed, lest the answer is
  /// taken for that of a later command.
  TrackerTask<emscon::Answer> call(emscon::Command command);
  /// The same, a refusal turned into an error.
  /// @param what  begins its sentence: "the tracker refuses its units"
  TrackerTask<emscon::Answer> accepted(emscon::Command command, std::string_view what);
  /// The same for a command without a body.
  TrackerTask<emscon::Answer> ask(emscon::CommandCode code, std::string_view what);

 private:
  TrackerTask<emscon::Answer> answer_to(emscon::Command command);

  TrackerWire wire_;
  std::function<void(const emscon::TrackerPacket&)> observe_;
  emscon::PacketSplitter splitter_;
};

}  // namespace truepose::drivers
