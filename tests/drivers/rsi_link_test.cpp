#include "drivers/kuka/rsi_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <semaphore>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using testing::HasSubstr;

/// Answers with what it got, and with nothing to "quiet"; counts how often nothing came.
class Echo final : public RsiResponder {
 public:
  void finish(const CycleTimes& times) noexcept override {
    times_ = times;
    finished_.release();
  }
  /// @return what became of a datagram that was not waited for yet
  CycleTimes wait_until_finished() {
    finished_.acquire();
    return times_;
  }
  void on_no_datagram(TimePoint until) noexcept override {
    until_ = until;
    nothing_.release();
  }
  /// @return until when nothing had come
  TimePoint wait_until_nothing_comes() {
    nothing_.acquire();
    return until_;
  }

  std::string_view answer(const Datagram& datagram) noexcept override {
    return datagram.bytes == "quiet" ? std::string_view{} : datagram.bytes;
  }

 private:
  std::atomic<TimePoint> until_;
  CycleTimes times_;
  std::counting_semaphore<> nothing_{0}, finished_{0};
};

/// As Echo, but waits at "wait" until it is released; counts its datagrams.
class Busy final : public RsiResponder {
 public:
  void on_no_datagram(TimePoint) noexcept override {}
  void finish(const CycleTimes&) noexcept override {}
  std::string_view answer(const Datagram& datagram) noexcept override {
    if (datagram.bytes == "wait") {
      busy_.release();
      go_on_.acquire();
    }
    if (datagram.bytes.starts_with("stranger")) {
      strangers_.release();
      return {};
    }
    return datagram.bytes;
  }
  void wait_until_busy() { busy_.acquire(); }
  void go_on() { go_on_.release(); }
  bool hears_a_stranger() { return strangers_.try_acquire_for(std::chrono::seconds{10}); }

 private:
  std::binary_semaphore busy_{0}, go_on_{0};
  std::counting_semaphore<> strangers_{0};
};

/// Who sends to the link: the controller, or somebody else.
class Controller {
 public:
  explicit Controller(std::uint16_t port, const char* address = "127.0.0.1")
      : link_{asio::ip::address_v4::loopback(), port},
        socket_{context_, {asio::ip::make_address(address), 0}} {
    const timeval patience{.tv_sec = 10, .tv_usec = 0};
    ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }

  void send(const std::string& text) { socket_.send_to(asio::buffer(text), link_); }

  /// The next reply; "nothing" where none comes.
  std::string receive() {
    static std::array<char, 65536> bytes;
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t size = ::recvfrom(socket_.native_handle(), bytes.data(), bytes.size(), 0,
                                    reinterpret_cast<sockaddr*>(&from), &length);
    if (size < 0) return "nothing";
    EXPECT_EQ(ntohs(from.sin_port), link_.port());
    return {bytes.data(), static_cast<std::size_t>(size)};
  }

 private:
  asio::io_context context_;
  udp::endpoint link_;
  udp::socket socket_;
};

RsiLinkOptions loopback(std::uint16_t port = 0) {
  return {.address = "127.0.0.1", .port = port, .priority = 0, .require_realtime = false};
}

TEST(RsiLink, AnswersEachDatagramToItsSource) {
  Echo echo;
  const auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  Controller first{(*link)->port()};
  Controller second{(*link)->port()};
  first.send("one");
  second.send("two");
  first.send("three");
  EXPECT_EQ(first.receive(), "one");
  EXPECT_EQ(first.receive(), "three");
  EXPECT_EQ(second.receive(), "two");
  const std::string large(60000, 'x');
  first.send(large);
  EXPECT_EQ(first.receive(), large);
}

TEST(RsiLink, StaysQuietWhereTheResponderDoesAndCounts) {
  Echo echo;
  const auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  Controller controller{(*link)->port()};
  for (const char* text : {"quiet", "a", "b"}) controller.send(text);
  EXPECT_EQ(controller.receive(), "a");
  EXPECT_EQ(controller.receive(), "b");
  const RsiLink::Counters counters = (*link)->counters();
  EXPECT_EQ(counters.received, 3u);
  EXPECT_EQ(counters.unanswered, 1u);
  EXPECT_GE(counters.answered, 1u) << "a reply is counted once it has been sent";
  EXPECT_EQ(counters.truncated + counters.send_failed, 0u);
}

