#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "proto/eki/messages.hpp"
#include "tools/sim/controller/eki_channel.hpp"
#include "tools/sim/controller/rsi_client.hpp"
#include "tools/sim/controller/system_values.hpp"
#include "tools/sim/krl/interpreter.hpp"
#include "tools/sim/krl/load.hpp"
#include "tools/sim/motion/path_log.hpp"
#include "tools/sim/motion/program_motion.hpp"

namespace truepose::sim {

/// Time of the robot since the simulator started.
using SimTime = std::chrono::nanoseconds;

struct ControllerSetup {
  RobotModel nominal;                                           ///< six axes with a spherical wrist
  std::string model;                                            ///< $ROBTRAFO
  int serial = 0;                                               ///< $KR_SERIALNO
  JointVector start;                                            ///< where the arm stands at first
  std::vector<krl::Source> programs;                            ///< .src, .sub and .dat
  std::map<std::string, std::string, std::less<>> eki_files{};  ///< EKI configurations, by channel
  std::vector<std::string> contexts{};                          ///< names of the RSI contexts that it has
  /// What a parameter of one of them is; none where there is no such one.
  std::function<std::optional<double>(const std::string& context, const RsiParameter&)> rsi_parameter =
      [](const std::string&, const RsiParameter&) { return std::optional<double>{}; };
  std::string selected = "TRUEPOSE_MOTION";  ///< and started, as is
  /// System variables and subprograms that do not stop the advance run, in capitals.
  std::vector<std::string> pass_advance_run = {};
  std::string submit = "SPS";
  /// What a real controller does not do: visited in a loop while RSI_MOVECORR waits. Empty: the arm stands.
  std::vector<JointVector> stream_path{};
  /// Called after a cycle of RSI that left documents, closed channels, messages or a HALT. On the cycles'
  /// thread.
  std::function<void()> on_news = [] {};
  /// Called in each cycle of RSI, on its thread; none where no observer is set.
  std::function<void(const ProgramCycle&)> on_cycle{};
};

/// What a person does at the pendant and around the cell.
struct OperatorAct {
  enum class Kind {
    Select,  ///< of `program`; what was selected is cancelled
    Start,   ///< acknowledges messages, switches the drives on, and starts
    Stop,
    Reset,
    Deselect,
    EmergencyStop,  ///< pressed; drives off
    ReleaseEmergencyStop,
    OpenGate,  ///< operator safety; drives off
    CloseGate,
    SetMode,      ///< `number` of MODE_OP from 1: T1, T2, AUT, EX; stops the program
    SetOverride,  ///< to `number` percent
    SwitchOff,    ///< the controller
    SwitchOn,
  };
  Kind kind = Kind::Start;
  std::string program{};
  int number = 0;
};

/// A KUKA controller that executes KRL: robot and submit interpreter, the motions, Ethernet KRL and the
/// program side of RSI, as a function of time. No I/O.
///
/// While RSI is on its cycles are the clock, on a thread of their own; else advance() is. All functions may
/// be called from any thread.
class Controller final : public RsiProgram, private krl::Host {
 public:
  /// Throws std::invalid_argument: the arm, a program or a file that it cannot have, with file and line.
  explicit Controller(ControllerSetup setup);

  /// What of the partial sources is not simulated: programs stop where they come to it.
  const std::vector<krl::Fault>& not_simulated() const { return program_->refusals; }

  // ---- Its clock while RSI is off

  void advance(SimTime by);
  /// How long until something happens by itself; none while all wait for others.
  std::optional<SimTime> next_change() const;

  // ---- Ethernet KRL

  /// Name and configured port of each channel.
  std::map<std::string, std::uint16_t, std::less<>> eki_ports() const;
  /// Whether the channel listens: a program has opened it.
  bool is_open(std::string_view channel) const;
  /// A client comes. @return false where the channel takes none now
  bool connect(std::string_view channel);
  void disconnect(std::string_view channel);
  void receive(std::string_view channel, std::string_view document);
  struct Document {
    std::string channel, text;
  };
  std::vector<Document> take_documents();
  /// Channels that the controller has closed, whose clients must go.
  std::vector<std::string> take_closed();

  // ---- People

  void operate(OperatorAct act);
  /// Moves the arm by the pendant's keys: in no time, but under RSI as fast as T1 allows.
  /// Error: why it is not moved, as by a program that runs.
  std::expected<void, std::string> jog(const JointVector& q);
  std::vector<std::string> take_messages();
  /// Another arm is connected, with this serial number.
  void exchange_arm(int serial);

  // ---- The arm

  /// Actual, while RSI is off.
  JointVector axes() const;
  bool is_moving() const;
  std::uint64_t moves() const;  ///< motions that were made
  std::uint64_t stops() const;  ///< how often the arm came to a stand elsewhere
  std::uint64_t halts() const;  ///< how often the robot program came to HALT
  /// Selected program, line, state and TCP, for who records a path.
  struct Program {
    std::string name;
    eki::ProgramState state = eki::ProgramState::Free;
    int line = 0;
  };
  Program program() const;

