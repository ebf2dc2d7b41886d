#pragma once

#include <chrono>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/record/layout.hpp"
#include "tools/proxy/faulty_way.hpp"

namespace truepose::proxy {

enum class Direction { Both, ToTarget, ToClient };

/// One line to the proxy, the same at its start, in a timeline and at its admin port:
/// {"route": "127.0.0.1:49152", "direction": "to_target", "loss": 0.01, "burst": 3}
struct Command {
  std::string route;  ///< as it listens; empty: all
  Direction direction = Direction::Both;
  bool clear = false;  ///< all faults, before those of this line are set
  std::vector<std::pair<double Faults::*, double>> numbers;  ///< of Faults, by their names
  std::optional<bool> half_open;
  bool cut = false;                             ///< resets the TCP connections of the route
  bool statistics = false;                      ///< the reply tells what became of all packets so far
  std::optional<std::chrono::milliseconds> at;  ///< "at_ms": in a timeline, after the start

  void apply(Faults& faults) const;
};
void layout(record::Io& io, Command& x);

/// @return the command, or one sentence that names the key
std::expected<Command, std::string> parse_command(std::string_view line);

/// One line each; empty ones and those that begin with # are skipped. In the order of their times.
/// @return the commands, or one sentence that names the line
std::expected<std::vector<Command>, std::string> parse_timeline(std::string_view text);

}  // namespace truepose::proxy
