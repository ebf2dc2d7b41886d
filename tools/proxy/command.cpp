#include "tools/proxy/command.hpp"

#include <algorithm>
#include <array>
#include <boost/json/value.hpp>
#include <sstream>

#include "proto/control/json_text.hpp"
#include "proto/control/param_reader.hpp"

namespace truepose::proxy {

namespace {

struct Key {
  std::string_view name;
  double Faults::*number;
  double least, most;
};

constexpr double kMinute_ms = 60'000;
constexpr std::array kKeys{Key{"delay_ms", &Faults::delay_ms, 0, kMinute_ms},
                           Key{"jitter_ms", &Faults::jitter_ms, 0, kMinute_ms},
                           Key{"truncate", &Faults::truncate, 0, 1},
                           Key{"corrupt", &Faults::corrupt, 0, 1},
                           Key{"nul_bytes", &Faults::nul_bytes, 0, 4096},
                           Key{"loss", &Faults::loss, 0, 1},
                           Key{"burst", &Faults::burst, 1, 1e6},
                           Key{"duplicate", &Faults::duplicate, 0, 1},
                           Key{"reorder", &Faults::reorder, 0, 1},
                           Key{"bytes_per_s", &Faults::bytes_per_s, 0, 1e9},
                           Key{"coalesce_ms", &Faults::coalesce_ms, 0, kMinute_ms}};

constexpr std::int64_t kYear_ms = 365LL * 24 * 3600 * 1000;

void read_direction(control::ParamReader& read, Command& command) {
  const std::string direction = read.text("direction").value_or("both");
  command.to_target = direction == "both" || direction == "to_target";
  command.to_client = direction == "both" || direction == "to_client";
  if (!command.to_target && !command.to_client)
    read.fail("direction", "expected to_target, to_client or both");
}

}  // namespace

void Command::apply(Faults& faults) const {
  if (clear) faults = {};
  for (const auto& [number, value] : numbers) faults.*number = value;
  if (half_open) faults.half_open = *half_open;
}

std::expected<Command, std::string> parse_command(std::string_view line) {
  const auto parsed = control::parse_json(line);
  if (!parsed) return std::unexpected(parsed.error());
  if (!parsed->is_object()) return std::unexpected("expected an object, such as {\"loss\": 0.01}");
  control::ParamReader read{parsed->get_object()};
  Command command;
  command.route = read.text("route").value_or("");
  read_direction(read, command);
  for (const Key& key : kKeys) {
    if (const auto value = read.number(key.name, key.least, key.most))
      command.numbers.emplace_back(key.number, *value);
  }
  command.half_open = read.boolean("half_open");
  command.clear = read.boolean("clear").value_or(false);
  command.cut = read.boolean("cut").value_or(false);
  command.statistics = read.boolean("statistics").value_or(false);
  if (const auto at = read.integer("at_ms", 0, kYear_ms)) command.at = std::chrono::milliseconds{*at};
  if (const auto error = read.finish()) return std::unexpected(error->message);
  return command;
}

std::expected<std::vector<Command>, std::string> parse_timeline(std::string_view text) {
  std::vector<Command> timeline;
  std::istringstream lines{std::string{text}};
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos || line.starts_with('#')) continue;
    auto command = parse_command(line);
    if (!command) return std::unexpected(std::to_string(number) + ": " + command.error());
    if (!command->at) return std::unexpected(std::to_string(number) + ": at_ms is missing");
    timeline.push_back(*std::move(command));
  }
  std::ranges::stable_sort(timeline, {}, &Command::at);
  return timeline;
}

}  // namespace truepose::proxy
