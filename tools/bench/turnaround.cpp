#include <arpa/inet.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/field/gaussian_process.hpp"
#include "core/fit/regression_field.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/math/statistics.hpp"
#include "core/simulate/published_arm.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "drivers/kuka/rsi_link.hpp"

namespace truepose::bench {
namespace {

using std::chrono::nanoseconds;
using Clock = std::chrono::steady_clock;

constexpr int kPriority = 80;
constexpr std::chrono::milliseconds kCycle{4};
constexpr int kSettling =
    500;  // cycles of a round that are not counted: the model is ramped in in 250 of them
constexpr std::uint32_t kLoopback = INADDR_LOOPBACK;

void must(bool done, const char* what) {
  if (!done) throw std::runtime_error{std::string{what} + ": " + std::strerror(errno)};
}

/// All responders on one CPU and the controller on another, so that none has a better neighbour.
std::array<int, 2> cpus() {
  const std::vector<int> all = drivers::scheduling_of(0).cpus;
  return {all.back(), all.front()};
}
const auto [kResponderCpu, kControllerCpu] = cpus();

void enter_realtime(int cpu) {
  if (const auto why = drivers::pin_to(cpu)) throw std::runtime_error{*why};
  const sched_param parameters{.sched_priority = kPriority};
  must(::mlockall(MCL_CURRENT | MCL_FUTURE) == 0, "memory cannot be locked (run as root)");
  must(::sched_setscheduler(0, SCHED_FIFO, &parameters) == 0, "no SCHED_FIFO (run as root)");
}

// ---- The responders ----

RobotModel calibrated_arm() { return with_published_errors(published_arm()); }

/// Gears and gravity in every joint, and a residual field over 300 poses.
RobotModel deviating_arm() {
  constexpr int kPoses = 300;
  RobotModel robot = calibrated_arm();
  for (int joint = 0; joint < robot.joint_count(); ++joint) {
    robot.masses.push_back({.mass_kg = 200.0 / (1 + joint), .centre_mm = {100, 0, 50}});
    for (const int order : {1, 2}) {
      for (const DeviationBasis basis : {DeviationBasis::Sine, DeviationBasis::Cosine})
        robot.deviation.push_back({.joint = joint, .basis = basis, .order = order, .coefficient = 1e-4});
    }
    robot.deviation.push_back({.joint = joint, .basis = DeviationBasis::Gravity, .coefficient = 1e-5});
  }
  Random random{9};
  RegressionData data{.X = Eigen::MatrixXd(kPoses, field_features(robot)), .Y = Eigen::MatrixXd(kPoses, 3)};
  for (double& x : data.X.reshaped()) x = random.uniform(-1, 1);
  for (double& y : data.Y.reshaped()) y = random.uniform(-0.05, 0.05);
  robot.field = std::make_shared<RegressionField>(robot, fit_regressor(kGaussianProcess, data).value(),
                                                  Eigen::Vector3d{60, -50, 190});
  return robot;
}

rsi::EthernetConfig configuration() {
  return daemon::read_ethernet(TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml").value();
}

sockaddr_in loopback(std::uint16_t port) {
  return {.sin_family = AF_INET, .sin_port = htons(port), .sin_addr = {htonl(kLoopback)}};
}

/// Bound to a free port.
struct Socket {
  Socket() {
    sockaddr_in name = loopback(0);
    socklen_t size = sizeof name;
    auto* const address = reinterpret_cast<sockaddr*>(&name);
    must(::bind(descriptor, address, size) == 0 && ::getsockname(descriptor, address, &size) == 0,
         "no UDP port");
    port = ntohs(name.sin_port);
  }
  ~Socket() { ::close(descriptor); }
  Socket(const Socket&) = delete;

  const int descriptor = ::socket(AF_INET, SOCK_DGRAM, 0);
  std::uint16_t port = 0;
};

/// What no answer can be faster than: received and sent back, until an empty datagram comes.
class Echo {
 public:
  Echo() : thread_{[this] { run(); }} {}
  ~Echo() {
    const sockaddr_in to = loopback(socket_.port);
    ::sendto(socket_.descriptor, nullptr, 0, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  Echo(const Echo&) = delete;

  std::uint16_t port() const { return socket_.port; }

 private:
  void run() const {
    enter_realtime(kResponderCpu);
    std::array<char, rsi::kMaxFrameBytes> buffer{};
    for (;;) {
      sockaddr_in from{};
      socklen_t size = sizeof from;
      auto* const address = reinterpret_cast<sockaddr*>(&from);
      const ssize_t bytes = ::recvfrom(socket_.descriptor, buffer.data(), buffer.size(), 0, address, &size);
      if (bytes <= 0) return;
      ::sendto(socket_.descriptor, buffer.data(), static_cast<std::size_t>(bytes), 0, address, size);
    }
  }

  const Socket socket_;
  std::jthread thread_;
};

/// The daemon's realtime thread with a model in effect.
class Stream {
 public:
  explicit Stream(const RobotModel& model) {
    auto options = daemon::StreamOptions::of(config::CellConfig{});
    options.peer = kLoopback;
    options.listening_since = std::chrono::steady_clock::now();
    cycle_ = daemon::StreamCycle::create(published_arm(), configuration(), options).value();
    cycle_->use_model(model, 1);
    cycle_->engage();
    auto link = drivers::RsiLink::start({.address = "127.0.0.1",
                                         .priority = kPriority,
                                         .require_realtime = true,
                                         .cpu = kResponderCpu,
                                         .controller = kLoopback},
                                        *cycle_);
    if (!link) throw std::runtime_error{link.error().text};
    link_ = *std::move(link);
  }

  std::uint16_t port() const { return link_->port(); }

 private:
  std::unique_ptr<daemon::StreamCycle> cycle_;
  std::unique_ptr<drivers::RsiLink> link_;
};

// ---- The controller ----

/// What a responder is sent, and how long its answers take.
class Exchange {
 public:
  explicit Exchange(std::uint16_t port) {
    const sockaddr_in to = loopback(port);
    // The first datagrams of a session are not answered, and what follows a long silence is a new one.
    const timeval patience{.tv_sec = 0, .tv_usec = 4'000};
    must(::connect(socket_.descriptor, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0, "connect");
    must(::setsockopt(socket_.descriptor, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) == 0,
         "socket");
  }

  /// One cycle of a program that stands still at first.
  void cycle(int number, bool counts) {
    const std::string_view frame = write_frame(number);
    std::array<char, rsi::kMaxFrameBytes> answer;
    const Clock::time_point sent = Clock::now();
    ::send(socket_.descriptor, frame.data(), frame.size(), 0);
    const ssize_t bytes = ::recv(socket_.descriptor, answer.data(), answer.size(), 0);
    const nanoseconds took = Clock::now() - sent;
    if (counts && bytes > 0) took_.push_back(took);
    if (counts && bytes <= 0) ++lost_;
    if (bytes <= 0) ++delay_;
    if (bytes > 0) apply({answer.data(), static_cast<std::size_t>(bytes)});
  }

  void sort() { std::ranges::sort(took_); }
  double at_us(double fraction) const {
    const auto rank = static_cast<std::size_t>(fraction * static_cast<double>(took_.size() - 1));
    return std::chrono::duration<double, std::micro>(took_.at(rank)).count();
  }
  int lost() const { return lost_; }
  bool corrected() const { return corrected_; }

 private:
  std::string_view write_frame(int number) {
    constexpr int kStill = 200;
    const double t_s = std::max(0, number - kStill) * 4e-3;
    JointVector q(6);
    q << 0.5 * std::sin(0.4 * t_s), -1.4 + 0.2 * std::sin(0.5 * t_s), 1.6 + 0.2 * std::sin(0.3 * t_s),
        0.5 * std::sin(0.6 * t_s), 0.9 + 0.2 * std::sin(0.7 * t_s), std::sin(0.5 * t_s);
    rsi::RobotFrame frame{.ipoc = 4'208'163 + 4 * static_cast<std::uint64_t>(number), .delay = delay_};
    frame.aspos_rad.emplace();
    frame.aipos_rad.emplace();
    std::ranges::copy(q, frame.aspos_rad->begin());
    const JointVector actual = q + correction_;
    std::ranges::copy(actual, frame.aipos_rad->begin());
    const Eigen::Isometry3d X_BF = forward_kinematics(nominal_, actual);
    const Eigen::Vector3d p_mm = X_BF.translation(), abc_deg = kuka_abc_deg(X_BF.linear());
    frame.rist = {p_mm.x(), p_mm.y(), p_mm.z(), abc_deg.x(), abc_deg.y(), abc_deg.z()};
    frame.rsol = frame.rist;
    return rsi::encode_robot_frame(frame, frame_).value();
  }

  void apply(std::string_view answer) {
    const auto reply = codec_.decode(answer);
    if (!reply) return;  // the echo's
    std::ranges::copy(*reply->axis_correction_rad, correction_.begin());
    corrected_ = reply->gain == 100;
  }

  Socket socket_;
  const RobotModel nominal_ = published_arm();
  const rsi::SensorFrameCodec codec_{configuration()};
  std::array<char, rsi::kMaxFrameBytes> frame_{};
  JointVector correction_ = JointVector::Zero(6);
  std::int64_t delay_ = 0;
  std::vector<nanoseconds> took_;
  int lost_ = 0;
  bool corrected_ = false;
};

void wait_until(Clock::time_point due) {
  const nanoseconds since = due.time_since_epoch();
  const timespec time{.tv_sec = since.count() / 1'000'000'000, .tv_nsec = since.count() % 1'000'000'000};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
  }
}

/// Each responder's datagrams are a cycle apart, and those of the others lie between. Who comes after whom
/// changes.
void run(const std::vector<std::unique_ptr<Exchange>>& exchanges, int cycles) {
  constexpr int kCyclesInOrder = 50;
  std::vector<Exchange*> order;
  for (const auto& exchange : exchanges) order.push_back(exchange.get());
  std::ranges::sort(order);
  Clock::time_point due = Clock::now();
  for (int number = 0; number < kSettling + cycles; ++number) {
    if (number % kCyclesInOrder == 0) std::ranges::next_permutation(order);
    for (Exchange* const exchange : order) {
      due = std::max(due + nanoseconds{kCycle} / std::ssize(order), Clock::now());
      wait_until(due);
      exchange->cycle(number, number >= kSettling);
    }
  }
}

struct Quantile {
  const char* name;
  double fraction, most_times;  // the echo's
};
constexpr std::array kQuantiles{Quantile{"p50", 0.5, 1.2}, Quantile{"p99", 0.99, 1.2},
                                Quantile{"p99.9", 0.999, 2}};

/// Of one responder, over the rounds.
struct Times {
  const char* name;
  std::array<std::vector<double>, kQuantiles.size()> quantiles_us = {};
  double most_us = 0;
  int lost = 0;

  void add(const Exchange& round) {
    for (std::size_t i = 0; i < kQuantiles.size(); ++i)
      quantiles_us[i].push_back(round.at_us(kQuantiles[i].fraction));
    most_us = std::max(most_us, round.at_us(1));
    lost += round.lost();
  }
};

/// Each with sockets and threads of its own.
void run_round(std::span<Times> all, int cycles) {
  static const RobotModel geometric = calibrated_arm(), deviating = deviating_arm();
  // Threads of one process: where a CPU changes from process to process, a virtual machine may take longer
  // for that than for all the rest.
  const Echo bare;
  const Stream of_geometry{geometric}, of_all{deviating};
  std::vector<std::unique_ptr<Exchange>> exchanges;
  for (const std::uint16_t port : {bare.port(), of_geometry.port(), of_all.port()})
    exchanges.push_back(std::make_unique<Exchange>(port));
  run(exchanges, cycles);
  for (std::size_t i = 0; i < all.size(); ++i) {
    exchanges[i]->sort();
    all[i].add(*exchanges[i]);
  }
  if (!exchanges.back()->corrected()) throw std::runtime_error{"the stream did not correct"};
}

/// @return whether the last reached the goals
bool print(std::span<const Times> all) {
  bool reached = true;
  std::printf("| turnaround, us |");
  for (const Quantile& quantile : kQuantiles) std::printf(" %s | to the echo |", quantile.name);
  std::printf(" max | lost |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (const Times& times : all) {
    std::printf("| %s |", times.name);
    reached = true;
    for (std::size_t i = 0; i < kQuantiles.size(); ++i) {
      const double us = median(times.quantiles_us[i]);
      const double to_echo = us / median(all.front().quantiles_us[i]);
      std::printf(" %.1f | %.2fx |", us, to_echo);
      reached = reached && to_echo <= kQuantiles[i].most_times;
    }
    std::printf(" %.0f | %d |\n", times.most_us, times.lost);
  }
  return reached;
}

int main_of(int rounds, int cycles) {
  std::array all{Times{"bare UDP echo"}, Times{"geometric model"},
                 Times{"deviations and field of 300 poses"}};
  enter_realtime(kControllerCpu);
  for (int round = 0; round < rounds; ++round) run_round(all, cycles);
  return print(all) ? 0 : 1;
}

}  // namespace
}  // namespace truepose::bench

/// turnaround [ROUNDS [CYCLES]]
int main(int argc, char** argv) try {
  return truepose::bench::main_of(argc > 1 ? std::atoi(argv[1]) : 9, argc > 2 ? std::atoi(argv[2]) : 1500);
} catch (const std::exception& error) {
  std::fprintf(stderr, "turnaround: %s\n", error.what());
  return 2;
}