  // ---- RSI

  /// The session that the program has opened, numbered from 1; none where RSI is off.
  struct OpenedRsi {
    std::uint64_t number = 0;
    std::string context;
    std::vector<RsiParameter> parameters{};  ///< that the program has set
  };
  std::optional<OpenedRsi> rsi() const;
  /// The cycles of a session have ended. @param actual  where the arm is then
  void rsi_ended(std::uint64_t session, RsiEnd end, const JointVector& actual);

  void advance(Seconds cycle, const JointVector& actual, const JointVector& correction) override;
  void stand(Seconds cycle) override;
  const JointVector& set_points() const override { return set_points_; }
  bool moving() const override { return is_moving(); }
  bool drives_on() const override;
  bool corrects() const override;
  bool is_relative() const override;
  FlowSources sources() const override;
  void take(const FlowEffects& effects) override;
  bool is_on() const override;

 private:
  // krl::Host
  krl::Value read(const krl::Variable& variable, std::optional<int> index) override;
  std::expected<void, std::string> write(std::string_view name, std::optional<int> index,
                                         const krl::Value& value) override;
  std::expected<krl::CallResult, std::string> call(krl::ExternalCall& call) override;
  std::expected<void, std::string> move(const krl::Motion& motion) override;
  bool is_finished(std::uint64_t motion) override { return motion_.is_finished(motion); }
  std::vector<std::uint64_t> take_switched() override { return motion_.take_switched(); }
  bool is_standing() override { return motion_.is_standing(); }
  void brake(bool) override { motion_.brake(); }
  void go_on() override { motion_.go_on(); }
  void cancel() override;
  void interrupted() override { interrupted_at_ = actual_; }
  void halted() override { ++halts_; }
  void show(const krl::Message& message) override;

  // controller_variables.cpp
  /// The state of the controller that programs read; index 0 where the variable is no array.
  using Reader = std::function<krl::Value(const Controller&, int index)>;
  static const std::unordered_map<std::string_view, Reader>& readers();
  krl::Value pose_at(const JointVector& q) const;
  krl::Value date() const;
  static krl::Value no_error();
  void show_message_of_krc2();
  std::string mode_name() const;
  int timer_ms(int number) const;
  std::optional<Eigen::Isometry3d> frame_in(std::string_view variable) const;
  void default_variables();

  // controller_calls.cpp
  std::expected<krl::CallResult, std::string> message(krl::ExternalCall& call);
  std::expected<krl::CallResult, std::string> eki(krl::ExternalCall& call);
  std::expected<krl::CallResult, std::string> eki_element(krl::ExternalCall& call, EkiChannel& channel);
  krl::CallResult eki_status(const EkiChannel* channel, std::string_view element, int error) const;
  std::expected<krl::CallResult, std::string> rsi_call(krl::ExternalCall& call);
  int rsi_create(krl::ExternalCall& call);
  std::expected<krl::CallResult, std::string> rsi_parameter(krl::ExternalCall& call);
  bool movecorr(bool is_first);

  void boot();
  void act(const OperatorAct& act);
  void stop_program(bool by_message);
  void cancel_program();
  void power_off();
  void run_programs();
  void report_cycle(const JointVector& correction) const;
  int sen_pint(int index) const;
  void report_news();
  void close_rsi();
  void raise(int flag, bool to);
  void drop(EkiChannel& channel);

  /// $TIMER[]
  struct Timer {
    int ms = 0;  ///< as it was set
    SimTime since{0};
  };

  mutable std::mutex
      mutex_;  // guards all that follows, but set_points_, which only the clock's thread touches
  ControllerSetup setup_;
  ProgramMotion motion_;
  std::map<std::string, EkiChannel, std::less<>> channels_;
  std::unique_ptr<krl::Program> program_;
  std::unique_ptr<krl::Memory> memory_;
  std::unique_ptr<krl::Interpreter> robot_, submit_;
  SystemValues variables_;
  std::map<int, Timer> timers_;
  std::string selected_;
  SimTime time_{0};
  JointVector actual_, set_points_;
  JointVector stood_at_;
  JointVector interrupted_at_;
  std::uint64_t stops_ = 0;
  std::uint64_t halts_ = 0, halts_reported_ = 0;
  bool is_switched_on_ = true;
  bool emergency_stop_ = false, gate_open_ = false, drives_on_ = true, stop_message_ = false;
  int mode_ = 4;
  std::optional<std::string> rsi_context_;  // created
  bool rsi_on_ = false;
  bool rsi_ipo_ = false;  // in #IPO
  bool rsi_relative_ = false;
  std::vector<RsiParameter> rsi_parameters_;  // of the context that was created
  std::uint64_t rsi_sessions_ = 0;
  bool in_movecorr_ = false;
  std::optional<StreamPath> stream_path_;  // while in RSI_MOVECORR
  SimTime stream_begins_{0};
  std::vector<OperatorAct> acts_;  // for the next cycle of RSI
  std::vector<Document> documents_;
  std::vector<std::string> closed_, messages_;
};

}  // namespace truepose::sim
