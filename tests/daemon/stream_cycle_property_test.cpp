#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include "tests/daemon/stream_rig.hpp"

namespace truepose::daemon {
namespace {

/// A cell in which everything goes wrong that can, in an order that the seed decides.
class Chaos {
 public:
  explicit Chaos(std::uint64_t seed) : random_{seed} {}

  void run(int ticks) {
    for (int i = 0; i < ticks && !testing::Test::HasFailure(); ++i) {
      operate();
      move();
      exchange();
    }
  }

  StreamRig rig;

 private:
  int pick(int n) { return std::uniform_int_distribution{0, n - 1}(random_); }
  bool one_in(int n) { return pick(n) == 0; }
  double within(double limit) { return std::uniform_real_distribution{-limit, limit}(random_); }

  void operate() {
    if (one_in(200)) rig.cycle->engage();
    if (one_in(600)) rig.cycle->disengage();
    if (one_in(300)) rig.cycle->acknowledge();
    if (one_in(250)) rig.cycle->use_model(real_arm(within(4)), static_cast<std::uint64_t>(1 + pick(1000)));
    if (one_in(2000)) rig.cycle->use_no_model();
    if (one_in(1500)) {
      RobotModel broken = real_arm();
      broken.joints[static_cast<std::size_t>(pick(6))].alpha_rad = std::numeric_limits<double>::quiet_NaN();
      rig.cycle->use_model(broken, 7);
    }
  }

  void move() {
    if (one_in(100)) {
      for (double& speed : velocity_) speed = within(0.3 * kRadPerDeg);
    }
    const RobotModel arm = nominal_arm();
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Joint& joint = arm.joints[static_cast<std::size_t>(i)];
      if (rig.q[i] + velocity_[i] < joint.min || rig.q[i] + velocity_[i] > joint.max)
        velocity_[i] = -velocity_[i];
      rig.q[i] += velocity_[i];
    }
  }

  void exchange() {
    if (one_in(400)) {  // silence, then the program is started anew
      rig.restart(one_in(2) ? static_cast<std::uint64_t>(pick(1'000'000))
                            : rig.ipoc + 4 * static_cast<std::uint64_t>(20 + pick(500)));
    }
    if (one_in(300)) {  // a burst of lost datagrams
      for (int lost = pick(30); lost > 0; --lost) rig.tick({.datagram_lost = true});
    }
    switch (pick(40)) {
      case 0:
        rig.tick({.datagram_lost = true});
        break;
      case 1:
        rig.tick({.reply_lost = true});
        break;
      case 2:
        rig.tick({.rejected = true});
        break;
      case 3:
        rig.tick({.replaced_by = damaged()});
        break;
      case 4:
        rig.send(damaged());
        rig.tick();
        break;
      case 5: {
        const std::string reply = rig.tick();
        EXPECT_EQ(rig.send(rig.datagram()), reply) << "a repeated datagram";
        break;
      }
      default: {
        const auto silent = [&] {
          const StreamCounters c = rig.status().counters;
          return c.unproven + c.wrong_ipoc;
        };
        const std::uint64_t before = silent();
        const std::string reply = rig.tick();
        ASSERT_EQ(reply.empty(), silent() > before);
        if (!reply.empty()) {
          EXPECT_EQ(rig.decode(reply).ipoc, rig.ipoc);
        }
      }
    }
  }

  std::string damaged() {
    std::string bytes = rig.datagram();
    switch (pick(3)) {
      case 0:
        return bytes.substr(0, static_cast<std::size_t>(pick(static_cast<int>(bytes.size()))) + 1);
      case 1:
        for (int i = pick(4) + 1; i > 0; --i) {
          bytes[static_cast<std::size_t>(pick(static_cast<int>(bytes.size())))] =
              static_cast<char>(pick(256));
        }
        return bytes;
      default:
        for (char& byte : bytes) byte = static_cast<char>(pick(256));
        return bytes;
    }
  }

  std::mt19937_64 random_;
  JointVector velocity_ = JointVector::Zero(6);
};

// The rig fails the test on any reply that the controller takes and that moves an axis by more than a step.
TEST(StreamCycleProperty, NoAxisEverMovesByMoreThanAStepWhateverHappens) {
  std::uint64_t sessions = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Chaos chaos{seed};
    chaos.run(2000);
    const StreamStatus status = chaos.rig.status();
    const StreamCounters& c = status.counters;
    EXPECT_EQ(c.datagrams, c.answered + c.held + c.duplicate + c.wrong_ipoc + c.unproven + c.unanswered);
    EXPECT_LE(status.max_step_deg, 0.02 + 1e-9);
    EXPECT_LE(chaos.rig.largest_applied_deg(), 3 + 1e-9);
    sessions += c.sessions;
    if (HasFailure()) return;
  }
  EXPECT_GT(sessions, 24u) << "the controller was started anew too rarely to try anything";
}

TEST(StreamCycleProperty, ComesToExactlyZeroAfterAnyHistory) {
  for (std::uint64_t seed = 101; seed <= 104; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Chaos chaos{seed};
    chaos.run(1000);
    chaos.rig.cycle->disengage();
    chaos.rig.cycle->acknowledge();
    chaos.rig.ticks(1200);
    EXPECT_TRUE(chaos.rig.applied.isZero(0));
    EXPECT_EQ(chaos.rig.state(), StreamState::Idle) << reason(chaos.rig.status());
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace truepose::daemon
