#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <vector>

#include "proto/emscon/emscon_error.hpp"

namespace truepose::emscon {

/// Cuts a TCP byte stream into packets by their leading size.
///
/// The protocol has no other mark to find a packet by, so after an error the stream is lost: close the
/// connection.
class PacketSplitter {
 public:
  static constexpr std::size_t kHeadSize = 8;
  static constexpr std::size_t kMaxPacketSize = 64 * 1024;

  /// Adds received bytes, in any portions.
  void push(std::span<const std::uint8_t> bytes);

  /// The next whole packet, head included; nothing until more bytes come. The view is valid until the next
  /// push(). Errors: a size below 8 or above 64 KiB; every later call then gives the same error.
  std::expected<std::optional<std::span<const std::uint8_t>>, EmsconError> next();

 private:
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;  ///< of the first byte not yet handed out
};

}  // namespace truepose::emscon
