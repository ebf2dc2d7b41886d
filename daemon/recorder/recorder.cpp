#include "daemon/recorder/recorder.hpp"

#include <algorithm>
#include <utility>

#include "config/text_file.hpp"

namespace truepose::daemon {

using recording::Kind;
using recording::Record;
using recording::Wire;

namespace {

// Twenty seconds of datagrams and replies every 4 ms: for so long the disk may keep the reader waiting.
constexpr std::size_t kExchangeBytes = std::size_t{4} << 20;
constexpr std::size_t kMaxQueuedBytes = std::size_t{4} << 20;

using Written = std::expected<void, std::string>;

/// Whole or not at all.
Written write_recording(const std::string& head, const Ring& ring, const std::string& tail,
                        const std::filesystem::path& file) try {
  config::UnfinishedFile out{file};
  out.stream() << head;
  for (const Ring::Block& each : ring.blocks()) out.stream() << each.texts;
  out.stream() << tail;
  out.close();
  out.take_place();
  return {};
} catch (const config::ConfigError& error) {
  return std::unexpected(error.what());
}

}  // namespace

Recorder::Recorder(std::unique_ptr<Ring> ring, const drivers::Clock& clock, std::int64_t clock_origin_ns,
                   const recording::Endpoint& rsi)
    : clock_{clock},
      clock_origin_ns_{clock_origin_ns},
      exchanges_{kExchangeBytes},
      writer_{rsi, clock_origin_ns},
      ring_{std::move(ring)} {}

void Recorder::tell(Wire wire, Kind kind, std::string_view bytes) {
  const std::int64_t now = drivers::nanoseconds_of(clock_.now());
  const std::lock_guard lock{mutex_};
  if (queued_bytes_ + bytes.size() > kMaxQueuedBytes || bytes.size() > recording::kMostRecordBytes) {
    ++queue_dropped_;
    return;
  }
  queued_bytes_ += bytes.size();
  queued_.push_back({.time_ns = now, .wire = wire, .kind = kind, .bytes = std::string{bytes}});
}

drivers::WireTap Recorder::tap(Wire wire) {
  return [this, wire](Kind kind, std::string_view bytes) { tell(wire, kind, bytes); };
}

Recorder::Status Recorder::status() const {
  const std::lock_guard lock{mutex_};
  Status status = status_;
  status.dropped = exchanges_.dropped() + queue_dropped_;
  return status;
}

void Recorder::drain() {
  while (exchanges_.pop(exchange_)) reader_.read(exchange_, [this](const Record& record) { keep(record); });
  for (const Record& record : take_queued()) keep(record);
  report_dropped();
  ring_->settle();
  const std::lock_guard lock{mutex_};
  status_.bytes = ring_->bytes();
  status_.lasts = std::chrono::nanoseconds{newest_ns_ - ring_->begin_ns().value_or(newest_ns_)};
}

std::vector<Record> Recorder::take_queued() {
  const std::lock_guard lock{mutex_};
  queued_bytes_ = 0;
  return std::exchange(queued_, {});
}

void Recorder::keep(const Record& record) {
  ring_->append(record.time_ns, writer_.blocks(record));
  newest_ns_ = std::max(newest_ns_, record.time_ns);
}

void Recorder::report_dropped() {
  const std::uint64_t dropped = status().dropped;
  const std::uint64_t more = dropped - std::exchange(dropped_reported_, dropped);
  if (more == 0) return;
  keep({.time_ns = drivers::nanoseconds_of(clock_.now()),
        .wire = Wire::Daemon,
        .kind = Kind::Dropped,
        .bytes = std::to_string(more)});
}

std::expected<void, std::string> Recorder::save(recording::Header header, const std::filesystem::path& file) {
  drain();
  header.clock_origin_ns = clock_origin_ns_;
  return write_recording(recording::head(header, ring_->begin_ns().value_or(header.time_ns)), *ring_,
                         recording::tail(header), file);
}

std::expected<void, std::string> Recorder::keep_header(recording::Header header,
                                                       const RecordingFolder& folder) const try {
  header.clock_origin_ns = clock_origin_ns_;
  config::write_text_file(folder.ring_header(), recording::head(header, header.time_ns));
  return {};
} catch (const config::ConfigError& error) {
  return std::unexpected(error.what());
}

std::expected<std::filesystem::path, std::string> save_left_behind(const RecordingFolder& folder,
                                                                   const std::string& date) try {
  if (!config::is_own_file(folder.ring()) || !config::is_own_file(folder.ring_header())) return {};
  const std::string head = config::read_bytes(folder.ring_header());
  const auto header = recording::Recording::read_header(head);
  if (!header) return std::unexpected(folder.ring_header().string() + ": " + header.error());
  const auto ring = Ring::open(folder.ring());
  if (!ring) return std::unexpected(ring.error());
  if ((*ring)->blocks().empty()) return {};
  std::filesystem::path file = folder.file(date);
  if (auto written = write_recording(head, **ring, recording::tail(*header), file); !written)
    return std::unexpected(written.error());
  return file;
} catch (const config::ConfigError& error) {
  return std::unexpected(error.what());
}

void remove_ring(const RecordingFolder& folder) {
  std::error_code ignored;
  std::filesystem::remove(folder.ring(), ignored);
  std::filesystem::remove(folder.ring_header(), ignored);
}

}  // namespace truepose::daemon
