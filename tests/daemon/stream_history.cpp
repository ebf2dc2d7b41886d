#include "tests/daemon/stream_history.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>

#include "core/random.hpp"
#include "tests/daemon/plant.hpp"
#include "tests/daemon/stream_rig.hpp"

namespace truepose::daemon {
namespace {

using drivers::UdpSource;
using test::Count;
using test::Plant;
using test::PlantOptions;

constexpr std::uint32_t kController = 0xC0A82C01;  // 192.168.44.1
constexpr double kGrid_deg = 1e-6;                 // of the wire

/// A program's set points: each axis now stands, now goes at its own speed, by bounded accelerations.
class Program {
 public:
  Program(Random& random, double cycle_s) : random_{random}, cycle_s_{cycle_s} {
    for (const Joint& joint : nominal_arm().joints)
      limits_deg_.push_back({joint.min * kDegPerRad, joint.max * kDegPerRad});
    greatest_deg_s_ = random.uniform() < 0.3 ? 5 : 200;
  }

  const Plant::Axes& next() {
    if (--left_ <= 0) choose();
    for (std::size_t i = 0; i < 6; ++i) {
      if (position_deg_[i] < limits_deg_[i].first + 10) target_deg_s_[i] = std::abs(target_deg_s_[i]);
      if (position_deg_[i] > limits_deg_[i].second - 10) target_deg_s_[i] = -std::abs(target_deg_s_[i]);
      const double most = acceleration_deg_s2_ * cycle_s_;
      speed_deg_s_[i] += std::clamp(target_deg_s_[i] - speed_deg_s_[i], -most, most);
      position_deg_[i] = std::clamp(position_deg_[i] + speed_deg_s_[i] * cycle_s_, limits_deg_[i].first + 1,
                                    limits_deg_[i].second - 1);
    }
    return position_deg_;
  }

 private:
  void choose() {
    left_ = static_cast<int>(random_.uniform() * 0.8 / cycle_s_);
    acceleration_deg_s2_ = std::pow(10, 1.5 + 2 * random_.uniform());
    const bool stands = random_.uniform() < 0.4, one_axis = random_.uniform() < 0.2;
    const auto chosen = static_cast<std::size_t>(random_.uniform() * 6);
    for (std::size_t i = 0; i < 6; ++i) {
      const bool moves = !stands && (one_axis ? i == chosen : random_.uniform() < 0.8);
      target_deg_s_[i] = moves ? greatest_deg_s_ * (2 * random_.uniform() - 1) : 0;
    }
  }

  Random& random_;
  double cycle_s_;
  std::vector<std::pair<double, double>> limits_deg_;
  double greatest_deg_s_ = 0, acceleration_deg_s2_ = 0;
  int left_ = 0;
  Plant::Axes position_deg_{10, -80, 90, 20, 45, -30}, speed_deg_s_{}, target_deg_s_{};
};

/// In memory, and gone when the history ends.
class Page {
 public:
  Page() {
    static int number = 0;
    file_ = std::filesystem::path{"/dev/shm"} /
            ("truepose-history-" + std::to_string(::getpid()) + "-" + std::to_string(++number));
  }
  ~Page() { std::filesystem::remove(file_); }
  std::unique_ptr<StreamMemory> open() const { return StreamMemory::open(file_).value(); }
  void lose() const { std::filesystem::remove(file_); }

 private:
  std::filesystem::path file_;
};

class History {
 public:
  explicit History(std::uint64_t seed)
      : random_{seed},
        plant_options_{random_plant()},
        plant_{plant_options_},
        program_{random_, plant_options_.cycle_ms / 1000},
        config_{random_config()},
        codec_{config_},
        arm_{random_arm()} {
    drives_ = random_.uniform() < 0.15 ? 0 : 1;
    start_daemon();
  }

  StreamHistory run() {
    history_.sessions = 1;
    for (int cycle = 0; cycle < 900; ++cycle) {
      operate();
      happen();
      tick();
    }
    std::ostringstream cell;
    cell << "cycle " << plant_options_.cycle_ms << " ms, dead time " << plant_options_.dead_time_ms
         << " ms, lag " << plant_options_.lag_ms << " ms, Timeout " << plant_options_.timeout_cycles
         << ", Delay " << (plant_options_.delay == Count::Cumulative ? "cumulative" : "consecutive")
         << ", ASPos " << config_.sends("ASPos") << "; " << history_.worst;
    history_.worst = cell.str();
    return history_;
  }

