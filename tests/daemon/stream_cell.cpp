#include "tests/daemon/stream_cell.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "tests/daemon/stream_rig.hpp"

namespace truepose::daemon {
namespace {

using drivers::UdpSource;
using test::Count;
using test::Plant;
using test::PlantOptions;

constexpr std::uint32_t kController = 0xC0A82C01;  // 192.168.44.1
constexpr double kGrid_deg = 1e-6;                 // of the wire
constexpr double kMaxStep_deg = 0.02, kMaxTotal_deg = 3;
constexpr std::chrono::milliseconds kDisarmAfter{400};
constexpr std::size_t kReceiveBuffer =
    250;  // datagrams that the kernel keeps for a process that does not run

}  // namespace

StreamPage::StreamPage() {
  static int number = 0;
  file_ = std::filesystem::path{"/dev/shm"} /
          ("truepose-stream-" + std::to_string(::getpid()) + "-" + std::to_string(++number));
}

StreamCell::StreamCell(std::uint64_t seed, const StreamCellOptions& options)
    : options_{options},
      random_{seed},
      plant_options_{random_plant()},
      plant_{plant_options_},
      program_{random_, plant_options_.cycle_ms / 1000},
      config_{random_config()},
      codec_{config_},
      arm_{random_arm()},
      armed_{options.rearms && seed % 3 == 0},
      program_random_{~seed} {
  if (options_.waits && one_in(2)) patience_ = std::chrono::seconds{1};
  drives_ = random_.uniform() < 0.15 ? 0 : 1;
  history_.sessions = 1;
  start_daemon();
}

StreamHistory StreamCell::history() const {
  StreamHistory history = history_;
  std::ostringstream cell;
  cell << "cycle " << plant_options_.cycle_ms << " ms, dead time " << plant_options_.dead_time_ms
       << " ms, lag " << plant_options_.lag_ms << " ms, Timeout " << plant_options_.timeout_cycles
       << ", Delay " << (plant_options_.delay == Count::Cumulative ? "cumulative" : "consecutive")
       << ", ASPos " << config_.sends("ASPos") << "; " << history.worst;
  history.worst = cell.str();
  return history;
}

void StreamHistory::add(const StreamHistory& other) {
  cycles += other.cycles;
  heard += other.heard;
  answered += other.answered;
  sessions += other.sessions;
  restarts += other.restarts;
  stalls += other.stalls;
  silences += other.silences;
  foreign += other.foreign;
  greatest_step = std::max(greatest_step, other.greatest_step);
  greatest_correction_deg = std::max(greatest_correction_deg, other.greatest_correction_deg);
}

std::optional<StreamStatus> StreamCell::status() const {
  if (!daemon_runs()) return std::nullopt;
  return cycle_->status();
}

PlantOptions StreamCell::random_plant() {
  PlantOptions options;
  options.cycle_ms = one_in(4) ? 12 : 4;
  if (options_.cycle_ms) options.cycle_ms = *options_.cycle_ms;
  options.ipoc_step = static_cast<std::uint64_t>(options.cycle_ms);
  const double delay_ms = one_in(5) ? 0 : within(0, 100);
  options.dead_time_ms = delay_ms * random_.uniform();
  options.lag_ms = delay_ms - options.dead_time_ms;
  options.timeout_cycles = static_cast<int>(std::pow(10, within(1, 4)));
  options.delay = one_in(2) ? Count::Cumulative : Count::Consecutive;
  if (options_.waits) {
    options.ipoc_step =
        one_in(2) ? 1 : options.ipoc_step;  // it counts replies, or the time that they stand for
    options.first_ipoc = one_in(2) ? 0 : options.first_ipoc;
  }
  return options;
}

rsi::EthernetConfig StreamCell::random_config() {
  rsi::EthernetConfig config = ethernet_config();
  if (one_in(6))
    std::erase_if(config.send, [](const rsi::Element& element) { return element.tag == "DEF_ASPos"; });
  return config;
}

RobotModel StreamCell::random_arm() {
  RobotModel arm = nominal_arm();
  const double size_deg = one_in(3) ? 0.05 : within(0.2, 2.5);
  for (Joint& joint : arm.joints) {
    joint.theta_rad += within(-size_deg, size_deg) * kRadPerDeg;
    joint.a_mm += within(-1, 1);
    joint.d_mm += within(-1, 1);
  }
  return arm;
}

RobotModel StreamCell::unusable_arm() {
  RobotModel arm = nominal_arm();
  arm.joints[pick(arm.joints.size())].alpha_rad = std::numeric_limits<double>::quiet_NaN();
  return arm;
}

std::uint64_t StreamCell::gap() {
  return static_cast<std::uint64_t>(std::pow(10, within(0, std::log10(options_.longest_gap_cycles))));
}

// ---- The daemon and who serves it ----

void StreamCell::start_daemon() {
  memory_ = page_.open();
  StreamOptions options;
  options.max_step_rad = kMaxStep_deg * kRadPerDeg;
  options.max_total_rad = kMaxTotal_deg * kRadPerDeg;
  options.limit_margin_rad = 1 * kRadPerDeg;
  options.singular_below_rad = 20 * kRadPerDeg;
  options.cycle = std::chrono::milliseconds{static_cast<int>(plant_options_.cycle_ms)};
  options.ramp_cycles = static_cast<int>(1000 / plant_options_.cycle_ms);
  options.timeout_cycles = plant_options_.timeout_cycles;
  options.disarm_after.reset();
  if (!options_.rearms) options.disarm_after = kDisarmAfter;
  options.peer = kController;
  options.never_corrected = !corrected_before_;
  options.listening_since = now_;
  cycle_ = StreamCycle::create(nominal_arm(), config_, options, memory_.get()).value();
  cycle_->use_model(arm_, 1);
  given_ = foreign_given_ = replied_ = 0;
  heard_before_ = engaged_since_heard_ = disarmed_ = false;
  if (drives_) engage_or_arm();
}

void StreamCell::end_daemon() {
  check();
  ++history_.restarts;
  backlog_.clear();
  stalled_cycles_ = 0;
  cycle_.reset();
  memory_.reset();
}

void StreamCell::operate() {
  if (seldom(400)) engage();
  if (seldom(1500)) cycle_->disengage();
  if (seldom(100)) cycle_->acknowledge();
  if (seldom(800)) cycle_->use_model(arm_ = random_arm(), 2 + pick(100));
  if (seldom(6000)) cycle_->use_no_model();
  if (seldom(6000)) cycle_->use_model(unusable_arm(), 1);
}

void StreamCell::engage_or_arm() {
  corrected_before_ = true;
  armed_ ? cycle_->arm() : cycle_->engage();
}

void StreamCell::engage() {
  engage_or_arm();
  engaged_since_heard_ = true;
  disarmed_ = false;
}

/// The program of an armed cell begins and ends, and is stopped and resumed.
void StreamCell::signal() {
  const auto seldom = [this](double cycles) {
    return program_random_.uniform() * cycles * options_.rarity < 1;
  };
  if (!armed_) return;
  if (!signals_.ask || seldom(600)) signals_.ask = program_random_.uniform() < 0.75;
  if (!signals_.state || seldom(600)) signals_.state = program_random_.uniform() < 0.75 ? 3 : 4;
}

void StreamCell::happen() {
  if (seldom(250)) datagrams_lost_ = gap();
  if (seldom(250)) replies_lost_ = gap();
  if (seldom(300)) daemon_down_ = pick(one_in(3) ? 120 : 15) + 1;
  if (seldom(300)) foreign_cycles_ = pick(60);
  if (seldom(350)) restart_controller();
  if (options_.longest_stall_cycles > 0 && seldom(300)) stall();
  if (daemon_down_ > 0 && --daemon_down_ == 0) {
    end_daemon();
    if (one_in(options_.waits ? 2 : 8)) page_.lose();  // the machine was restarted
    start_daemon();
  }
}

void StreamCell::stall() {
  if (!daemon_runs()) return;
  stalled_cycles_ =
      static_cast<std::uint64_t>(std::pow(10, within(0, std::log10(options_.longest_stall_cycles))));
  ++history_.stalls;
}

void StreamCell::restart_controller() {
  const auto shortest = static_cast<int>(std::ceil(40 / plant_options_.cycle_ms));
  Plant::Restart restart{.pause_cycles = shortest + static_cast<int>(gap()),
                         .ipoc = {},
                         .source_port = {},
                         .arm_settled = one_in(2)};
  if (one_in(3)) restart.ipoc = pick(1'000'000'000);
  if (one_in(3)) restart.source_port = static_cast<std::uint16_t>(50'000 + pick(10'000));
  // A simulator that waits is started again, and counts replies from where it always begins.
  if (options_.waits) restart.ipoc = plant_options_.first_ipoc;
  plant_.restart_session(restart);
  open_.reset();
  timeouts_ = timeouts_in_a_row_ = 0;
  ++history_.sessions;
}

// ---- The wire ----

void StreamCell::cycle() {
  operate();
  signal();
  happen();
  now_ += std::chrono::milliseconds{static_cast<int>(plant_options_.cycle_ms)};
  if (foreign_cycles_ > 0) --foreign_cycles_, send_foreign();
  options_.waits ? run_waiting_plant() : run_plant();
}

void StreamCell::run_plant() {
  const auto sent = plant_.begin_cycle(program_.next());
  if (sent) {
    ++history_.cycles;
    const bool lost = !daemon_runs() || (datagrams_lost_ > 0 && datagrams_lost_-- > 0);
    if (!lost) {
      ++history_.heard;
      exchange(*sent);
    }
  } else if (!plant_.alive() && one_in(50)) {
    restart_controller();
  }
  if (stalled_cycles_ > 0 && --stalled_cycles_ == 0) read_backlog();
  if (!sent) return;
  judge(plant_.end_cycle());
  before_ = *sent;
  if (history_.cycles % 1000 == 0) check();
}

/// The cycle stays open until a reply to it comes.
void StreamCell::run_waiting_plant() {
  if (!open_) {
    open_ = plant_.begin_cycle(program_.next());
    reply_taken_ = false;
    timeouts_in_a_row_ = 0;
  } else if (now_ - repeated_ < patience_) {
    return;
  } else {
    ++timeouts_, ++timeouts_in_a_row_;
  }
  if (!open_) return;
  if (open_->delay) open_->delay = plant_options_.delay == Count::Cumulative ? timeouts_ : timeouts_in_a_row_;
  repeated_ = now_;
  ++history_.cycles;
  const bool lost = !daemon_runs() || (datagrams_lost_ > 0 && datagrams_lost_-- > 0);
  if (!lost) {
    ++history_.heard;
    exchange(*open_);
  }
  if (!reply_taken_) return;
  judge(plant_.end_cycle());
  before_ = std::exchange(open_, std::nullopt);
}

void StreamCell::rest(int cycles) {
  options_.rarity = std::numeric_limits<double>::infinity();
  datagrams_lost_ = replies_lost_ = foreign_cycles_ = 0;
  if (!daemon_runs()) {
    daemon_down_ = 0;
    end_daemon();
    start_daemon();
  }
  cycle_->disengage();
  cycle_->acknowledge();
  for (; cycles > 0; --cycles) cycle();
}

void StreamCell::exchange(const Plant::Sent& sent) {
  spoke_ = now_;
  const UdpSource source{kController, sent.source_port};
  if (seldom(200) && before_)
    deliver(frame(*before_), {kController, before_->source_port}, before_->ipoc);  // overtaken
  if (seldom(300)) deliver(damaged(frame(sent)), source, std::nullopt);
  deliver(frame(sent), source, sent.ipoc);
  if (seldom(300)) deliver(frame(sent), source, sent.ipoc);
}

/// Another controller, or somebody who knows the time stamps: plausible frames from the wrong address or
/// port.
void StreamCell::send_foreign() {
  const auto count = pick(4);
  for (std::uint64_t i = 0; i < count && daemon_runs(); ++i) {
    Plant::Sent forged = before_.value_or(Plant::Sent{});
    forged.ipoc += pick(3) * plant_options_.ipoc_step + (one_in(2) ? 0 : 1'000'000'000);
    if (one_in(2)) forged.aipos_deg = forged.aspos_deg;
    ++history_.foreign;
    // From the controller's own address only while that is heard: when it is silent, whoever speaks is
    // heard.
    const bool heard =
        datagrams_lost_ == 0 && before_ && plant_.alive() && now_ - spoke_ < std::chrono::milliseconds{30};
    const auto port = before_ ? before_->source_port : std::uint16_t{1};
    const bool same_address = one_in(2) && heard;
    deliver(frame(forged),
            same_address ? UdpSource{kController, static_cast<std::uint16_t>(port + 1)}
                         : UdpSource{kController + 1, port},
            forged.ipoc);
  }
}

rsi::RobotFrame robot_frame(const Plant::Sent& sent) {
  rsi::RobotFrame frame;
  frame.ipoc = sent.ipoc;
  frame.delay = sent.delay;
  frame.aipos_rad.emplace();
  frame.aspos_rad.emplace();
  for (std::size_t i = 0; i < 6; ++i) {
    (*frame.aipos_rad)[i] = sent.aipos_deg[i] * kRadPerDeg;
    (*frame.aspos_rad)[i] = sent.aspos_deg[i] * kRadPerDeg;
  }
  return frame;
}

std::string StreamCell::frame(const Plant::Sent& sent) const {
  rsi::RobotFrame frame = robot_frame(sent);
  if (!config_.sends("ASPos")) frame.aspos_rad.reset();
  frame.program = signals_;
  std::array<char, rsi::kMaxFrameBytes> buffer;
  return std::string{rsi::encode_robot_frame(frame, buffer, 4).value()};
}

std::string StreamCell::damaged(std::string bytes) {
  if (one_in(2)) return bytes.substr(0, pick(bytes.size()));
  bytes[pick(bytes.size())] = "<>/= x"[pick(6)];  // a checksum keeps other digits away
  return bytes;
}

void StreamCell::deliver(std::string bytes, const UdpSource& source, std::optional<std::uint64_t> ipoc) {
  OnTheWay datagram{std::move(bytes), source, now_ + std::chrono::microseconds{pick(900)}, ipoc};
  if (stalled_cycles_ == 0) {
    answer(datagram, datagram.received);
  } else if (backlog_.size() < kReceiveBuffer) {
    backlog_.push_back(std::move(datagram));
  }
}

void StreamCell::read_backlog() {
  for (const OnTheWay& datagram : backlog_) answer(datagram, now_ + std::chrono::milliseconds{1});
  backlog_.clear();
}

void StreamCell::answer(const OnTheWay& datagram, drivers::TimePoint taken) {
  ++given_;
  const bool other_address = datagram.source.address != kController;
  foreign_given_ += other_address;
  if (datagram.ipoc && !other_address) note_silence(datagram.received);
  const std::string_view reply = cycle_->answer({datagram.bytes, datagram.source, datagram.received});
  cycle_->finish({.received = datagram.received,
                  .taken = taken,
                  .ready = taken,
                  .sent = taken,
                  .replied = !reply.empty()});
  if (disarmed_) {
    const StreamState state = cycle_->status().state;
    expect(state != StreamState::RampingIn && state != StreamState::Active,
           "the stream corrects after a gap without a new start");
  }
  if (reply.empty()) return;
  ++replied_;
  expect(!other_address, "a foreign datagram is answered");
  const auto decoded = codec_.decode(reply);
  if (!decoded) return expect(false, "a reply cannot be read");
  expect(!datagram.ipoc || decoded->ipoc == *datagram.ipoc, "a reply has another time stamp");
  Plant::Axes correction_deg;
  for (std::size_t i = 0; i < 6; ++i) correction_deg[i] = (*decoded->axis_correction_rad)[i] * kDegPerRad;
  if (replies_lost_ > 0 && replies_lost_-- > 0) return;
  if (other_address || !plant_.take_reply(decoded->ipoc, correction_deg)) return;
  ++history_.answered;
  reply_taken_ = true;
}

/// A good frame of the controller comes to the daemon.
void StreamCell::note_silence(drivers::TimePoint received) {
  const bool silence = std::exchange(heard_before_, true) && received - heard_ >= kDisarmAfter;
  history_.silences += silence;
  if (silence && !options_.rearms && !engaged_since_heard_) disarmed_ = true;
  heard_ = received;
  engaged_since_heard_ = false;
}

// ---- What was promised ----

void StreamCell::judge(const Plant::State& state) {
  const double step = (state.step_deg - kGrid_deg) / kMaxStep_deg;
  for (const double axis_deg : state.in_force_deg)
    history_.greatest_correction_deg = std::max(history_.greatest_correction_deg, std::abs(axis_deg));
  if (step <= history_.greatest_step) return;
  history_.greatest_step = step;
  std::ostringstream text;
  text << state.step_deg << " deg in cycle " << history_.cycles << ", session " << history_.sessions
       << ", daemon " << history_.restarts + 1 << ", A1 in force " << state.in_force_deg[0];
  history_.worst = text.str();
}

void StreamCell::check() {
  const StreamStatus status = cycle_->status();
  const StreamCounters& c = status.counters;
  expect(c.datagrams == c.answered + c.held + c.duplicate + c.wrong_ipoc + c.unconfirmed + c.unanswered,
         "a datagram is in no counter, or in two");
  expect(c.datagrams + c.unexpected_sender == given_,
         "a datagram is neither the controller's nor foreign, or both");
  expect(c.replies() == replied_, "a reply is in no counter, or a counter has one that was not given");
  expect(c.unexpected_sender >= foreign_given_, "a foreign datagram is taken for the controller's");
  expect(status.max_step_deg <= kMaxStep_deg + kGrid_deg,
         "the stream itself tells of a step above the bound");
  expect(history_.greatest_correction_deg <= kMaxTotal_deg + kGrid_deg, "a correction is above its bound");
  expect(status.fault != StreamFault::NotFollowing, "an arm that follows is accused");
  // Of a frame and its damaged copy either may come first.
  expect(!status.heard || *status.heard < heard_ + std::chrono::milliseconds{1},
         "the controller was heard when it sent nothing good");
}

void StreamCell::expect(bool kept, const std::string& promise) {
  if (kept || !history_.broken.empty()) return;
  history_.broken = promise + " (cycle " + std::to_string(history_.cycles) + ", session " +
                    std::to_string(history_.sessions) + ", daemon " + std::to_string(history_.restarts + 1) +
                    ")";
}

}  // namespace truepose::daemon
