#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/notify_socket.hpp"
#include "tests/process.hpp"
#include "tests/simulator_process.hpp"
#include "tests/temp_folder.hpp"
#include "tools/truepose/online/rpc_client.hpp"

namespace truepose {

/// Texts of a shipped file and what stands there instead.
using Replacements = std::vector<std::pair<std::string, std::string>>;

/// The bound of config/cell.yaml, and half the last digit that an axis' correction is sent with before and
/// after the step.
inline constexpr double kMaxStep_deg = 0.02 + 1e-6;

/// A free UDP port, for a program that needs a number.
std::uint16_t free_udp_port();

/// The simulated cell and its daemon as processes, configured by the shipped files and talking over loopback.
class LiveCell {
 public:
  struct Options {
    double speedup = 100;             ///< of robot and tracker; RSI keeps real time
    std::string faults = "[]";        ///< of the scenario
    Replacements scenario{}, cell{};  ///< in config/scenarios/demo.yaml and config/cell.yaml, after our own
    bool patient = false;  ///< the controller waits 10 s for its PC: where other programs run, the shipped
                           ///< 100 cycles are too short
  };

  /// Starts the simulator and writes the daemon's cell file.
  LiveCell() : LiveCell{Options{}} {}
  explicit LiveCell(const Options& options);

  /// Starts the daemon and waits until it says that it is ready.
  /// @param environment  "NAME=value" each, in addition to our own
  void start_daemon(std::vector<std::string> environment = {});
  /// Waits until the daemon tells the service manager this. @return false where it ended without
  bool daemon_tells(const std::string& text);
  Process& daemon() { return *daemon_; }
  /// After the daemon was killed: its PC loses what was not synced (power_may_be_cut()) and what is kept in
  /// memory alone. @return how many writes were not synced
  int cut_power(std::mt19937_64& random);

  /// Runs the client against the daemon.
  Finished truepose(std::vector<std::string> arguments) const;
  /// A session with the daemon.
  tools::RpcClient client() const;
  std::uint16_t control_port() const { return control_port_; }
  std::uint16_t tls_port() const { return tls_port_; }
  /// Where the daemon listens for the controller.
  std::uint16_t rsi_port() const { return rsi_port_; }

  /// Has the simulated cell do something, or asks it. @return what it answers on its admin port
  boost::json::value steer(const boost::json::object& line) const;
  /// What the simulator counted so far.
  boost::json::value simulated() const;
  /// Ends the simulator. @return what it counted
  boost::json::value end_simulator();

  /// Writes a file into the cell's folder.
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }
  const std::filesystem::path& folder() const { return folder_.path(); }
  std::filesystem::path cell_file() const { return folder() / "cell.yaml"; }
  std::filesystem::path token_file() const { return folder() / "token"; }
  /// The token that truepose() and client() show.
  void write_token(const std::string& token) const;
  std::filesystem::path store_file() const { return folder() / "demo.sqlite"; }

 private:
  TempFolder folder_;
  NotifySocket notify_{folder_.path() / "notify"};
  std::unique_ptr<sim::SimulatorProcess> simulator_;
  std::unique_ptr<Process> daemon_;
  std::uint16_t control_port_ = 0, tls_port_ = 0;
  std::uint16_t admin_port_ = 0;
  std::uint16_t rsi_port_ = free_udp_port();
};

/// What the daemon answers. @throws std::runtime_error where it refuses
boost::json::value called(tools::RpcClient& client, const std::string& method,
                          const boost::json::object& params = {});

/// The number at a JSON pointer, which must be there.
double number(const boost::json::value& value, const char* pointer);

/// Measures 12 + 6 poses and the 6 again, and activates the model. @return what the client said
Finished small_campaign(const LiveCell& cell);

}  // namespace truepose
