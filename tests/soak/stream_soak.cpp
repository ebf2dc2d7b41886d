#include "tests/soak/stream_soak.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/random.hpp"
#include "tests/daemon/stream_rig.hpp"
#include "tests/soak/event_hash.hpp"

namespace truepose::soak {

namespace {

using daemon::Fate;
using daemon::StreamRig;

/// A shift of production on one stream. The rig fails the test where an axis moves by more than a step.
class Shift {
 public:
  explicit Shift(std::uint64_t seed) : random_{seed} {
    rig_.cycle->use_model(daemon::real_arm(), 1);
    rig_.cycle->engage();
  }

  StreamSoak run(double hours) {
    const auto cycles = static_cast<std::uint64_t>(hours * 3600 / 0.004);
    StreamSoak soak;
    for (; soak.cycles < cycles && !testing::Test::HasFailure(); ++soak.cycles) {
      operate();
      move();
      exchange();
    }
    check();
    const daemon::StreamStatus status = rig_.status();
    soak.hours = static_cast<double>(soak.cycles) * 0.004 / 3600;
    soak.answered = status.counters.answered;
    soak.held = status.counters.held;
    soak.lost = status.counters.lost;
    soak.sessions = status.counters.sessions;
    soak.max_step_deg = status.max_step_deg;
    soak.hash = hash_.value();
    return soak;
  }

 private:
  bool happens(double per_hour) { return random_.uniform() < per_hour * 0.004 / 3600; }
  double within(double limit) { return limit * (2 * random_.uniform() - 1); }
  std::size_t pick(std::size_t count) {
    return static_cast<std::size_t>(random_.uniform() * static_cast<double>(count));
  }

  void operate() {
    if (happens(60)) rig_.cycle->use_model(daemon::real_arm(within(4)), 1 + pick(1000));
    if (happens(20)) rig_.cycle->disengage();
    if (happens(600)) rig_.cycle->engage();
    if (happens(3600)) rig_.cycle->acknowledge();
    // The program is stopped for a while, then selected and started anew.
    if (happens(40)) rig_.restart(rig_.ipoc + 4 * (20 + pick(50000)));
  }

  void move() {
    if (happens(3600)) {
      for (double& speed : velocity_) speed = within(0.2 * kRadPerDeg);
    }
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Joint& joint = arm_.joints[static_cast<std::size_t>(i)];
      if (rig_.q[i] + velocity_[i] < joint.min || rig_.q[i] + velocity_[i] > joint.max)
        velocity_[i] = -velocity_[i];
      rig_.q[i] += velocity_[i];
    }
  }

  void exchange() {
    unanswered_ = left_unanswered();
    const double fate = random_.uniform();
    if (fate < 0.002) {
      for (std::size_t lost = pick(20); lost > 0; --lost) rig_.tick({.datagram_lost = true});
    } else if (fate < 0.004) {
      tell(rig_.tick({.reply_lost = true}));
    } else if (fate < 0.006) {
      tell(rig_.tick({.replaced_by = damaged()}));
    } else if (fate < 0.008) {
      const std::string reply = rig_.tick();
      EXPECT_EQ(rig_.send(rig_.datagram()), reply) << "a repeated datagram is given the same reply";
      tell(reply);
    } else {
      const std::string reply = rig_.tick();
      EXPECT_TRUE(!reply.empty() || left_unanswered() > unanswered_) << "IPOC " << rig_.ipoc;
      tell(reply);
      if (!reply.empty() && rig_.decode(reply).ipoc != rig_.ipoc)
        ADD_FAILURE() << "wrong IPOC after " << rig_.ipoc;
    }
    if (++since_check_ == 1000) check();
  }

  /// On purpose: where what is in force is not known, or the time stamp does not follow.
  std::uint64_t left_unanswered() const {
    const daemon::StreamCounters counters = rig_.status().counters;
    return counters.unproven + counters.wrong_ipoc;
  }

  void check() {
    since_check_ = 0;
    const daemon::StreamStatus status = rig_.status();
    const daemon::StreamCounters& c = status.counters;
    EXPECT_EQ(c.datagrams, c.answered + c.held + c.duplicate + c.wrong_ipoc + c.unproven + c.unanswered)
        << "a datagram is in no counter, or in two";
    EXPECT_LE(rig_.largest_applied_deg(), 3 + 1e-9);
    EXPECT_LE(status.max_step_deg, 0.02 + 1e-9);
  }

  std::string damaged() {
    std::string bytes = rig_.datagram();
    if (random_.uniform() < 0.5) return bytes.substr(0, 1 + pick(bytes.size() - 1));
    bytes[pick(bytes.size())] = static_cast<char>(pick(256));
    return bytes;
  }

  void tell(const std::string& reply) { hash_.add(reply); }

  Random random_;
  StreamRig rig_;
  const RobotModel arm_ = daemon::nominal_arm();
  JointVector velocity_ = JointVector::Zero(6);
  int since_check_ = 0;
  std::uint64_t unanswered_ = 0;  // before this exchange
  EventHash hash_;
};

}  // namespace

StreamSoak soak_stream(std::uint64_t seed, double hours) { return Shift{seed}.run(hours); }

}  // namespace truepose::soak