 private:
  double within(double a, double b) { return a + (b - a) * random_.uniform(); }
  bool one_in(double n) { return random_.uniform() * n < 1; }
  std::uint64_t pick(std::uint64_t n) {
    return static_cast<std::uint64_t>(random_.uniform() * static_cast<double>(n));
  }

  PlantOptions random_plant() {
    PlantOptions options;
    options.cycle_ms = one_in(4) ? 12 : 4;
    options.ipoc_step = static_cast<std::uint64_t>(options.cycle_ms);
    const double delay_ms = one_in(5) ? 0 : within(0, 100);
    options.dead_time_ms = delay_ms * random_.uniform();
    options.lag_ms = delay_ms - options.dead_time_ms;
    options.timeout_cycles = static_cast<int>(std::pow(10, within(1, 4)));
    options.delay = one_in(2) ? Count::Cumulative : Count::Consecutive;
    return options;
  }

  rsi::EthernetConfig random_config() {
    rsi::EthernetConfig config = ethernet_config();
    if (one_in(6))
      std::erase_if(config.send, [](const rsi::Element& element) { return element.tag == "DEF_ASPos"; });
    return config;
  }

  RobotModel random_arm() {
    RobotModel arm = nominal_arm();
    const double size_deg = one_in(3) ? 0.05 : within(0.2, 2.5);
    for (Joint& joint : arm.joints) {
      joint.theta_rad += within(-size_deg, size_deg) * kRadPerDeg;
      joint.a_mm += within(-1, 1);
      joint.d_mm += within(-1, 1);
    }
    return arm;
  }

  void start_daemon() {
    memory_ = page_.open();
    StreamOptions options;
    options.max_step_rad = 0.02 * kRadPerDeg;
    options.max_total_rad = 3 * kRadPerDeg;
    options.limit_margin_rad = 1 * kRadPerDeg;
    options.singular_below_rad = 20 * kRadPerDeg;
    options.cycle = std::chrono::milliseconds{static_cast<int>(plant_options_.cycle_ms)};
    options.ramp_cycles = static_cast<int>(1000 / plant_options_.cycle_ms);
    options.timeout_cycles = plant_options_.timeout_cycles;
    options.disarm_after.reset();
    options.peer = kController;
    now = now_;
    options.now = []() noexcept { return now; };
    cycle_ = StreamCycle::create(nominal_arm(), config_, options, memory_.get()).value();
    cycle_->use_model(arm_, 1);
    if (drives_) cycle_->engage();
  }

  void operate() {
    if (one_in(400)) cycle_->engage();
    if (one_in(1500)) cycle_->disengage();
    if (one_in(100)) cycle_->acknowledge();
    if (one_in(800)) cycle_->use_model(arm_ = random_arm(), 2 + pick(100));
  }

  void happen() {
    if (one_in(250)) datagrams_lost_ = loss();
    if (one_in(250)) replies_lost_ = loss();
    if (one_in(300)) daemon_down_ = pick(one_in(3) ? 120 : 15) + 1;
    if (one_in(300)) foreign_cycles_ = pick(60);
    if (one_in(350)) restart_controller();
    if (daemon_down_ > 0 && --daemon_down_ == 0) {
      ++history_.restarts;
      cycle_.reset();
      memory_.reset();
      if (one_in(8)) page_.lose();  // the machine was restarted
      start_daemon();
    }
  }

  std::uint64_t loss() { return static_cast<std::uint64_t>(std::pow(10, within(0, 2.3))); }

  void restart_controller() {
    const auto shortest = static_cast<int>(std::ceil(40 / plant_options_.cycle_ms));
    Plant::Restart restart{.pause_cycles = shortest + static_cast<int>(std::pow(10, within(0, 2.3))),
                           .ipoc = {},
                           .source_port = {},
                           .arm_settled = one_in(2)};
    if (one_in(3)) restart.ipoc = pick(1'000'000'000);
    if (one_in(3)) restart.source_port = static_cast<std::uint16_t>(50'000 + pick(10'000));
    plant_.restart_session(restart);
    ++history_.sessions;
  }

  void tick() {
    now_ += std::chrono::milliseconds{static_cast<int>(plant_options_.cycle_ms)};
    if (foreign_cycles_ > 0) --foreign_cycles_, send_foreign();
    const auto sent = plant_.begin_cycle(program_.next());
    if (!sent) {
      if (!plant_.alive() && one_in(50)) restart_controller();
      return;
    }
    ++history_.cycles;
    const bool lost = daemon_down_ > 0 || (datagrams_lost_ > 0 && datagrams_lost_-- > 0);
    if (!lost) {
      ++history_.heard;
      exchange(*sent);
    }
    judge(plant_.end_cycle());
    before_ = *sent;
  }

