#include "drivers/kuka/rsi_link.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <thread>
#include <utility>

#include "drivers/port_holder.hpp"

namespace truepose::drivers {
namespace {

constexpr std::size_t kBufferBytes = 64 * 1024;  // a datagram is never cut
constexpr std::size_t kStackBytes = 256 * 1024;  // touched before the first datagram
constexpr timeval kReceiveTimeout{.tv_sec = 0,
                                  .tv_usec = 100'000};  // how often the thread looks whether to end

/// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_{descriptor} {}
  ~Descriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Descriptor(Descriptor&& other) noexcept : descriptor_{std::exchange(other.descriptor_, -1)} {}
  Descriptor& operator=(Descriptor&&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

std::string error_text() { return std::strerror(errno); }

struct BoundSocket {
  Descriptor socket;
  std::uint16_t port;
};

/// Bound without SO_REUSEADDR: a second instance must fail instead of taking the datagrams away.
std::expected<BoundSocket, StartFailure> bind_exclusively(const std::string& address, std::uint16_t port) {
  const std::string where = address + ":" + std::to_string(port);
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(port);
  if (::inet_pton(AF_INET, address.c_str(), &name.sin_addr) != 1) {
    return std::unexpected("RSI address " + address + " is not an IPv4 address");
  }
  Descriptor socket{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (socket.get() < 0) return std::unexpected("RSI: no UDP socket: " + error_text());
  if (::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &kReceiveTimeout, sizeof kReceiveTimeout) != 0) {
    return std::unexpected("RSI: no receive timeout: " + error_text());
  }
  const int on = 1;
  if (::setsockopt(socket.get(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0) {
    return std::unexpected("RSI: no time stamps of datagrams: " + error_text());
  }
  socklen_t size = sizeof name;
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&name), size) != 0) {
    switch (errno) {
      case EADDRINUSE:
        return std::unexpected(
            StartFailure{"RSI address " + where + " is in use by " + port_holder(Protocol::Udp, port), true});
      case EADDRNOTAVAIL:
        return std::unexpected(StartFailure{
            "RSI address " + where +
                " is not one of this machine's: give the network card that leads to the controller "
                "this address, or change IP_NUMBER",
            true});
      default:
        return std::unexpected("RSI address " + where + ": " + error_text());
    }
  }
  if (::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&name), &size) != 0) {
    return std::unexpected("RSI address " + where + ": " + error_text());
  }
  return BoundSocket{std::move(socket), ntohs(name.sin_port)};
}

/// When the kernel took the datagram in: a process that was kept waiting reads a backlog, and must not take
/// the time that it lost itself for a silence of the controller.
TimePoint arrival(msghdr& message) noexcept {
  const TimePoint now = std::chrono::steady_clock::now();
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

struct Scheduling {
  bool complete = true;
  std::string text;
};

/// Asks for what the calling thread needs to meet the cycle, and tells what was refused.
Scheduling enter_realtime(int priority) {
  if (priority <= 0) return {true, "ordinary scheduling"};
  Scheduling result;
  const sched_param parameters{.sched_priority = priority};
  if (::sched_setscheduler(0, SCHED_FIFO, &parameters) == 0) {
    result.text = "SCHED_FIFO " + std::to_string(priority);
  } else {
    result.complete = false;
    result.text = "ordinary scheduling (SCHED_FIFO " + std::to_string(priority) +
                  " refused: " + error_text() + "; raise the limit rtprio, LimitRTPRIO= in the unit)";
  }
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) == 0) {
    result.text += ", memory locked";
  } else {
    result.complete = false;
    result.text +=
        ", memory not locked (" + error_text() + "; raise the limit memlock, LimitMEMLOCK= in the unit)";
  }
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  return result;
}

[[gnu::noinline]] void touch_stack() {
  std::array<volatile char, kStackBytes> pages;
  for (std::size_t i = 0; i < pages.size(); i += 4096) pages[i] = 0;
}

class UdpRsiLink final : public RsiLink {
 public:
  UdpRsiLink(BoundSocket bound, const RsiLinkOptions& options, RsiResponder& responder)
      : socket_{std::move(bound.socket)}, port_{bound.port}, responder_{responder} {
    thread_ = std::jthread{
        [this, priority = options.priority](const std::stop_token& stop) { run(stop, priority); }};
    started_.wait(false);
  }

