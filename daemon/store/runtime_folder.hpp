#pragma once

#include <expected>
#include <filesystem>
#include <string>

#include "config/cell_config.hpp"
#include "drivers/start_failure.hpp"

namespace truepose::daemon {

/// Keeps what belongs to one daemon from a second one. The kernel lets go of it when the process ends,
/// however it ends; the file itself stays.
class LockFile {
 public:
  /// @param of  what is kept, for the sentence "OF is in use by trueposed (process 1234)"
  static std::expected<LockFile, drivers::StartFailure> take(const std::filesystem::path& file,
                                                             const std::string& of);
  LockFile(LockFile&& other) noexcept;
  LockFile& operator=(LockFile&&) = delete;
  ~LockFile();

 private:
  explicit LockFile(int descriptor) : descriptor_{descriptor} {}
  int descriptor_;
};

/// Beside the store, not the store itself: SQLite loses its own locks when its file is closed somewhere else
/// in the process.
std::filesystem::path lock_of_store(const std::filesystem::path& store);

/// Where a runtime folder may be; empty: not there.
struct RuntimePlaces {
  std::string unit;            ///< $RUNTIME_DIRECTORY, of a unit with RuntimeDirectory=
  std::filesystem::path user;  ///< $XDG_RUNTIME_DIR
  std::filesystem::path system = "/run/truepose";

  static RuntimePlaces of_environment();
};

/// The folder of what outlives this process, but not the machine: the control socket, and what a restarted
/// daemon has to know of the running controller. It is the cell file's `runtime`, else the unit's, else
/// truepose-NAME of the user's, else NAME of the system's. Makes it where it is missing.
///
/// @return the folder, ours alone to write; or one sentence that says why there is none
std::expected<std::filesystem::path, std::string> runtime_folder(
    const config::CellConfig& config, const RuntimePlaces& places = RuntimePlaces::of_environment());

}  // namespace truepose::daemon
