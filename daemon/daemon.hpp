#pragma once

#include <boost/asio/awaitable.hpp>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "config/cell_config.hpp"
#include "daemon/machine.hpp"

namespace truepose::daemon {

/// The daemon cannot start: a port that is taken, a store that cannot be opened. what() is the one line.
class StartError : public std::runtime_error {
 public:
  explicit StartError(const std::string& sentence, bool may_pass = false)
      : std::runtime_error{sentence}, may_pass_{may_pass} {}
  /// Waiting may help: an address that is not there yet, a port in use, a full disk.
  bool may_pass() const { return may_pass_; }

 private:
  bool may_pass_;
};

/// A cell's daemon, with all that it holds: locks, store, ports and connections.
class Daemon {
 public:
  /// Throws StartError.
  /// @param config   outlives it
  /// @param runtime  the cell's runtime folder; empty: none
  static std::unique_ptr<Daemon> start(Machine machine, const config::CellConfig& config,
                                       const std::filesystem::path& runtime);
  virtual ~Daemon() = default;

  /// Serves the cell until `end` returns. Then corrections are ramped out, a campaign is aborted and
  /// recorded, sockets are closed. Once, on the machine's io thread.
  virtual boost::asio::awaitable<void> live(boost::asio::awaitable<void> end) = 0;
  /// After it has lived, and nothing runs any more: waits for the machine's workers, writes what is left.
  virtual void settle() = 0;
};

}  // namespace truepose::daemon