  std::uint16_t port() const override { return port_; }
  std::string scheduling() const override { return scheduling_.text; }
  bool realtime() const { return scheduling_.complete; }

  std::uint64_t heartbeats() const override { return heartbeats_.load(); }

  Counters counters() const override {
    return {received_.load(), answered_.load(), unanswered_.load(), truncated_.load(), send_failed_.load()};
  }

 private:
  void run(const std::stop_token& stop, int priority) {
    scheduling_ = enter_realtime(priority);
    touch_stack();
    buffer_.fill(0);
    started_ = true;
    started_.notify_one();
    for (; !stop.stop_requested(); ++heartbeats_) serve_one();
  }

  void serve_one() noexcept {
    sockaddr_in source{};
    iovec part{.iov_base = buffer_.data(), .iov_len = buffer_.size()};
    msghdr message{};
    message.msg_name = &source;
    message.msg_namelen = sizeof source;
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> control;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t size = ::recvmsg(socket_.get(), &message, 0);
    if (size < 0) return;  // nothing within the timeout, or a signal
    ++received_;
    if (message.msg_flags & MSG_TRUNC) {
      ++truncated_;
      return;
    }
    const std::string_view reply =
        responder_.answer({.bytes = {buffer_.data(), static_cast<std::size_t>(size)},
                           .source = {ntohl(source.sin_addr.s_addr), ntohs(source.sin_port)},
                           .received = arrival(message)});
    if (reply.empty()) {
      ++unanswered_;
      return;
    }
    // The controller's source port is not the configured one, and only this one listens.
    const ssize_t sent = ::sendto(socket_.get(), reply.data(), reply.size(), MSG_DONTWAIT,
                                  reinterpret_cast<const sockaddr*>(&source), message.msg_namelen);
    ++(sent == static_cast<ssize_t>(reply.size()) ? answered_ : send_failed_);
  }

  Descriptor socket_;
  std::uint16_t port_;
  RsiResponder& responder_;
  Scheduling scheduling_;  // written before started_
  std::atomic<bool> started_{false};
  std::atomic<std::uint64_t> heartbeats_{0};
  std::atomic<std::uint64_t> received_{0}, answered_{0}, unanswered_{0}, truncated_{0}, send_failed_{0};
  std::array<char, kBufferBytes> buffer_;
  std::jthread thread_;  // last: it ends before what it uses
};

}  // namespace

std::string text(const UdpSource& source) {
  const auto byte = [&](int shift) { return std::to_string((source.address >> shift) & 0xff); };
  return byte(24) + '.' + byte(16) + '.' + byte(8) + '.' + byte(0) + ':' + std::to_string(source.port);
}

std::expected<std::uint32_t, std::string> ipv4_of(const std::string& host) {
  const addrinfo wanted{.ai_flags = 0,
                        .ai_family = AF_INET,
                        .ai_socktype = SOCK_DGRAM,
                        .ai_protocol = 0,
                        .ai_addrlen = 0,
                        .ai_addr = nullptr,
                        .ai_canonname = nullptr,
                        .ai_next = nullptr};
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), nullptr, &wanted, &found); error != 0) {
    return std::unexpected(host + " has no IPv4 address: " + ::gai_strerror(error));
  }
  sockaddr_in name;
  std::memcpy(&name, found->ai_addr, sizeof name);
  ::freeaddrinfo(found);
  return ntohl(name.sin_addr.s_addr);
}

std::expected<std::unique_ptr<RsiLink>, StartFailure> RsiLink::start(const RsiLinkOptions& options,
                                                                     RsiResponder& responder) {
  auto bound = bind_exclusively(options.address, options.port);
  if (!bound) return std::unexpected(bound.error());
  auto link = std::make_unique<UdpRsiLink>(std::move(*bound), options, responder);
  if (options.require_realtime && !link->realtime()) {
    return std::unexpected("RSI needs real-time scheduling and does not get it: " + link->scheduling());
  }
  return link;
}

}  // namespace truepose::drivers
