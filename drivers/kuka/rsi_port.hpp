#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "drivers/kuka/rsi_link.hpp"
#include "drivers/start_failure.hpp"

namespace truepose::drivers {

/// A UDP port with two queues in the kernel: one for the controller, one for all others. So whatever others
/// send neither wakes the thread that waits for the controller, nor stands before a datagram of its, nor
/// takes the room of one.
///
/// receive() to expect_any_port() belong to one thread: no allocation, lock or exception.
class RsiPort {
 public:
  /// Bound so that a second instance fails, instead of taking the datagrams away.
  /// @param controller  its IPv4 address; none: everybody is in the first queue
  /// @return the port, or one sentence that names the address and, where it can be found, who holds it
  static std::expected<RsiPort, StartFailure> bind(const std::string& address, std::uint16_t port,
                                                   std::optional<std::uint32_t> controller);

  std::uint16_t number() const { return number_; }

  struct Received {
    Datagram datagram;  ///< valid until the next is received
    TimePoint taken;    ///< from the kernel
    bool cut = false;   ///< longer than the buffer
  };
  /// Waits for the controller's next datagram. @return nothing when none came for 30 ms, or the process was
  /// stopped meanwhile
  std::optional<Received> receive() noexcept;
  /// Does not wait.
  std::optional<Received> receive_pending() noexcept;
  /// Does not wait.
  std::optional<Received> receive_foreign() noexcept;
  /// @return whether it went out whole
  bool send(std::string_view bytes, const UdpSource& to) noexcept;

  /// The controller sends from this port: by any other, its address is one of the others'.
  void expect(const UdpSource& source) noexcept;
  void expect_any_port() noexcept;

 private:
  /// Owns a file descriptor.
  class Descriptor {
   public:
    explicit Descriptor(int descriptor = -1) : descriptor_{descriptor} {}
    ~Descriptor();
    Descriptor(Descriptor&& other) noexcept : descriptor_{std::exchange(other.descriptor_, -1)} {}
    Descriptor& operator=(Descriptor&& other) noexcept {
      std::swap(descriptor_, other.descriptor_);
      return *this;
    }
    int get() const { return descriptor_; }

   private:
    int descriptor_;
  };
  using Buffer = std::array<char, 64 * 1024>;  // a datagram is never cut

  RsiPort(Descriptor socket, std::uint16_t number);
  static std::expected<Descriptor, StartFailure> open_socket();
  std::optional<StartFailure> open_foreign_socket(const std::string& address, std::uint32_t controller);
  bool steer(std::optional<std::uint16_t> port) noexcept;
  std::optional<Received> receive(const Descriptor& socket, int flags) noexcept;

  Descriptor socket_;
  Descriptor others_;
  std::uint16_t number_;
  std::uint32_t controller_ = 0;
  std::optional<std::uint16_t> expected_;  // port of the controller
  std::unique_ptr<Buffer> buffer_;
};

}  // namespace truepose::drivers
