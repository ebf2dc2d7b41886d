#include "tools/proxy/command.hpp"

#include <algorithm>
#include <array>
#include <sstream>

#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"

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

constexpr std::array kDirections{Named{"both", Direction::Both}, Named{"to_target", Direction::ToTarget},
                                 Named{"to_client", Direction::ToClient}};

}  // namespace

void layout(record::Io& io, Command& x) {
  io.optional("route", x.route);
  io.defaulted("direction", x.direction, kDirections);
  for (const Key& key : kKeys) {
    std::optional<double> number;
    io.optional(key.name, number, record::Range{key.least, key.most});
    if (number) x.numbers.emplace_back(key.number, *number);
  }
  io.optional("half_open", x.half_open);
  io.defaulted("clear", x.clear);
  io.defaulted("cut", x.cut);
  io.defaulted("statistics", x.statistics);
  io.optional("at_ms", x.at, record::Whole{0, kYear_ms});
}

void Command::apply(Faults& faults) const {
  if (clear) faults = {};
  for (const auto& [number, value] : numbers) faults.*number = value;
  if (half_open) faults.half_open = *half_open;
}

std::expected<Command, std::string> parse_command(std::string_view line) {
  const auto parsed = control::parse_json(line);
  if (!parsed) return std::unexpected(parsed.error());
  Command command;
  const auto read = record::read_json(*parsed, "params", record::Others::Refused,
                                      [&command](record::Io& io) { io.value(command); });
  if (!read) return std::unexpected(read.error().text);
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
