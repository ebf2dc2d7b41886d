#pragma once

#include <Eigen/Core>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "config/scenario.hpp"
#include "tests/daemon/failing_disk.hpp"
#include "tests/temp_folder.hpp"
#include "tests/world/cell_pc.hpp"
#include "tests/world/client.hpp"
#include "tests/world/world.hpp"
#include "tools/sim/simulated_cell.hpp"

namespace truepose::world {

/// The cell of the shipped cell file and scenario, whole: PC with daemon and disk, controller with its
/// programs, arm, tracker. One at a time in a process: it stands in a folder of its own, and the disk is
/// SQLite's.
class Cell {
 public:
  /// Makes another cell of the shipped one.
  using Change = std::function<void(config::CellConfig& cell, config::Scenario& scenario)>;
  explicit Cell(
      std::uint64_t seed, const Change& change = [](auto&&...) {});

 private:
  TempFolder folder_;
  StandsIn stands_{folder_.path()};
  struct Files {
    config::CellConfig cell;
    config::Scenario scenario;
  };
  static Files files(const Change& change);
  const Files files_;

 public:
  config::Scenario scenario = files_.scenario;  ///< with the arm that is there
  World world;
  test::FailingDisk disk;
  const double max_step_deg;  ///< of the stream, by the cell file
  sim::SimulatedCell devices;
  Eigen::Vector3d tracker_moved_mm{0, 0, 0};  ///< what it reads is off by that since it was bumped
  std::set<std::string> edited_models;        ///< in the store, which no daemon may work with
  CellPc pc;
  /// Stops the daemon, and returns when it does not run.
  boost::asio::awaitable<void> end_of_daemon();
  /// Exchanges the arm, or what is in it.
  void change_arm(const std::function<void(config::Scenario&)>& change);
  int arm_changes = 0;
  Client panel;       ///< with the token of the cell
  Client supervisor;  ///< an operator of the access list
  Client mirror;      ///< that shows the cell to others, a viewer
  /// HMIs that only show: viewers of the access list, who subscribe to what the daemon keeps.
  std::deque<Client> viewers;
  std::vector<Client*> clients();
};

}  // namespace truepose::world
