#include "drivers/port_holder.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <utility>

namespace truepose::drivers {
namespace {

/// A UDP socket on a free port of the loopback. @return the socket and its port
std::pair<int, std::uint16_t> bound_socket() {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof name;
  ::bind(socket, reinterpret_cast<const sockaddr*>(&name), size);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&name), &size);
  return {socket, ntohs(name.sin_port)};
}

/// Puts a descriptor into a message that nobody receives: it stays open, and no process has it.
void post_into(int box, int descriptor) {
  char byte = 0;
  iovec part{&byte, 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(sizeof(int));
  std::memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
  ASSERT_EQ(::sendmsg(box, &message, 0), 1);
}

TEST(IsHeld, TellsAPortThatSomebodyHasFromAFreeOne) {
  const auto [socket, port] = bound_socket();
  constexpr std::uint16_t kNobodys = 1;  // tcpmux, of TCP
  EXPECT_TRUE(is_held(Protocol::Udp, port));
  EXPECT_FALSE(is_held(Protocol::Udp, kNobodys));
  ::close(socket);
}

TEST(PortHolder, DoesNotBlameAnotherUserForAProcessOfOursThatIsGone) {
  const auto [socket, port] = bound_socket();
  EXPECT_THAT(port_holder(Protocol::Udp, port),
              testing::HasSubstr("(process " + std::to_string(::getpid()) + ")"));
  std::array<int, 2> box{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, box.data()), 0);
  post_into(box[0], socket);
  ::close(socket);
  EXPECT_EQ(port_holder(Protocol::Udp, port), "a process of uid " + std::to_string(::geteuid()) +
                                                  " that is just ending, or runs in another container");
  for (const int end : box) ::close(end);
  EXPECT_EQ(port_holder(Protocol::Udp, port), "an unknown process");
}

}  // namespace
}  // namespace truepose::drivers
