#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/math/angles.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

inline JointVector axes_deg(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  std::transform(values.begin(), values.end(), q.begin(), [](double deg) { return deg * kRadPerDeg; });
  return q;
}

/// A KUKA arm with the lengths of a KR 210 R2700-2.
inline RobotModel nominal_arm() {
  constexpr double kRight = std::numbers::pi / 2;
  constexpr double kDeg = kRadPerDeg;
  RobotModel robot;
  robot.name = "KR 210 R2700-2";
  robot.joints = {
      {.d_mm = 645, .sign = -1, .min = -185 * kDeg, .max = 185 * kDeg},
      {.a_mm = 330, .alpha_rad = -kRight, .min = -140 * kDeg, .max = -5 * kDeg},
      {.a_mm = 1150, .theta_rad = -kRight, .min = -120 * kDeg, .max = 168 * kDeg},
      {.a_mm = 115, .alpha_rad = kRight, .d_mm = -1220, .min = -350 * kDeg, .max = 350 * kDeg},
      {.alpha_rad = -kRight, .min = -125 * kDeg, .max = 125 * kDeg},
      {.alpha_rad = kRight, .d_mm = -215, .min = -350 * kDeg, .max = 350 * kDeg},
  };
  return robot;
}

/// The arm as it was really built: `scale` 1 asks for corrections of some hundredths of a degree.
inline RobotModel real_arm(double scale = 1) {
  RobotModel robot = nominal_arm();
  double sign = scale;
  for (Joint& joint : robot.joints) {
    joint.a_mm += 0.4 * sign;
    joint.d_mm -= 0.3 * sign;
    joint.theta_rad += 0.0005 * sign;
    joint.alpha_rad -= 0.0002 * sign;
    sign = -sign;
  }
  return robot;
}

