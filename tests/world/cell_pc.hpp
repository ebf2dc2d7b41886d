#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

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
  /// When the daemon that runs was stopped; none: it was not.
  std::optional<drivers::TimePoint> stopped() const { return runs() ? stopped_ : std::nullopt; }
  /// What the daemon that runs has read, and when it was started; null: none runs.
  const config::CellConfig* running() const { return runs() ? &read_ : nullptr; }
  drivers::TimePoint started() const { return started_; }
  /// Edits the cell file, or a file that it names. The daemon reads them when it starts.
  void edit(const std::function<void(config::CellConfig&)>& change) { change(config_); }
  /// Until then its processes do not come to run.
  void stall(drivers::TimePoint until) { stalled_until_ = until; }
  bool stalls() const { return world_.clock.now() < stalled_until_; }

  bool poll() override;
  /// Files that the world holds open for it.
  std::size_t open_files() const { return files_.open() + disk_.files(); }

  std::chrono::nanoseconds wall_clock_error{0};  ///< of its UTC
  bool has_power = true;                         ///< else nothing starts the daemon again
  double slowness = 1;                           ///< of its disk and its processor

 private:
  struct Life;

  World& world_;
  test::FailingDisk& disk_;
  config::CellConfig config_, read_;
  drivers::TimePoint started_{};
  std::optional<drivers::TimePoint> stopped_;
  const std::filesystem::path runtime_;
  PcFiles files_;
  std::unique_ptr<Life> life_;
  drivers::TimePoint stalled_until_{};
};

}  // namespace truepose::world