TEST(RsiLink, TellsWhileNothingComesUntilWhenThatIs) {
  Echo echo;
  const auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  Controller controller{(*link)->port()};
  controller.send("a");
  EXPECT_EQ(controller.receive(), "a");
  const TimePoint answered = std::chrono::steady_clock::now();
  TimePoint until;
  do {
    until = echo.wait_until_nothing_comes();
  } while (until < answered);
  EXPECT_LE(until, std::chrono::steady_clock::now());
}

constexpr std::uint32_t kLoopback = 0x7f000001;

RsiLinkOptions for_the_controller() {
  RsiLinkOptions options = loopback();
  options.controller = kLoopback;
  return options;
}

/// More than a socket's buffer holds, while the thread that would read it is busy.
void fill_the_buffer(Controller& stranger) {
  for (int i = 0; i < 50; ++i) stranger.send("stranger" + std::string(60'000, 'x'));
  for (int i = 0; i < 1000; ++i) stranger.send("stranger");  // and what is left of it
}

/// Somebody fills the port while its thread is busy: the controller is heard all the same.
void hear_the_controller_beside(Controller& stranger, Controller& controller, Busy& responder) {
  controller.send("wait");
  responder.wait_until_busy();
  fill_the_buffer(stranger);
  for (const char* text : {"a", "b", "c"}) controller.send(text);
  responder.go_on();
  for (const char* text : {"wait", "a", "b", "c"}) EXPECT_EQ(controller.receive(), text);
}

TEST(RsiLink, ReadsTheControllerHoweverMuchOthersSend) {
  Busy responder;
  const auto link = RsiLink::start(for_the_controller(), responder);
  ASSERT_TRUE(link) << link.error().text;
  Controller controller{(*link)->port()}, elsewhere{(*link)->port(), "127.0.0.2"};
  hear_the_controller_beside(elsewhere, controller, responder);
}

TEST(RsiLink, ReadsTheControllerHoweverMuchComesFromItsAddressByOtherPorts) {
  Busy responder;
  const auto link = RsiLink::start(for_the_controller(), responder);
  ASSERT_TRUE(link) << link.error().text;
  Controller controller{(*link)->port()}, other_port{(*link)->port()};
  controller.send("hello");
  EXPECT_EQ(controller.receive(), "hello");
  hear_the_controller_beside(other_port, controller, responder);
}

TEST(RsiLink, ReceivesFromOtherSendersWithAndWithoutTheController) {
  Busy responder;
  const auto link = RsiLink::start(for_the_controller(), responder);
  ASSERT_TRUE(link) << link.error().text;
  Controller controller{(*link)->port()}, elsewhere{(*link)->port(), "127.0.0.2"};
  for (int i = 0; i < 20; ++i) elsewhere.send("stranger");
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(responder.hears_a_stranger()) << i;
  controller.send("hello");
  EXPECT_EQ(controller.receive(), "hello");
  for (int i = 0; i < 20; ++i) elsewhere.send("stranger");
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(responder.hears_a_stranger()) << i;
}

TEST(RsiLink, AnswersAControllerThatGoesOnAtAnotherPort) {
  Echo echo;
  const auto link = RsiLink::start(for_the_controller(), echo);
  ASSERT_TRUE(link) << link.error().text;
  for (const char* text : {"one", "two", "three"}) {
    Controller controller{(*link)->port()};
    for (int i = 0; i < 5; ++i) {
      controller.send(text);
      EXPECT_EQ(controller.receive(), text);
    }
  }
}

TEST(RsiLink, FreesItsPortWhenItEnds) {
  Echo echo;
  auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  const std::uint16_t port = (*link)->port();
  link->reset();
  EXPECT_TRUE(RsiLink::start(loopback(port), echo));
}

TEST(RsiLink, NamesWhoHoldsThePort) {
  Echo echo;
  const auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  const auto second = RsiLink::start(loopback((*link)->port()), echo);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().text,
              HasSubstr("127.0.0.1:" + std::to_string((*link)->port()) + " is in use by "));
  EXPECT_THAT(second.error().text, HasSubstr("(process " + std::to_string(::getpid()) + ")"));
}

TEST(RsiLink, NamesAnAddressThatIsNotThisMachines) {
  Echo echo;
  RsiLinkOptions options = loopback();
  options.address = "192.0.2.1";
  EXPECT_THAT(RsiLink::start(options, echo).error().text,
              HasSubstr("192.0.2.1:0 is not one of this machine's"));
  options.address = "controller";
  EXPECT_THAT(RsiLink::start(options, echo).error().text, HasSubstr("not an IPv4 address"));
}

TEST(RsiLink, TimesADatagramFromTheKernelToTheKernel) {
  Echo echo;
  const auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  Controller controller{(*link)->port()};
  for (const auto& [text, replied] : {std::pair{"a", true}, std::pair{"quiet", false}}) {
    const TimePoint before = std::chrono::steady_clock::now();
    controller.send(text);
    const CycleTimes times = echo.wait_until_finished();
    // Two clocks are read one after the other to bring the kernel's stamp to ours.
    EXPECT_GE(times.received, before - std::chrono::milliseconds{1});
    EXPECT_GE(times.taken, times.received);
    EXPECT_GE(times.ready, times.taken);
    EXPECT_GE(times.sent, times.ready);
    EXPECT_GT(times.ran, Duration{0});
    EXPECT_EQ(times.replied, replied);
  }
}

TEST(RsiLink, TellsHowItsThreadRunsWhateverWasAskedFor) {
  Echo echo;
  RsiLinkOptions options = loopback();
  options.priority = 100;  // above what any machine grants
  const auto link = RsiLink::start(options, echo);
  ASSERT_TRUE(link) << link.error().text;
  EXPECT_EQ((*link)->scheduling().policy, "SCHED_OTHER");
  EXPECT_EQ((*link)->scheduling().priority, 0);
  EXPECT_EQ((*link)->scheduling().cpus, scheduling_of(0).cpus);
  ::munlockall();
}

TEST(RsiLink, RunsOnTheCpuThatIsAskedForAlone) {
  Echo echo;
  RsiLinkOptions options = loopback();
  options.cpu = scheduling_of(0).cpus.back();
  const auto link = RsiLink::start(options, echo);
  ASSERT_TRUE(link) << link.error().text;
  EXPECT_EQ((*link)->scheduling().cpus, std::vector{options.cpu});
}

TEST(RsiLink, RefusesACpuThatThereIsNot) {
  Echo echo;
  RsiLinkOptions options = loopback();
  options.cpu = 1023;
  const auto link = RsiLink::start(options, echo);
  ASSERT_FALSE(link);
  EXPECT_THAT(link.error().text, HasSubstr("stream.cpu: this process has no CPU 1023"));
}

TEST(Scheduling, IsReadBackFromTheKernel) {
  const auto ours_alone = [] {
    Scheduling before = scheduling_of(0);
    EXPECT_EQ(pin_to(before.cpus.front()), std::nullopt);
    Scheduling pinned = scheduling_of(0);
    EXPECT_EQ(pinned.cpus, std::vector{before.cpus.front()});
    EXPECT_EQ(pinned.policy, before.policy);
    const sched_param least{.sched_priority = 1};
    if (::sched_setscheduler(0, SCHED_FIFO, &least) != 0) return;  // not allowed here
    EXPECT_EQ(scheduling_of(0).policy, "SCHED_FIFO");
    EXPECT_EQ(scheduling_of(0).priority, 1);
  };
  std::thread{ours_alone}.join();
  ::munlockall();
  alignas(4096) static std::array<char, 65536> page;
  const std::uint64_t locked_kB = scheduling_of(0).locked_kB;
  // Sanitizers make nothing of mlock().
  ASSERT_EQ(::syscall(SYS_mlock, page.data(), page.size()), 0);
  EXPECT_EQ(scheduling_of(0).locked_kB, locked_kB + 64);
  ::syscall(SYS_munlock, page.data(), page.size());
}

TEST(Scheduling, ReadsAsALine) {
  EXPECT_EQ(describe({.policy = "SCHED_FIFO", .priority = 80, .cpus = {0, 3}, .locked_kB = 712}),
            "SCHED_FIFO 80 on CPU 0, 3, 712 kB locked");
}

TEST(RsiLink, RefusesToStartWithoutTheRealtimeThatIsRequired) {
  Echo echo;
  RsiLinkOptions options = loopback();
  options.priority = 100;  // above what any machine grants
  options.require_realtime = true;
  const auto link = RsiLink::start(options, echo);
  ASSERT_FALSE(link);
  EXPECT_THAT(link.error().text, HasSubstr("LimitRTPRIO"));
  options.require_realtime = false;
  const auto best_effort = RsiLink::start(options, echo);
  ASSERT_TRUE(best_effort) << best_effort.error().text;
  EXPECT_THAT((*best_effort)->refused(), HasSubstr("SCHED_FIFO 100 refused"));
}

}  // namespace
}  // namespace truepose::drivers
