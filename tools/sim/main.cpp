#include <unistd.h>

#include <CLI/CLI.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <boost/system/system_error.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "config/number_text.hpp"
#include "config/scenario.hpp"
#include "config/text_file.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "tools/sim/cell_report.hpp"
#include "tools/sim/robot_datagram.hpp"
#include "tools/sim/simulated_cell.hpp"

namespace {

namespace asio = boost::asio;
namespace config = truepose::config;
namespace rsi = truepose::rsi;
namespace sim = truepose::sim;

constexpr int kBadUsage = 2;

struct Options {
  std::filesystem::path scenario;
  sim::CellOptions cell;
  std::string rsi_target;
  std::filesystem::path ready_file;
  std::filesystem::path truth_file;
  bool json = false;
};

/// One line for the operator, exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void describe_options(CLI::App& app, Options& options) {
  app.add_option("--scenario", options.scenario, "what the cell is and how it errs (YAML)")->required();
  app.add_option("--seed", options.cell.seed, "of repeatability and tracker noise");
  app.add_option("--rsi-target", options.rsi_target,
                 "HOST:PORT that the RSI datagrams go to, instead of the address in the RSI ethernet XML");
  app.add_option("--eki-port", options.cell.eki_port,
                 "CellLink; CellState listens on the next one; 0 picks two");
  app.add_option("--tracker-port", options.cell.tracker_port, "emScon; 0 picks one");
  app.add_option("--ready-file", options.ready_file, "written with the ports once all of them are open");
  app.add_option("--truth-file", options.truth_file, "written with the injected errors");
  app.add_option("--speedup", options.cell.speedup,
                 "robot and tracker are this much faster; RSI keeps real time")
      ->check(CLI::Range(0.1, 10'000.0));
  app.add_flag("--json", options.json, "print one document with the statistics at the end, and nothing else");
}

rsi::EthernetConfig load_ethernet_config(const std::filesystem::path& file) {
  std::ifstream in{file, std::ios::binary};
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw UsageError{file.string() + ": cannot be read"};
  auto config = rsi::parse_ethernet_config(text.str());
  if (!config) throw UsageError{file.string() + ": " + config.error()};
  if (const auto reason = sim::unsendable(*config)) throw UsageError{file.string() + ": " + *reason};
  return *std::move(config);
}

/// Numeric address and port of the PC, from the command line or else from the controller's own configuration.
void choose_rsi_target(Options& options, const rsi::EthernetConfig& ethernet) {
  std::string host = ethernet.address;
  std::uint16_t port = ethernet.port;
  if (!options.rsi_target.empty()) {
    const auto target = config::parse_endpoint(options.rsi_target);
    if (!target) throw UsageError{"--rsi-target: " + target.error()};
    host = target->host;
    port = target->port;
  }
  asio::io_context context;
  boost::system::error_code unknown;
  const auto found =
      asio::ip::udp::resolver{context}.resolve(asio::ip::udp::v4(), host, std::to_string(port), unknown);
  if (unknown) throw UsageError{"--rsi-target: " + host + ": " + unknown.message()};
  options.cell.rsi_host = found.begin()->endpoint().address().to_string();
  options.cell.rsi_port = port;
}

std::string ready_text(const sim::SimulatedCell::Ports& ports) {
  return boost::json::serialize(boost::json::object{{"eki_port", ports.eki},
                                                    {"eki_state_port", ports.eki_state},
                                                    {"tracker_port", ports.tracker},
                                                    {"pid", getpid()}});
}

/// SIGUSR1 writes the statistics so far to standard error, one line.
void report_when_asked(asio::signal_set& asks, const sim::SimulatedCell& cell,
                       const config::Scenario& scenario) {
  asks.async_wait([&](boost::system::error_code cancelled, int) {
    if (cancelled) return;
    std::fprintf(stderr, "%s\n", sim::statistics_json(cell.statistics(), scenario).c_str());
    report_when_asked(asks, cell, scenario);
  });
}

int run(Options options) {
  const config::Scenario scenario = config::load_scenario(options.scenario);
  const rsi::EthernetConfig ethernet = load_ethernet_config(scenario.ethernet_xml);
  choose_rsi_target(options, ethernet);

  asio::io_context io{1};
  sim::SimulatedCell cell{io.get_executor(), scenario, ethernet, options.cell};
  asio::signal_set ends{io, SIGTERM, SIGINT};
  ends.async_wait([&io](boost::system::error_code, int) { io.stop(); });

  asio::signal_set asks{io, SIGUSR1};
  report_when_asked(asks, cell, scenario);

  if (!options.truth_file.empty())
    config::write_text_file(options.truth_file, sim::truth_json(scenario) + "\n");
  if (!options.ready_file.empty())
    config::write_text_file(options.ready_file, ready_text(cell.ports()) + "\n");
  if (!options.json) {
    const sim::SimulatedCell::Ports ports = cell.ports();
    std::printf("EKI %u and %u, tracker %u, RSI to %s:%u\n", ports.eki, ports.eki_state, ports.tracker,
                options.cell.rsi_host.c_str(), options.cell.rsi_port);
    std::fflush(stdout);
  }
  io.run();

  if (options.json) std::puts(sim::statistics_json(cell.statistics(), scenario).c_str());
  if (!options.ready_file.empty()) std::filesystem::remove(options.ready_file);
  return 0;
}

int refuse(const std::string& line) {
  std::fprintf(stderr, "truepose-sim: %s\n", line.c_str());
  return kBadUsage;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app{
      "A simulated robot cell: a KUKA controller (EKI, RSI) and a laser tracker (emScon) over real sockets.",
      "truepose-sim"};
  Options options;
  describe_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& e) {
    return refuse(std::string{e.what()} + "; --help shows the options");
  }
  return run(std::move(options));
} catch (const std::exception& e) {
  return refuse(e.what());
}
