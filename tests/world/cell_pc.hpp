#pragma once

#include <chrono>
#include <filesystem>
#include <memory>

#include "config/cell_config.hpp"
#include "tests/daemon/failing_disk.hpp"
#include "tests/world/pc_files.hpp"
#include "tests/world/world.hpp"

namespace truepose::world {

/// The PC of a cell, with the daemon that it runs, and with all files of the folder in which the test stands.
class CellPc final : public Process {
 public:
  /// @param disk     that the store is on
  /// @param runtime  the daemon's folder in memory, which a loss of power empties
  CellPc(World& world, test::FailingDisk& disk, config::CellConfig config, std::filesystem::path runtime);
  ~CellPc() override;

  /// Starts the daemon. Throws daemon::StartError.
  void start();
  /// SIGTERM: the daemon ends in order; runs() is false then.
  void stop();
  /// SIGKILL: at once.
  void kill();
  /// The daemon ends at once; of its files stays what was synced, and by chance more.
  void lose_power();
  bool runs() const { return life_ != nullptr; }

  bool poll() override;

  std::chrono::nanoseconds wall_clock_error{0};  ///< of its UTC
  bool has_power = true;                         ///< else nothing starts the daemon again

 private:
  struct Life;

  World& world_;
  test::FailingDisk& disk_;
  const config::CellConfig config_;
  const std::filesystem::path runtime_;
  PcFiles files_;
  std::unique_ptr<Life> life_;
};

}  // namespace truepose::world
