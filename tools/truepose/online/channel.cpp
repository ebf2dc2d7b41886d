#include "tools/truepose/online/channel.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace truepose::tools {

bool wait_for(int socket, short events, Channel::Deadline until) {
  while (true) {
    int wait_ms = -1;
    if (until != Channel::Deadline::max()) {
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
      wait_ms = static_cast<int>(std::max<std::int64_t>(left.count(), 0));
    }
    pollfd watched{socket, events, 0};
    const int ready = ::poll(&watched, 1, wait_ms);
    if (ready > 0) return true;
    if (ready == 0 || errno != EINTR) return false;
  }
}

namespace {

class PlainChannel final : public Channel {
 public:
  explicit PlainChannel(int socket) : socket_{socket} {}
  PlainChannel(const PlainChannel&) = delete;
  PlainChannel& operator=(const PlainChannel&) = delete;
  ~PlainChannel() override { ::close(socket_); }

  std::expected<void, std::string> write(std::string_view bytes, Deadline until) override {
    while (!bytes.empty()) {
      const ssize_t size = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (size >= 0) {
        bytes.remove_prefix(static_cast<std::size_t>(size));
      } else if (errno != EAGAIN && errno != EINTR) {
        return std::unexpected(std::strerror(errno));
      } else if (!wait_for(socket_, POLLOUT, until)) {
        return std::unexpected("it takes no more requests");
      }
    }
    return {};
  }

  std::expected<std::size_t, std::string> read_some(std::span<char> bytes, Deadline until) override {
    while (true) {
      if (!wait_for(socket_, POLLIN, until)) return std::unexpected("no answer in time");
      const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), 0);
      if (size > 0) return static_cast<std::size_t>(size);
      if (size == 0) return std::unexpected("the daemon closed it");
      if (errno != EAGAIN && errno != EINTR) return std::unexpected(std::strerror(errno));
    }
  }

 private:
  int socket_;
};

}  // namespace

std::unique_ptr<Channel> plain_channel(int socket) { return std::make_unique<PlainChannel>(socket); }

}  // namespace truepose::tools
