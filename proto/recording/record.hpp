#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "core/named.hpp"
#include "proto/recording/ip_packet.hpp"

namespace truepose::recording {

/// Each is an interface of the recording; of Daemon are its own notes.
enum class Wire : std::uint8_t { Rsi, EkiLink, EkiState, Tracker, Daemon };
inline constexpr std::array kWires{Named{"rsi", Wire::Rsi}, Named{"eki-link", Wire::EkiLink},
                                   Named{"eki-state", Wire::EkiState}, Named{"tracker", Wire::Tracker},
                                   Named{"daemon", Wire::Daemon}};

enum class Kind : std::uint8_t {
  Received,    ///< bytes that came from the device
  Sent,        ///< bytes to it; of RSI after each datagram, empty where it was not answered
  Connected,   ///< the bytes are both ends, "LOCAL REMOTE", as text() of an Endpoint
  Closed,      ///< by either side
  Failed,      ///< an operation on the wire, by the error in the text
  Started,     ///< of RSI: the cycle began, with the memory in the bytes, or with none
  Checkpoint,  ///< of RSI: the memory in the bytes, after the reply before it, while nothing changes
  Commands,    ///< of RSI: what stood when the next datagram was answered; Commands as text
  Fault,       ///< of the daemon: the text of one that began
  Dropped,     ///< so many records for which there was no room
};
inline constexpr std::array kKinds{Named{"received", Kind::Received},     Named{"sent", Kind::Sent},
                                   Named{"connected", Kind::Connected},   Named{"closed", Kind::Closed},
                                   Named{"failed", Kind::Failed},         Named{"started", Kind::Started},
                                   Named{"checkpoint", Kind::Checkpoint}, Named{"commands", Kind::Commands},
                                   Named{"fault", Kind::Fault},           Named{"dropped", Kind::Dropped}};

/// The longest that a record has: a UDP datagram, or what was read of a TCP stream at once.
inline constexpr std::size_t kMostRecordBytes = 64 * 1024;

/// Something that happened on a wire.
struct Record {
  std::int64_t time_ns = 0;  ///< on the steady clock of the machine that recorded
  Wire wire = Wire::Rsi;
  Kind kind = Kind::Received;
  std::optional<Endpoint> peer;  ///< of RSI's datagrams
  std::string bytes;             ///< as they were on the wire

  bool operator==(const Record&) const = default;
};

}  // namespace truepose::recording
