#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/recorder/byte_queue.hpp"
#include "daemon/recorder/recorded_stream.hpp"
#include "daemon/recorder/recording_folder.hpp"
#include "daemon/recorder/ring.hpp"
#include "drivers/clock.hpp"
#include "drivers/wire_tap.hpp"
#include "proto/recording/recording.hpp"

namespace truepose::daemon {

/// Keeps the last that went over the wires to robot and tracker in a ring, and writes it to files.
///
/// exchanges() is the realtime thread's to fill, tell() and status() are any other's, the rest is one
/// thread's, which may be kept waiting by the disk.
class Recorder {
 public:
  /// @param clock            outlives the recorder
  /// @param clock_origin_ns  UTC of its 0
  /// @param rsi              at which the stream listens
  Recorder(std::unique_ptr<Ring> ring, const drivers::Clock& clock, std::int64_t clock_origin_ns = 0,
           const recording::Endpoint& rsi = {});

  ByteQueue& exchanges() { return exchanges_; }
  void tell(recording::Wire wire, recording::Kind kind, std::string_view bytes);
  /// For a driver; the recorder outlives it.
  drivers::WireTap tap(recording::Wire wire);

  struct Status {
    drivers::Duration lasts{};  ///< from the oldest record to the newest
    std::size_t bytes = 0;      ///< of the ring, with records in it
    std::uint64_t dropped = 0;  ///< records for which there was no room
  };
  Status status() const;

  /// Moves queued records into the ring.
  void drain();
  /// Writes what the ring holds, whole or not at all. @return or why not, one sentence
  std::expected<void, std::string> save(recording::Header header, const std::filesystem::path& file);
  /// What the ring is of, for who finds it (save_left_behind()).
  std::expected<void, std::string> keep_header(recording::Header header, const RecordingFolder& folder) const;

 private:
  std::vector<recording::Record> take_queued();
  void keep(const recording::Record& record);
  void report_dropped();

  const drivers::Clock& clock_;
  const std::int64_t clock_origin_ns_;
  ByteQueue exchanges_;
  ExchangeReader reader_;
  recording::RecordWriter writer_;
  std::unique_ptr<Ring> ring_;
  std::uint64_t dropped_reported_ = 0;
  std::int64_t newest_ns_ = 0;
  std::string exchange_;  // kept for its room

  mutable std::mutex mutex_;
  std::vector<recording::Record> queued_;
  std::size_t queued_bytes_ = 0;
  std::uint64_t queue_dropped_ = 0;
  Status status_;
};

/// Makes a recording of the ring that a process left which was killed.
/// @param date  now, RFC 3339. @return its file; empty where there was none; or one sentence
std::expected<std::filesystem::path, std::string> save_left_behind(const RecordingFolder& folder,
                                                                   const std::string& date);
/// A process that ends in order leaves no ring.
void remove_ring(const RecordingFolder& folder);

}  // namespace truepose::daemon
