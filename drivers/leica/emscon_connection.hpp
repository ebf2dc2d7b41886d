#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/byte_stream.hpp"
#include "drivers/tracker.hpp"
#include "drivers/wire_tap.hpp"
#include "proto/emscon/packet_splitter.hpp"
#include "proto/emscon/packets.hpp"

namespace truepose::drivers {

template <class T>
using TrackerResult = std::expected<T, TrackerError>;
template <class T>
using TrackerTask = boost::asio::awaitable<TrackerResult<T>>;

/// The fault that a refused command's status stands for, with the status in words.
TrackerError refusal(std::string_view what, std::int32_t status);

/// Packets over one TCP connection. After Disconnected and Protocol it is closed.
class EmsconConnection {
 public:
  /// @param clock    outlives it
  /// @param observe  sees every packet that comes in, also the ones nobody waits for
  EmsconConnection(std::unique_ptr<ByteStream> stream, Clock& clock,
                   std::function<void(const emscon::TrackerPacket&)> observe, WireTap tap);

  TrackerTask<void> open(std::string host, std::uint16_t port);
  bool is_open() const { return stream_->is_open(); }
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
  TrackerError lost(std::string_view why);
  TrackerTask<emscon::Answer> answer_to(emscon::Command command);

  std::unique_ptr<ByteStream> stream_;
  Clock& clock_;
  std::function<void(const emscon::TrackerPacket&)> observe_;
  WireTap tap_;
  emscon::PacketSplitter splitter_;
  std::array<char, 4096> received_{};
};

}  // namespace truepose::drivers