  void exchange(const Plant::Sent& sent) {
    const UdpSource source{kController, sent.source_port};
    if (one_in(200) && before_) deliver(frame(*before_), {kController, before_->source_port});  // overtaken
    if (one_in(300)) deliver(damaged(frame(sent)), source);
    deliver(frame(sent), source);
    if (one_in(300)) deliver(frame(sent), source);
  }

  void deliver(const std::string& bytes, const UdpSource& source) {
    now = now_ + std::chrono::microseconds{pick(900)};
    const std::string_view reply = cycle_->answer({bytes, source, now});
    if (reply.empty() || (replies_lost_ > 0 && replies_lost_-- > 0)) return;
    const auto decoded = codec_.decode(reply);
    if (!decoded) return;
    Plant::Axes correction_deg;
    for (std::size_t i = 0; i < 6; ++i) correction_deg[i] = (*decoded->axis_correction_rad)[i] * kDegPerRad;
    if (source.address == kController && plant_.take_reply(decoded->ipoc, correction_deg))
      ++history_.answered;
  }

  /// Another controller, or somebody who knows the time stamps: plausible frames from the wrong address or
  /// port.
  void send_foreign() {
    const auto count = pick(4);
    for (std::uint64_t i = 0; i < count && cycle_ && daemon_down_ == 0; ++i) {
      Plant::Sent forged = before_.value_or(Plant::Sent{});
      forged.ipoc += pick(3) * plant_options_.ipoc_step + (one_in(2) ? 0 : 1'000'000'000);
      if (one_in(2)) forged.aipos_deg = forged.aspos_deg;
      ++history_.foreign;
      // From the controller's own address only while that is heard: when it is silent, whoever speaks is
      // heard.
      const bool heard = datagrams_lost_ == 0 && before_ && plant_.alive();
      deliver(frame(forged),
              one_in(2) && heard
                  ? UdpSource{kController, static_cast<std::uint16_t>(before_->source_port + 1)}
                  : UdpSource{kController + 1, before_ ? before_->source_port : std::uint16_t{1}});
    }
  }

  std::string frame(const Plant::Sent& sent) {
    rsi::RobotFrame frame;
    frame.ipoc = sent.ipoc;
    frame.delay = sent.delay;
    frame.aipos_rad.emplace();
    frame.aspos_rad.emplace();
    for (std::size_t i = 0; i < 6; ++i) {
      (*frame.aipos_rad)[i] = sent.aipos_deg[i] * kRadPerDeg;
      (*frame.aspos_rad)[i] = sent.aspos_deg[i] * kRadPerDeg;
    }
    if (!config_.sends("ASPos")) frame.aspos_rad.reset();
    std::array<char, rsi::kMaxFrameBytes> buffer;
    return std::string{rsi::encode_robot_frame(frame, buffer, 4).value()};
  }

  std::string damaged(std::string bytes) {
    if (one_in(2)) return bytes.substr(0, pick(bytes.size()));
    bytes[pick(bytes.size())] = "<>/= x"[pick(6)];  // a checksum keeps other digits away
    return bytes;
  }

  void judge(const Plant::State& state) {
    const double step = (state.step_deg - kGrid_deg) / 0.02;
    for (const double axis_deg : state.in_force_deg)
      history_.greatest_correction_deg = std::max(history_.greatest_correction_deg, std::abs(axis_deg));
    if (step <= history_.greatest_step) return;
    history_.greatest_step = step;
    std::ostringstream text;
    text << state.step_deg << " deg in cycle " << history_.cycles << ", session " << history_.sessions
         << ", daemon " << history_.restarts + 1 << ", A1 in force " << state.in_force_deg[0];
    history_.worst = text.str();
  }

  inline static drivers::TimePoint now;  // of the daemon's clock

  Random random_;
  PlantOptions plant_options_;
  Plant plant_;
  Program program_;
  rsi::EthernetConfig config_;
  rsi::SensorFrameCodec codec_;
  RobotModel arm_;
  bool drives_ = true;
  drivers::TimePoint now_{std::chrono::hours{1}};
  Page page_;
  std::unique_ptr<StreamMemory> memory_;
  std::unique_ptr<StreamCycle> cycle_;
  std::uint64_t datagrams_lost_ = 0, replies_lost_ = 0, daemon_down_ = 0, foreign_cycles_ = 0;
  std::optional<Plant::Sent> before_;
  StreamHistory history_;
};

}  // namespace

StreamHistory stream_history(std::uint64_t seed) { return History{seed}.run(); }

}  // namespace truepose::daemon
