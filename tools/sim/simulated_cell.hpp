#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "config/scenario.hpp"
#include "core/math/random.hpp"
#include "core/simulate/true_arm.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "tools/sim/alarms.hpp"
#include "tools/sim/controller/controller.hpp"
#include "tools/sim/controller/controller_setup.hpp"
#include "tools/sim/controller/eki_server.hpp"
#include "tools/sim/controller/rsi_session.hpp"
#include "tools/sim/machine.hpp"
#include "tools/sim/motion/path_log.hpp"
#include "tools/sim/tracker/tracker_server.hpp"

namespace truepose::sim {

struct CellOptions {
  std::string address = "127.0.0.1";  ///< that the servers listen on
  /// CellLink, and CellState on the next one; 0 picks two free ones. Other channels have their files' ports.
  std::uint16_t eki_port = 0;
  std::uint16_t tracker_port = 0;  ///< 0 picks a free one
  /// The tracker speaks through a bridge, here, in place of emScon; 0 picks a free one.
  std::optional<std::uint16_t> bridge_port{};
  std::string rsi_host;  ///< numeric address that the RSI datagrams go to
  std::uint16_t rsi_port = 0;
  std::uint64_t seed = 0;           ///< of repeatability and tracker noise
  double speedup = 1;               ///< robot and tracker are this much faster; RSI keeps real time
  std::filesystem::path path_file;  ///< where the programs' TCP is logged; empty: nowhere
};

/// What a cell did in its life.
struct CellStatistics {
  RsiStatistics rsi;
  std::uint64_t moves = 0;
  std::uint64_t measurements = 0;
};

/// A KUKA controller, the arm that it moves, and the laser tracker that watches it, over real sockets.
class SimulatedCell : private EkiListener, private SimulatedTarget {
 public:
  /// Listens at once. Throws PortError, and std::invalid_argument where the scenario cannot be simulated.
  /// @param machine  the cell is destroyed when its executor does not run
  SimulatedCell(Machine machine, config::Scenario scenario, rsi::EthernetConfig ethernet,
                CellOptions options);
  ~SimulatedCell() override;

  struct Ports {
    std::uint16_t eki, eki_state;  ///< 0 where the controller has no CellLink or no CellState
    std::uint16_t tracker;
    std::vector<EkiPort> others;  ///< further channels; port 0: not open yet, a free one then
  };
  Ports ports() const;
  CellStatistics statistics() const;

  /// Moves the arm's first reflector to another place on the flange, opened as before.
  void put_reflector(const Eigen::Vector3d& p_FS_mm);
  /// Another arm stands there, or the same one with other errors, as after the exchange of a motor.
  void exchange_arm(const RobotModel& truth, int serial);
  /// Jogs the arm to these axes. Throws std::invalid_argument where that cannot be done.
  void jog(const JointVector& q);
  /// A fault that begins now.
  void begin(config::ScenarioFault fault);
  Controller::Program program() const { return controller_.program(); }
  /// Where the arm is, rad.
  JointVector axes() const;
  /// What of the controller's archive is not simulated: programs stop where they come to it.
  const std::vector<krl::Fault>& not_simulated() const { return controller_.not_simulated(); }
  /// Has all in the path file that came to be known.
  void flush_path();

 private:
  bool connected(const std::string& channel) override;
  void lost(const std::string& channel) override;
  void received(const std::string& channel, std::string_view document) override;
  TargetSight look() const override;
  TargetSight seen_of(const JointVector& q) const;

  SimTime now() const;
  drivers::Duration shortened(std::chrono::nanoseconds time) const;
  void pass_time();
  void follow();
  void forward_outputs();
  void restart_after_halt();
  void start_rsi(const Controller::OpenedRsi& session);
  void rsi_ended(std::uint64_t session, RsiEnd end);
  void operate_later(std::chrono::nanoseconds after, OperatorAct act);
  void disturb_robot(const config::ScenarioFault& fault);
  void report_unknown_name(const std::string& name);
  void misbehave(const config::ScenarioFault& fault);
  void schedule(const config::ScenarioFault& fault, std::chrono::milliseconds at);
  void point_begins(std::uint64_t number);
  void disturb_tracker();
  std::vector<config::ScenarioFault> rsi_faults() const;
  config::ScenarioFault in_cycles(config::ScenarioFault fault) const;
  Eigen::Vector3d measured(const Eigen::Vector3d& p_true_mm);

  const Machine machine_;
  const drivers::TimePoint start_ = machine_.clock.now();
  config::Scenario scenario_;
  rsi::EthernetConfig ethernet_;
  RsiContexts contexts_;  // before the controller, which fills them
  CellOptions options_;
  TrueArm arm_;
  mutable std::optional<PoseChecker> sight_;  // what the arm's body hides; none: nothing
  mutable std::optional<TargetSight> seen_;   // by the tracker; none where the arm or a reflector has moved
  mutable JointVector seen_at_;
  Random noise_random_;
  std::unique_ptr<PathLog> path_;
  Controller controller_;
  drivers::TimePoint passed_ = start_;  // until when the controller's time has gone on
  Alarms next_change_;                  // of the controller
  Alarms alarms_;
  std::uint64_t point_ = 1;  // that the tracker measures, or comes to measure
  double extra_sigma_mm_ = 0;
  std::set<std::string> reported_unknown_names_;
  RsiStatistics ended_sessions_;
  std::uint64_t rsi_session_ = 0;  // of the controller, that rsi_ serves
  std::uint64_t stops_seen_ = 0, halts_seen_ = 0;
  std::vector<EkiPort> eki_ports_;
  EkiServer eki_;
  std::unique_ptr<TrackerServer> tracker_;
  std::unique_ptr<RsiSession> rsi_;
};

}  // namespace truepose::sim
