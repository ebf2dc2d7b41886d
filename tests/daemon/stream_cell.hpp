#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/math/random.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "tests/daemon/plant.hpp"
#include "tests/daemon/robot_program.hpp"

namespace truepose::daemon {

/// What a plant sends of its axes, as the controller's frame.
rsi::RobotFrame robot_frame(const test::Plant::Sent& sent);

/// How a cell is made up, beyond what its seed chooses, and what befalls it.
struct StreamCellOptions {
  std::optional<int> cycle_ms{};    ///< of the controller; none: the seed chooses 4 or 12
  double rarity = 1;                ///< everything happens so many times more seldom
  double longest_gap_cycles = 200;  ///< of lost datagrams or replies, and of a pause of the controller
  double longest_stall_cycles = 0;  ///< for which the daemon does not run now and then, and finds a backlog
  bool waits = false;  ///< a simulator of the robot's side: it repeats its frame until it is answered
  bool rearms = true;  ///< `rearm: automatic`: the correction continues after a silence; every third is armed
};

/// What one controller and its stream went through, and how it ended.
struct StreamHistory {
  std::uint64_t cycles = 0;    ///< of the controller's sessions
  std::uint64_t heard = 0;     ///< of these, by a daemon that runs
  std::uint64_t answered = 0;  ///< with a reply that it took
  std::uint64_t sessions = 0;  ///< of the controller, the first included
  std::uint64_t restarts = 0;  ///< of the daemon
  std::uint64_t stalls = 0;    ///< of the daemon
  std::uint64_t silences = 0;  ///< that disarm a stream
  std::uint64_t foreign = 0;   ///< datagrams of others
  double greatest_step = 0;  ///< of a correction in effect, in bounds of a cycle: 1 = as much as was promised
  double greatest_correction_deg = 0;
  std::string worst;   ///< when and where, and in which cell
  std::string broken;  ///< the first of the other promises that was not kept; empty: all were

  /// Adds up what was counted, and keeps the greater of what was greatest.
  void add(const StreamHistory& other);
};

/// A file in memory for what one daemon leaves to the next, gone at the end.
class StreamPage {
 public:
  StreamPage();
  ~StreamPage() { lose(); }
  StreamPage(const StreamPage&) = delete;
  StreamPage& operator=(const StreamPage&) = delete;
  std::unique_ptr<StreamMemory> open() const { return StreamMemory::open(file_).value(); }
  void lose() const { std::filesystem::remove(file_); }

 private:
  std::filesystem::path file_;
};

/// A controller that the seed makes up (cycle, dead time and lag up to 100 ms, Timeout 10 to 10000, how it
/// counts, with ASPos or without), or a simulator that waits for each reply, its stream, and everything that
/// can happen to them: a second sender, losses in either direction, datagrams that are damaged, repeated or
/// overtake each other, restarts of controller, daemon and machine, commands of operators; up to 200 deg/s,
/// corrections up to 3 deg.
///
/// All in virtual time, the same again from the same seed.
class StreamCell {
 public:
  explicit StreamCell(std::uint64_t seed, const StreamCellOptions& options = {});

  /// One cycle of the controller.
  void cycle();
  /// An operator stops the correction and acknowledges every fault; for so many cycles nothing else happens.
  void rest(int cycles);

  /// So far.
  StreamHistory history() const;
  const test::PlantOptions& controller() const { return plant_options_; }
  const test::Plant::Axes& in_force_deg() const { return plant_.in_force_deg(); }
  /// None where the daemon does not run.
  std::optional<StreamStatus> status() const;

 private:
  double within(double a, double b) { return a + (b - a) * random_.uniform(); }
  bool one_in(double n) { return random_.uniform() * n < 1; }
  bool seldom(double cycles) { return one_in(cycles * options_.rarity); }
  std::uint64_t pick(std::uint64_t n) {
    return static_cast<std::uint64_t>(random_.uniform() * static_cast<double>(n));
  }
  std::uint64_t gap();

  test::PlantOptions random_plant();
  rsi::EthernetConfig random_config();
  RobotModel random_arm();
  RobotModel unusable_arm();

  void start_daemon();
  void end_daemon();
  bool daemon_runs() const { return daemon_down_ == 0; }
  void operate();
  void engage();
  void engage_or_arm();
  void signal();
  void happen();
  void stall();
  void restart_controller();

  void run_plant();
  void run_waiting_plant();
  void exchange(const test::Plant::Sent& sent);
  void send_foreign();
  std::string frame(const test::Plant::Sent& sent) const;
  std::string damaged(std::string bytes);

  struct OnTheWay {
    std::string bytes;
    drivers::UdpSource source;
    drivers::TimePoint received;
    std::optional<std::uint64_t> ipoc;  // of a good frame
  };
  void deliver(std::string bytes, const drivers::UdpSource& source, std::optional<std::uint64_t> ipoc);
  void answer(const OnTheWay& datagram, drivers::TimePoint taken);
  void note_silence(drivers::TimePoint received);
  void read_backlog();

  void judge(const test::Plant::State& state);
  void check();
  void expect(bool kept, const std::string& promise);

  StreamCellOptions options_;
  Random random_;
  test::PlantOptions plant_options_;
  test::Plant plant_;
  test::RobotProgram program_;
  rsi::EthernetConfig config_;
  rsi::SensorFrameCodec codec_;
  RobotModel arm_;
  bool drives_ = true;
  bool armed_;             ///< whenever it is engaged, and the program says what it wants
  Random program_random_;  ///< of that alone, so that all else stays as it is
  rsi::ProgramSignals signals_;
  drivers::TimePoint now_{std::chrono::hours{1}};
  drivers::TimePoint heard_{now_};  // a good frame from the controller's address, by the daemon
  drivers::TimePoint spoke_{now_};  // the controller itself, to the daemon
  StreamPage page_;
  std::unique_ptr<StreamMemory> memory_;
  std::unique_ptr<StreamCycle> cycle_;
  std::uint64_t datagrams_lost_ = 0, replies_lost_ = 0, daemon_down_ = 0, foreign_cycles_ = 0;
  std::uint64_t stalled_cycles_ = 0;
  std::deque<OnTheWay> backlog_;
  std::optional<test::Plant::Sent> before_;
  // Of a peer that waits.
  std::chrono::milliseconds patience_{40};  // after which it repeats its frame
  std::optional<test::Plant::Sent> open_;   // not answered yet
  drivers::TimePoint repeated_{};
  std::int64_t timeouts_ = 0, timeouts_in_a_row_ = 0;
  bool reply_taken_ = false;
  bool corrected_before_ = false;    // as the disk keeps it
  std::uint64_t given_ = 0;          // datagrams to this daemon
  std::uint64_t foreign_given_ = 0;  // of these, from another address
  std::uint64_t replied_ = 0;        // by this daemon
  bool heard_before_ = false;        // a good frame, by this daemon
  bool engaged_since_heard_ = false;
  bool disarmed_ = false;
  StreamHistory history_;
};

}  // namespace truepose::daemon
