#include "daemon/recorder/recorded_stream.hpp"

#include <chrono>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

namespace truepose::daemon {

using recording::Commands;
using recording::Kind;
using recording::Record;

namespace {

constexpr int kMaxForeignPerSecond = 10;
constexpr int kRepliesToCheckpoint = 250;

/// What stands in the queue before the bytes of a datagram, its reply and a checkpoint.
struct Head {
  std::int64_t received_ns = 0, done_ns = 0;
  std::uint64_t model = 0, models = 0;
  std::uint32_t acknowledged = 0;
  std::uint32_t address = 0, datagram_bytes = 0, reply_bytes = 0;
  std::uint16_t port = 0;
  bool started = false, admitted = false, has_memory = false;
  Commands::Engagement engagement{};
};
static_assert(std::is_trivially_copyable_v<Head> && std::is_trivially_copyable_v<StreamMemory::Record>);

template <typename T>
std::string_view bytes_of(const T& value) noexcept {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

std::string_view take(std::string_view& bytes, std::size_t size) {
  const std::string_view taken = bytes.substr(0, size);
  bytes.remove_prefix(size);
  return taken;
}

}  // namespace

RecordedStream::RecordedStream(StreamCycle& cycle, const StreamMemory& memory, ByteQueue& queue)
    : cycle_{cycle}, memory_{memory}, queue_{queue} {
  const auto kept = memory_.last();
  Head head{.started = true, .has_memory = kept.has_value()};
  head.received_ns = head.done_ns = drivers::nanoseconds_of(cycle_.circumstances().done);
  queue_.push({bytes_of(head), kept ? bytes_of(*kept) : std::string_view{}});
}

std::string_view RecordedStream::answer(const drivers::Datagram& datagram) noexcept {
  datagram_ = datagram;
  return reply_ = cycle_.answer(datagram);
}

void RecordedStream::finish(const drivers::CycleTimes& times) noexcept {
  cycle_.finish(times);
  const drivers::Datagram& datagram = datagram_;
  const StreamCycle::Circumstances now = cycle_.circumstances();
  if (!now.admitted && !may_record_foreign(datagram.received)) return;
  Head head{.received_ns = drivers::nanoseconds_of(datagram.received),
            .done_ns =
                now.admitted ? drivers::nanoseconds_of(now.done) : drivers::nanoseconds_of(datagram.received),
            .model = now.model,
            .models = now.models,
            .acknowledged = now.acknowledged,
            .address = datagram.source.address,
            .datagram_bytes = static_cast<std::uint32_t>(datagram.bytes.size()),
            .reply_bytes = static_cast<std::uint32_t>(reply_.size()),
            .port = datagram.source.port,
            .admitted = now.admitted,
            .engagement = now.engagement};
  const auto kept = checkpoint_is_due(!reply_.empty(), now.state) ? memory_.last() : std::nullopt;
  head.has_memory = kept.has_value();
  queue_.push({bytes_of(head), datagram.bytes, reply_, kept ? bytes_of(*kept) : std::string_view{}});
}

bool RecordedStream::may_record_foreign(drivers::TimePoint received) noexcept {
  if (received - foreign_since_ >= std::chrono::seconds{1}) {
    foreign_since_ = received;
    foreign_ = 0;
  }
  return ++foreign_ <= kMaxForeignPerSecond;
}

/// From what is remembered after a reply a cycle can continue that does not ramp, and holds for nothing.
bool RecordedStream::checkpoint_is_due(bool replied, StreamState state) noexcept {
  const bool steady = state == StreamState::Active || state == StreamState::Idle;
  if (!replied || ++replies_ < kRepliesToCheckpoint || !steady) return false;
  replies_ = 0;
  return true;
}

void ExchangeReader::read(std::string_view exchange, const std::function<void(Record)>& take_record) {
  Head head;
  std::memcpy(&head, take(exchange, sizeof head).data(), sizeof head);
  const std::string datagram{take(exchange, head.datagram_bytes)}, reply{take(exchange, head.reply_bytes)};
  if (head.started) {
    commands_.reset();
    return take_record({.time_ns = head.received_ns, .kind = Kind::Started, .bytes = std::string{exchange}});
  }
  const Commands commands{head.engagement, head.acknowledged, head.model, head.models};
  if (head.admitted && std::exchange(commands_, commands) != commands)
    take_record({.time_ns = head.received_ns, .kind = Kind::Commands, .bytes = text(commands)});
  take_record({.time_ns = head.received_ns,
               .kind = Kind::Received,
               .peer = recording::Endpoint{head.address, head.port},
               .bytes = datagram});
  take_record({.time_ns = head.done_ns, .kind = Kind::Sent, .bytes = reply});
  if (head.has_memory) {
    // A replay that begins here has not seen the commands before.
    take_record({.time_ns = head.done_ns, .kind = Kind::Checkpoint, .bytes = std::string{exchange}});
    take_record({.time_ns = head.done_ns, .kind = Kind::Commands, .bytes = text(commands)});
  }
}

}  // namespace truepose::daemon
