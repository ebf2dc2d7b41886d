#include "proto/emscon/packet_splitter.hpp"

namespace truepose::emscon {

void PacketSplitter::push(std::span<const std::uint8_t> bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::expected<std::optional<std::span<const std::uint8_t>>, EmsconError> PacketSplitter::next() {
  const auto rest = std::span<const std::uint8_t>{buffer_}.subspan(begin_);
  if (rest.size() < 4) return std::nullopt;
  const std::uint32_t size = std::uint32_t{rest[0]} | std::uint32_t{rest[1]} << 8 |
                             std::uint32_t{rest[2]} << 16 | std::uint32_t{rest[3]} << 24;
  if (size < kHeadSize) return std::unexpected(EmsconError{"packet size below 8", 0});
  if (size > kMaxPacketSize) return std::unexpected(EmsconError{"packet size above 64 KiB", 0});
  if (rest.size() < size) return std::nullopt;
  begin_ += size;
  return rest.first(size);
}

}  // namespace truepose::emscon
