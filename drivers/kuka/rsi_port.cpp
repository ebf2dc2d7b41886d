#include "drivers/kuka/rsi_port.hpp"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>

#include "drivers/port_holder.hpp"

namespace truepose::drivers {
namespace {

// Two cycles of 12 ms, and less than the 40 ms that a controller needs to restart, perhaps from another port.
constexpr timeval kReceiveTimeout{.tv_sec = 0, .tv_usec = 30'000};

std::string last_error() { return std::strerror(errno); }

/// A socket's own address, or that of another.
struct Name {
  sockaddr_in in{};
  socklen_t size = sizeof in;

  sockaddr* get() { return reinterpret_cast<sockaddr*>(&in); }
};

std::optional<StartFailure> bind_to(int socket, Name name) {
  if (::bind(socket, name.get(), name.size) == 0) return std::nullopt;
  std::array<char, INET_ADDRSTRLEN> address{};
  ::inet_ntop(AF_INET, &name.in.sin_addr, address.data(), address.size());
  const std::uint16_t port = ntohs(name.in.sin_port);
  const std::string where = "RSI address " + std::string{address.data()} + ":" + std::to_string(port);
  switch (errno) {
    case EADDRINUSE:
      return StartFailure{where + " is in use by " + port_holder(Protocol::Udp, port), true};
    case EADDRNOTAVAIL:
      return StartFailure{where +
                              " is not one of this machine's: give the network card that leads to the "
                              "controller this address, or change IP_NUMBER",
                          true};
    default:
      return StartFailure{where + ": " + last_error()};
  }
}

/// When the kernel took the datagram in: a process that was kept waiting reads a backlog, and must not take
/// the time that it lost itself for a silence of the controller.
TimePoint arrival(msghdr& message, TimePoint now) noexcept {
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp, real;
    std::memcpy(&stamp, CMSG_DATA(part), sizeof stamp);
    ::clock_gettime(CLOCK_REALTIME, &real);
    const std::chrono::nanoseconds age = std::chrono::seconds{real.tv_sec - stamp.tv_sec} +
                                         std::chrono::nanoseconds{real.tv_nsec - stamp.tv_nsec};
    // A clock that was set meanwhile would make nonsense of the difference.
    if (age > std::chrono::nanoseconds{0} && age < std::chrono::seconds{10}) return now - age;
  }
  return now;
}

}  // namespace

RsiPort::Descriptor::~Descriptor() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

RsiPort::RsiPort(Descriptor socket, std::uint16_t number)
    : socket_{std::move(socket)}, number_{number}, buffer_{std::make_unique<Buffer>()} {}

std::expected<RsiPort::Descriptor, StartFailure> RsiPort::open_socket() {
  Descriptor socket{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (socket.get() < 0) return std::unexpected("RSI: no UDP socket: " + last_error());
  if (::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &kReceiveTimeout, sizeof kReceiveTimeout) != 0)
    return std::unexpected("RSI: no receive timeout: " + last_error());
  const int on = 1;
  if (::setsockopt(socket.get(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0)
    return std::unexpected("RSI: no time stamps of datagrams: " + last_error());
  return socket;
}

std::expected<RsiPort, StartFailure> RsiPort::bind(const std::string& address, std::uint16_t port,
                                                   std::optional<std::uint32_t> controller) {
  Name name;
  name.in.sin_family = AF_INET;
  name.in.sin_port = htons(port);
  if (::inet_pton(AF_INET, address.c_str(), &name.in.sin_addr) != 1)
    return std::unexpected("RSI address " + address + " is not an IPv4 address");
  auto socket = open_socket();
  if (!socket) return std::unexpected(socket.error());
  if (const auto failure = bind_to(socket->get(), name)) return std::unexpected(*failure);
  if (::getsockname(socket->get(), name.get(), &name.size) != 0)
    return std::unexpected("RSI address " + address + ": " + last_error());
  RsiPort bound{*std::move(socket), ntohs(name.in.sin_port)};
  if (controller) {
    if (const auto failure = bound.open_foreign_socket(address, *controller))
      return std::unexpected(*failure);
  }
  return bound;
}

/// A second socket at the same port. The first was bound alone, which refuses any other program that binds
/// the port. Sharing is enabled on both only now.
std::optional<StartFailure> RsiPort::open_foreign_socket(const std::string& address,
                                                         std::uint32_t controller) {
  auto others = open_socket();
  if (!others) return others.error();
  const int on = 1;
  Name name;
  if (::setsockopt(socket_.get(), SOL_SOCKET, SO_REUSEPORT, &on, sizeof on) != 0 ||
      ::setsockopt(others->get(), SOL_SOCKET, SO_REUSEPORT, &on, sizeof on) != 0 ||
      ::getsockname(socket_.get(), name.get(), &name.size) != 0)
    return "RSI address " + address + ": no second queue: " + last_error();
  if (auto failure = bind_to(others->get(), name)) return failure;
  others_ = *std::move(others);
  controller_ = controller;
  if (!steer(std::nullopt)) return "RSI address " + address + ": no filter of senders: " + last_error();
  return std::nullopt;
}

/// Gives the kernel the program that chooses the queue: 0, the first that was bound, for the controller.
/// @param port  of the controller; none: any
bool RsiPort::steer(std::optional<std::uint16_t> port) noexcept {
  constexpr auto kHeader = static_cast<std::uint32_t>(SKF_NET_OFF);  // of IP
  constexpr std::uint32_t kWithoutOptions = 0x45, kSource = kHeader + 12, kSourcePort = kHeader + 20;
  const std::uint16_t test_port = BPF_JMP | BPF_K | (port ? BPF_JEQ : BPF_JGE);  // >= 0: any
  std::array<sock_filter, 8> program{{
      {BPF_LD | BPF_B | BPF_ABS, 0, 0, kHeader},
      {BPF_JMP | BPF_JEQ | BPF_K, 0, 5, kWithoutOptions},
      {BPF_LD | BPF_W | BPF_ABS, 0, 0, kSource},
      {BPF_JMP | BPF_JEQ | BPF_K, 0, 3, controller_},
      {BPF_LD | BPF_H | BPF_ABS, 0, 0, kSourcePort},
      {test_port, 0, 1, port.value_or(0)},
      {BPF_RET | BPF_K, 0, 0, 0},
      {BPF_RET | BPF_K, 0, 0, 1},
  }};
  const sock_fprog loaded{.len = program.size(), .filter = program.data()};
  return ::setsockopt(socket_.get(), SOL_SOCKET, SO_ATTACH_REUSEPORT_CBPF, &loaded, sizeof loaded) == 0;
}

// Some microseconds, when a session begins and when one ends. Where the kernel has no memory for it, the
// queues stay as they are, and all are heard as before.
void RsiPort::expect(const UdpSource& source) noexcept {
  if (others_.get() < 0 || source.address != controller_ || expected_ == source.port) return;
  if (steer(source.port)) expected_ = source.port;
}

void RsiPort::expect_any_port() noexcept {
  if (expected_ && steer(std::nullopt)) expected_.reset();
}

std::optional<RsiPort::Received> RsiPort::receive() noexcept { return receive(socket_, 0); }

std::optional<RsiPort::Received> RsiPort::receive_pending() noexcept {
  return receive(socket_, MSG_DONTWAIT);
}

std::optional<RsiPort::Received> RsiPort::receive_foreign() noexcept {
  if (others_.get() < 0) return std::nullopt;
  return receive(others_, MSG_DONTWAIT);
}

std::optional<RsiPort::Received> RsiPort::receive(const Descriptor& socket, int flags) noexcept {
  Name source;
  iovec part{.iov_base = buffer_->data(), .iov_len = buffer_->size()};
  msghdr message{};
  message.msg_name = source.get();
  message.msg_namelen = source.size;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> control;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t size = ::recvmsg(socket.get(), &message, flags);
  if (size < 0) return std::nullopt;  // nothing in time, or a signal
  const TimePoint now = std::chrono::steady_clock::now();
  return Received{{.bytes = {buffer_->data(), static_cast<std::size_t>(size)},
                   .source = {ntohl(source.in.sin_addr.s_addr), ntohs(source.in.sin_port)},
                   .received = arrival(message, now)},
                  now,
                  (message.msg_flags & MSG_TRUNC) != 0};
}

bool RsiPort::send(std::string_view bytes, const UdpSource& to) noexcept {
  Name name;
  name.in.sin_family = AF_INET;
  name.in.sin_port = htons(to.port);
  name.in.sin_addr.s_addr = htonl(to.address);
  const ssize_t sent =
      ::sendto(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT, name.get(), name.size);
  return sent == static_cast<ssize_t>(bytes.size());
}

}  // namespace truepose::drivers
