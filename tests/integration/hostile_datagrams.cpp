#include "tests/integration/hostile_datagrams.hpp"

#include <array>

#include "core/math/angles.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose {
namespace {

constexpr std::size_t kLarge = 60'000;    // a datagram has no more than 65,507
constexpr std::uint64_t kGuess_ms = 400;  // by so much a forged time stamp is off at most
constexpr double kGuess_deg = 30;         // and forged axes
constexpr std::array<double, 6> kAround_deg{0, -80, 90, 0, 45, 0};  // where the demo's program moves

std::string repeated(const std::string& text, std::size_t times) {
  std::string all;
  while (times-- > 0) all += text;
  return all;
}

}  // namespace

HostileDatagrams::HostileDatagrams(std::uint64_t seed, std::uint64_t ipoc, Clock::time_point then)
    : random_{seed}, ipoc_{ipoc}, then_{then} {
  const std::string frame = forged();
  const std::size_t number = frame.find("A1=\"") + 4;
  prepared_ = {random_bytes(300),
               "",
               random_bytes(kLarge),
               repeated("<a>", 10'000) + repeated("</a>", 7'000),
               frame.substr(0, number),
               frame.substr(0, frame.size() - 1),
               frame.substr(0, number) + "NaN" + frame.substr(frame.find('"', number)),
               frame.substr(0, number) + "1e999" + frame.substr(frame.find('"', number)),
               frame + frame,
               "<Rob Type=\"KUKA\">" + repeated("<Digin>1</Digin>", 3'700) + "</Rob>"};
}

const std::string& HostileDatagrams::next() {
  // Every other one is a frame that differs from the controller's by its sender alone.
  const std::size_t turn = turn_++;
  if (turn % 2 == 1) return prepared_[turn / 2 % prepared_.size()];
  forged_ = turn % 8 == 0 ? damaged(forged()) : forged();
  return forged_;
}

std::string HostileDatagrams::random_bytes(std::size_t size) {
  std::string bytes(size, ' ');
  for (char& byte : bytes) byte = static_cast<char>(random_.next() & 0xff);
  return bytes;
}

std::string HostileDatagrams::forged() {
  const auto passed_ms = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - then_).count();
  const auto guess = static_cast<std::uint64_t>(random_.uniform() * 2 * kGuess_ms);
  rsi::RobotFrame frame;
  frame.ipoc = (ipoc_ + static_cast<std::uint64_t>(passed_ms) + guess - kGuess_ms) / 4 * 4 + ipoc_ % 4;
  frame.delay = 0;
  frame.aipos_rad.emplace();
  for (std::size_t i = 0; i < 6; ++i)
    (*frame.aipos_rad)[i] = (kAround_deg[i] + kGuess_deg * (2 * random_.uniform() - 1)) * kRadPerDeg;
  frame.aspos_rad = frame.aipos_rad;  // as if nothing were in effect
  std::array<char, rsi::kMaxFrameBytes> buffer;
  return std::string{rsi::encode_robot_frame(frame, buffer).value()};
}

std::string HostileDatagrams::damaged(std::string frame) {
  frame[static_cast<std::size_t>(random_.uniform() * static_cast<double>(frame.size()))] =
      static_cast<char>(random_.next() & 0xff);
  return frame;
}

}  // namespace truepose
