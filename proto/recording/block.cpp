#include "proto/recording/block.hpp"

#include <utility>

#include "proto/recording/difference.hpp"

namespace truepose::recording {
namespace {

constexpr unsigned kWireBits = 3;
constexpr unsigned kKindBits = 4;
constexpr unsigned kHasPeer = 1U << (kWireBits + kKindBits);  // another one than the record before
static_assert(kWires.size() <= 1U << kWireBits && kKinds.size() <= 1U << kKindBits);

unsigned head_of(const Record& record, const std::optional<Peer>& before) {
  const bool other_peer = record.peer && record.peer != before;
  return std::to_underlying(record.wire) | unsigned{std::to_underlying(record.kind)} << kWireBits |
         (other_peer ? kHasPeer : 0);
}

// Unsigned inside, where a result that is too large is no undefined behaviour.

std::int64_t sum(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}
std::int64_t difference(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

/// Datagrams alone have a sender: what is said of it holds for the next ones.
bool has_peer(Wire wire, Kind kind) { return wire == Wire::Rsi && kind == Kind::Received; }

}  // namespace

bool BlockWriter::append(const Record& record) {
  record_.clear();
  const unsigned head = head_of(record, before_.peer);
  append_number(record_, head);
  append_signed(record_, difference(record.time_ns, before_.time_ns));
  if (head & kHasPeer) {
    append_number(record_, record.peer->address);
    append_number(record_, record.peer->port);
  }
  std::string& before = before_.bytes[{record.wire, record.kind}];
  std::string changes;
  append_difference(changes, before, record.bytes);
  append_number(record_, changes.size());
  record_ += changes;
  if (bytes_.size() + record_.size() > kMostBlockBytes) return false;
  bytes_ += record_;
  if (!record.bytes.empty()) before = record.bytes;
  before_.time_ns = record.time_ns;
  if (record.peer) before_.peer = record.peer;
  return true;
}

void BlockWriter::clear() {
  bytes_.clear();
  before_ = {};
}

std::expected<std::optional<Record>, std::string> BlockReader::next() {
  if (rest_.empty()) return std::nullopt;
  std::optional<Record> record = take();
  if (!record) return std::unexpected("a record that cannot be read");
  return record;
}

std::optional<Record> BlockReader::take() {
  const auto head = take_number(rest_);
  const auto time = head ? take_signed(rest_) : std::nullopt;
  if (!time) return std::nullopt;
  const std::uint64_t wire = *head & ((1U << kWireBits) - 1);
  const std::uint64_t kind = *head >> kWireBits & ((1U << kKindBits) - 1);
  if (wire >= kWires.size() || kind >= kKinds.size() || *head >= kHasPeer << 1) return std::nullopt;
  Record record{.wire = static_cast<Wire>(wire), .kind = static_cast<Kind>(kind)};
  record.time_ns = before_.time_ns = sum(before_.time_ns, *time);
  if (*head & kHasPeer) {
    const auto address = take_number(rest_), port = address ? take_number(rest_) : std::nullopt;
    if (!port || *address > UINT32_MAX || *port > UINT16_MAX) return std::nullopt;
    before_.peer = Peer{static_cast<std::uint32_t>(*address), static_cast<std::uint16_t>(*port)};
  }
  if (has_peer(record.wire, record.kind)) record.peer = before_.peer;
  const auto size = take_number(rest_);
  if (!size || *size > rest_.size()) return std::nullopt;
  std::string& before = before_.bytes[{record.wire, record.kind}];
  auto bytes = apply_difference(before, rest_.substr(0, *size), kMostRecordBytes);
  if (!bytes) return std::nullopt;
  rest_.remove_prefix(*size);
  record.bytes = *std::move(bytes);
  if (!record.bytes.empty()) before = record.bytes;
  return record;
}

}  // namespace truepose::recording
