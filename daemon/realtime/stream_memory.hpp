#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <memory>
#include <optional>

#include "drivers/start_failure.hpp"

namespace truepose::daemon {

/// What the stream has to know of the controller after this process has ended and another one has begun: kept
/// in a page that is mapped from a file in memory (under /run), so that keeping it is no system call and it
/// ends with the machine.
///
/// Of two slots the older one is written, so that whenever the process ends, the other is whole.
class StreamMemory {
 public:
  struct Record {
    std::uint32_t address = 0;  ///< of the controller, as UdpSource
    std::uint32_t port = 0;
    std::uint64_t ipoc = 0;  ///< of the last datagram that continued
    std::uint64_t step = 0;
    std::int64_t received_ns = 0;                ///< of that datagram, on the machine's steady clock
    std::int64_t delay = -1;                     ///< as the controller counted then; -1: not known
    std::array<double, 6> min_rad{}, max_rad{};  ///< what may be in effect, the reply to it included
    std::array<double, 6> sent_rad{};            ///< that reply
  };

  /// @param file  is made where it is not there. @return the page; or one sentence, which a full disk lets
  /// pass
  static std::expected<std::unique_ptr<StreamMemory>, drivers::StartFailure> open(
      const std::filesystem::path& file);
  /// One that ends with this process. Throws std::bad_alloc.
  static std::unique_ptr<StreamMemory> in_process();
  ~StreamMemory();
  StreamMemory(const StreamMemory&) = delete;
  StreamMemory& operator=(const StreamMemory&) = delete;

  /// What was kept last, if it is whole and plausible.
  std::optional<Record> last() const noexcept;
  void keep(const Record& record) noexcept;

 private:
  struct Page;
  explicit StreamMemory(Page* page);

  Page* page_;
  std::uint64_t number_ = 0;  // of the newest record
  std::size_t newest_ = 0;    // its slot
};

}  // namespace truepose::daemon
