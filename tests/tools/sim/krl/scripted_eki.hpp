#pragma once

#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {

/// The files of config/kuka/krl, byte for byte, and other programs behind them.
std::vector<Source> shipped_sources(const std::vector<Source>& more = {});

/// EKI, RSI and BAS of a Bench, answered from a script.
class ScriptedCell {
 public:
  explicit ScriptedCell(std::vector<Source> sources = shipped_sources(),
                        std::vector<std::string> pass_advance_run = {});

  /// A client comes to every channel that listens; one that had a client does only after it was cleared,
  /// loaded and opened again.
  void connect();
  void disconnect();
  /// So fast that no program saw it.
  void connect_and_disconnect_unseen();
  /// A command to the motion program. @param a1  target of the first axis, deg; the others stay at 0
  void command(int id, int type, double a1 = 0);
  /// A control to the state server.
  void control(int id, int op, int value = 0);

  /// What CellLink sent: "Hello", "Ack 1 2 0" (id, state, error), and what was sent to RSI.
  std::vector<std::string> said;
  std::function<void(const std::string&)> on_send = [](const std::string&) {};  ///< at each of these
  /// What the last document of CellState held: "CellState/Robot/State/@ModeOp" ...
  std::map<std::string, Value> state;
  int states = 0;
  int greetings = 0;
  bool rsi_leaves = false;    ///< the PC set its Stop bit
  int rsi_create_result = 0;  ///< 0 is RSIOK
  bool rsi_on = false;        ///< what is not, RSI_OFF fails to end
  bool init_fails = false;    ///< EKI_Init, once
  Bench bench;

 private:
  std::expected<CallResult, std::string> answer(ExternalCall& call);
  CallResult eki(ExternalCall& call);
  void send(const std::string& channel, const std::string& document);

  struct Channel {
    bool listens = false;
  };
  std::map<std::string, Channel> channels_;            // that are loaded
  std::map<std::string, std::deque<Value>> received_;  // by channel and element
  std::map<std::string, Value> staged_;                // by channel and element
};

}  // namespace truepose::sim::krl
