// The cell in virtual time, for as long as one likes: soak --days 30 --seed 1

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "tests/world/faults.hpp"
#include "tests/world/methods.hpp"
#include "tests/world/soak.hpp"

namespace world = truepose::world;

namespace {

/// The faults without which it still breaks a promise, taken out one after the other.
std::set<std::string> shrunk(world::SoakOptions options) {
  std::set<std::string> needed;
  for (const world::FaultKind& kind : world::fault_kinds())
    if (!options.faults || options.faults->contains(std::string{kind.name})) needed.emplace(kind.name);
  options.trace = [](auto&&...) {};
  for (const std::string& name : std::set{needed}) {
    options.faults = needed;
    options.faults->erase(name);
    if (!world::soak(options).broken.empty()) needed.erase(name);
  }
  return needed;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Lets a simulated cell live with people and faults, and judges what the daemon promises."};
  world::SoakOptions options;
  std::vector<std::string> faults, topics;
  std::string until;
  bool shrinks = false;
  app.add_option("--days", options.days, "virtual days");
  app.add_option("--seed", options.seed, "the same one does the same again");
  app.add_option("--production", options.production_h_per_day, "hours a day under correction, at most");
  app.add_option("--faults", faults, "all, none, or names");
  app.add_option("--until", until, "stop there: \"3 04:57:24.093\"");
  app.add_option("--trace", topics, "all, or topics of events: cell, campaign, fault, order, ...");
  app.add_flag("--own-kernels", options.own_kernels,
               "compute as the programs do on this processor; histories are the same on its like alone");
  app.add_flag("--shrink", shrinks, "which faults a broken promise needs");
  CLI11_PARSE(app, argc, argv);
  spdlog::set_level(spdlog::level::off);
  const std::set<std::string> named{faults.begin(), faults.end()}, shown{topics.begin(), topics.end()};
  if (named.contains("none")) options.faults.emplace();
  if (!named.empty() && !named.contains("none") && !named.contains("all")) options.faults = named;
  if (!until.empty()) options.until = world::time_in(until);
  if (!until.empty() && !options.until) {
    fmt::print(stderr, "soak: --until: not a time ({}). Give it as \"3 04:57:24\".\n", until);
    return 2;
  }
  options.trace = [&](const std::string& time, const std::string& topic, const std::string& text) {
    if (shown.contains("all") || shown.contains(topic)) fmt::print("{} {}: {:.400}\n", time, topic, text);
  };

  const std::clock_t begun = std::clock();
  const world::SoakReport report = world::soak(options);
  const double cpu_s = static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
  for (const auto& [name, count] : report.faults) fmt::print("{:22} {}\n", name, count);
  fmt::print(
      "seed {}, {} days in {:.1f} s of CPU ({:.0f} times real time): {} campaigns, {} points ({} of them "
      "compared with the truth, worst {:.3f} mm), {} looks, {} statuses, {} events of all clients, {} drift checks judged, "
      "{} programs, {} corrections as the model has them (worst {:.4f} mm), {} cycles in {} sessions, "
      "{} restarts (daemons of at most {:.1f} MB leave {} bytes), largest step {:.4f} deg, "
      "worst model {:.3f} mm and {:.1f} times what it says, history {:016x}\n",
      options.seed, options.days, cpu_s, options.days * 86400 / cpu_s, report.campaigns, report.points,
      report.points_compared, report.largest_point_error_mm, report.looks, report.statuses_compared,
      report.events_compared, report.drift_checks, report.programs, report.corrections_compared,
      report.largest_correction_error_mm, report.cycles, report.sessions, report.restarts,
      static_cast<double>(report.largest_daemon_bytes) / 1e6, report.largest_left_bytes,
      report.largest_step_deg, report.largest_model_error_mm, report.largest_model_ratio, report.hash);
  std::vector<std::string> unasked;
  std::ranges::set_difference(world::Methods{}.names(), report.methods, std::back_inserter(unasked));
  fmt::print("methods that no client asked for: {}\n", fmt::join(unasked, " "));
  if (report.broken.empty()) return 0;
  for (const std::string& event : report.broken.front().events) fmt::print("  {}\n", event);
  for (const world::BrokenPromise& broken : report.broken)
    fmt::print("BROKEN {} {}\n", world::time_text(broken.at), broken.promise);
  const auto behind = report.broken.front().at + std::chrono::seconds{1};
  fmt::print("again: soak --seed {} --days {} --production {} --until \"{}\" --trace all{}\n", options.seed,
             options.days, options.production_h_per_day, world::time_text(behind),
             options.own_kernels ? " --own-kernels" : "");
  if (shrinks) {
    options.until = behind;
    fmt::print("needed faults: {}\n", fmt::join(shrunk(options), " "));
  }
  return 1;
}