inline rsi::EthernetConfig shipped_ethernet_config() {
  std::ifstream file{TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml"};
  std::ostringstream text;
  text << file.rdbuf();
  return rsi::parse_ethernet_config(text.str()).value();
}

/// As the rig's controller has it: without RIst, which only those tests send that are about it.
inline rsi::EthernetConfig ethernet_config() {
  rsi::EthernetConfig config = shipped_ethernet_config();
  std::erase_if(config.send, [](const rsi::Element& element) { return element.tag == "DEF_RIst"; });
  return config;
}

inline StreamOptions stream_options() { return StreamOptions::of(config::CellConfig{}); }

/// What happens to one exchange.
struct Fate {
  bool datagram_lost = false;
  bool reply_lost = false;
  bool rejected = false;      ///< the controller discards the reply as wrong
  std::string replaced_by{};  ///< what arrives instead of the datagram, where not empty
};

/// A controller in virtual time with a standing or moving program: sends, takes replies, applies them with
/// HOLDON, counts late ones, and fails the test when a reply that it takes would move an axis by more than a
/// step.
class StreamRig {
 public:
  explicit StreamRig(const StreamOptions& options = stream_options(),
                     const rsi::EthernetConfig& config = ethernet_config(), StreamMemory* memory = nullptr)
      : max_step_deg_{options.max_step_rad * kDegPerRad},
        cycle{StreamCycle::create(nominal_arm(), config, options, memory).value()},
        codec_{config},
        sends_aspos_{config.sends("ASPos")},
        holds_stop_{std::ranges::any_of(config.receive, [&](const rsi::Element& element) {
          return element.tag == config.stop && element.hold_on;
        })} {}

  /// One tick of the controller. @return the reply, empty where there was none
  std::string tick(const Fate& fate = {}) {
    ipoc += step;
    now_ += std::chrono::milliseconds{std::max<std::uint64_t>(step, 4)};
    std::string reply;
    if (!fate.datagram_lost) reply = send(fate.replaced_by.empty() ? datagram() : fate.replaced_by);
    if (reply.empty() || fate.reply_lost || fate.rejected || !take(reply)) {
      ++delay;
      stop = stop && holds_stop_;
    }
    return reply;
  }

  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }

  /// The controller's program is restarted: no correction, a new time stamp.
  void restart(std::uint64_t new_ipoc) {
    pass(std::chrono::milliseconds{200});
    ipoc = new_ipoc;
    delay = 0;
    applied.setZero();
  }

  std::string send(const std::string& bytes) { return send(bytes, source); }
  std::string send(const std::string& bytes, const drivers::UdpSource& from) {
    sent.emplace_back(bytes, now_);
    drivers::RsiResponder& responder = in_front ? *in_front : *cycle;
    const std::string reply{responder.answer({bytes, from, now_})};
    responder.finish(
        {now_, now_ + woken, now_ + woken + computed, now_ + woken + computed, computed, !reply.empty()});
    return reply;
  }

  /// For who keeps the time himself.
  void set_time(drivers::TimePoint now) { now_ = now; }
  /// Nothing is sent for a while.
  void pass(drivers::Duration time) { now_ += time; }

  /// The first cycles of a session, which show what is in effect; not answered.
  void settle() { ticks(4); }

  std::string datagram() const {
    rsi::RobotFrame frame;
    frame.ipoc = ipoc;
    if (sends_delay) frame.delay = delay;
    frame.rist = rist;
    frame.program = program;
    const JointVector actual = stuck ? *stuck : JointVector{q + applied};
    if (sends_aipos) {
      frame.aipos_rad.emplace();
      std::copy(actual.begin(), actual.end(), frame.aipos_rad->begin());
    }
    if (sends_aspos_) {
      frame.aspos_rad.emplace();
      std::copy(q.begin(), q.end(), frame.aspos_rad->begin());
    }
    std::array<char, rsi::kMaxFrameBytes> buffer;
    return std::string{rsi::encode_robot_frame(frame, buffer, 9).value()};
  }

  rsi::SensorFrame decode(const std::string& reply) const { return codec_.decode(reply).value(); }

  StreamStatus status() const { return cycle->status(); }
  StreamState state() const { return status().state; }

  double largest_applied_deg() const { return applied.cwiseAbs().maxCoeff() * kDegPerRad; }

 private:
  bool take(const std::string& reply) {
    const rsi::SensorFrame frame = decode(reply);
    if (frame.ipoc != ipoc) return false;
    stop = frame.stop.value_or(false);
    gain = frame.gain;
    for (std::size_t i = 0; i < 6; ++i) {
      const double value = (*frame.axis_correction_rad)[i];
      double& axis = applied[static_cast<Eigen::Index>(i)];
      EXPECT_LE(std::abs(value - axis) * kDegPerRad, max_step_deg_ + 1e-9)
          << "axis " << i + 1 << ", IPOC " << ipoc;
      axis = value;
    }
    return true;
  }

  double max_step_deg_;
  drivers::TimePoint now_{std::chrono::seconds{1}};

 public:
  std::unique_ptr<StreamCycle> cycle;
  std::vector<std::pair<std::string, drivers::TimePoint>> sent;  ///< all datagrams
  drivers::RsiResponder* in_front = nullptr;  ///< takes the cycle's datagrams, where there is one
  drivers::UdpSource source{0x7f000001, 40'000};
  std::optional<rsi::CartesianPose> rist;  ///< sent where it is set
  rsi::ProgramSignals program;
  std::optional<std::int64_t> gain;  ///< as in the last reply
  bool sends_delay = true, sends_aipos = true;
  std::uint64_t ipoc = 4'208'163;
  std::uint64_t step = 4;
  std::int64_t delay = 0;
  JointVector q = axes_deg({10, -80, 90, 20, 45, -30});  ///< what the program commands
  JointVector applied = JointVector::Zero(6);            ///< the correction that moves the arm
  std::optional<JointVector> stuck;                      ///< where the arm stands, if it does not follow
  drivers::Duration woken{0},
      computed{0};    ///< how long the daemon takes to read a datagram, and to answer it
  bool stop = false;  ///< the controller was asked to leave RSI_MOVECORR

 private:
  rsi::SensorFrameCodec codec_;
  bool sends_aspos_;
  bool holds_stop_;
};

}  // namespace truepose::daemon
