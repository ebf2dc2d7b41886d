#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/system/system_error.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "config/ethernet_file.hpp"
#include "config/number_text.hpp"
#include "config/program_options.hpp"
#include "config/scenario.hpp"
#include "config/text_file.hpp"
#include "core/arm/joint_units.hpp"
#include "drivers/clock.hpp"
#include "proto/control/json_text.hpp"
#include "proto/eki/messages.hpp"
#include "proto/krl/lexer.hpp"
#include "proto/record/calibration_document.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "tools/sim/controller/rsi_datagrams.hpp"
#include "tools/sim/host_address.hpp"
#include "tools/sim/simulated_cell.hpp"
#include "tools/steering/event_loop.hpp"
#include "tools/steering/exit_code.hpp"
#include "tools/steering/line_port.hpp"

namespace truepose::sim {

void layout(record::Io& io, TurnaroundHistogram& x) {
  io("p50", x.percentile_us(0.5));
  io("p99", x.percentile_us(0.99));
  io("p999", x.percentile_us(0.999));
  io("max", x.max_us());
  std::vector<std::vector<std::int64_t>> counts;
  for (const auto& [us, count] : x.counts()) counts.push_back({us, count});
  io("counts", counts);
}
void layout(record::Io& io, SecondSenders& x) {
  io("cycles", x.cycles);
  io("answered", x.answered);
  io("max_step_deg", x.max_step_rad, record::Degrees{});
}
void layout(record::Io& io, RsiStatistics& x) {
  io("cycles", x.counters.cycles);
  io("answered", x.counters.answered);
  io("late", x.counters.late);
  io("lost", x.counters.lost);
  io("wrong_ipoc", x.counters.wrong_ipoc);
  io("rejected", x.counters.rejected);
  io("clamped", x.counters.clamped);
  io("max_step_deg", x.counters.max_step_rad, record::Degrees{});
  io("correction_deg", x.correction_in_effect_rad, record::Degrees{});
  io("correction_at_end_deg", x.counters.correction_rad, record::Degrees{});
  io("turnaround_us", x.turnaround);
  io("sessions", x.sessions);
  io("timeouts", x.timeouts);
  io("overruns", x.overruns);
  io("longest_overrun_us", std::chrono::ceil<std::chrono::microseconds>(x.longest_overrun));
  io("second_senders", x.second_senders);
}
void layout(record::Io& io, Controller::Program& x) {
  io("program", x.name);
  io("state", std::string{eki::name(x.state)});
  io("line", x.line);
}

}  // namespace truepose::sim

namespace {

namespace config = truepose::config;
namespace control = truepose::control;
namespace eki = truepose::eki;
namespace record = truepose::record;
namespace rsi = truepose::rsi;
namespace sim = truepose::sim;
namespace steering = truepose::steering;
using config::UsageError, config::number_of;

constexpr const char* kHelp =
    R"(A simulated robot cell: a KUKA controller (EKI, RSI) and a laser tracker (emScon) over real sockets.
Usage: truepose-sim [OPTIONS]

Options:
  -h,--help                   Print this help message and exit
  --scenario TEXT REQUIRED    what the cell is and how it errs (YAML)
  --seed UINT                 of repeatability and tracker noise
  --rsi-target TEXT           HOST:PORT that the RSI datagrams go to, instead of the address in the RSI ethernet XML
  --eki-port UINT             CellLink; CellState listens on the next one; 0 picks two. Other channels have their files' ports
  --tracker-port UINT         emScon; 0 picks one
  --bridge-port UINT          the tracker is behind a bridge, here, and speaks no emScon; 0 picks one
  --admin-port UINT           steers the cell: one line of JSON each, answered by one; 0 picks one. A fault of the
                              scenario that begins now, {"kind": "beam-break", "lasts_ms": 1500}, or a question,
                              {"ask": "program"} or {"ask": "statistics"}; or a hand that puts the
                              reflector elsewhere on the flange (mm), {"put_reflector": {"x": 0, "y": 0, "z": 250}},
                              or jogs the arm in T1 or T2 (deg), {"jog": [0, -90, 90, 0, 35, 0]}
  --ready-file TEXT           written with the ports once all of them are open
  --truth-file TEXT           written with the injected errors
  --path-file TEXT            written at each line of the admin port and at the end: what programs under RSI ask of the
                              arm, where its axes are, and where the tracker would see its reflector, with and without
                              corrections (CSV)
  --speedup FLOAT:FLOAT in [0.1 - 10000]
                              robot and tracker are this much faster; RSI keeps real time
  --json                      print one document with the statistics at the end, and nothing else

)";

struct Options {
  std::filesystem::path scenario;
  sim::CellOptions cell;
  std::string rsi_target;
  std::filesystem::path ready_file;
  std::filesystem::path truth_file;
  std::optional<std::uint16_t> admin_port;
  bool json = false;
};

std::uint16_t port_of(const char* option) {
  return number_of<std::uint16_t>(option, "a port of 0..65535", 0, 65535);
}

using Known = config::ProgramOption<Options>;

constexpr std::array kKnown{
    Known{"scenario", [](Options& o) { o.scenario = optarg; }},
    Known{"seed",
          [](Options& o) {
            o.cell.seed = number_of<std::uint64_t>("--seed", "a whole number", 0, UINT64_MAX);
          }},
    Known{"rsi-target", [](Options& o) { o.rsi_target = optarg; }},
    Known{"eki-port", [](Options& o) { o.cell.eki_port = port_of("--eki-port"); }},
    Known{"tracker-port", [](Options& o) { o.cell.tracker_port = port_of("--tracker-port"); }},
    Known{"bridge-port", [](Options& o) { o.cell.bridge_port = port_of("--bridge-port"); }},
    Known{"admin-port", [](Options& o) { o.admin_port = port_of("--admin-port"); }},
    Known{"path-file", [](Options& o) { o.cell.path_file = optarg; }},
    Known{"ready-file", [](Options& o) { o.ready_file = optarg; }},
    Known{"truth-file", [](Options& o) { o.truth_file = optarg; }},
    Known{"speedup",
          [](Options& o) { o.cell.speedup = number_of("--speedup", "a number of 0.1..10000", 0.1, 1e4); }},
    Known{"json", [](Options& o) { o.json = true; }, no_argument}};

/// @return none where help was asked for, and is printed. Throws UsageError
std::optional<Options> options_of(int argc, char** argv) {
  auto options = config::read_options<Options>(argc, argv, kKnown, kHelp);
  if (options && options->scenario.empty())
    throw UsageError{std::string{"--scenario is required"} + config::kSeeHelp};
  return options;
}

rsi::EthernetConfig sendable_ethernet(const std::filesystem::path& file) {
  rsi::EthernetConfig ethernet = config::load_ethernet(file);
  if (const auto reason = sim::unsendable(ethernet)) throw UsageError{file.string() + ": " + *reason};
  return ethernet;
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
  auto address = sim::address_of(host);
  if (!address) throw UsageError{"--rsi-target: " + host + ": " + address.error()};
  options.cell.rsi_host = *std::move(address);
  options.cell.rsi_port = port;
}

/// The injected truth.
record::Truth truth(const config::Scenario& scenario) {
  record::Truth truth{truepose::BasePose::of(scenario.X_WB), scenario.p_FS_mm, {}};
  for (const truepose::Joint& joint : scenario.truth.joints)
    truth.links.push_back({joint.a_mm, joint.alpha_rad, joint.d_mm, joint.theta_rad, joint.beta_rad});
  return truth;
}

/// What the cell did, with the truth.
struct CellDocument {
  sim::CellStatistics did;
  record::Truth truth;
};
void layout(record::Io& io, CellDocument& x) {
  io("rsi", x.did.rsi);
  io("moves", x.did.moves);
  io("measurements", x.did.measurements);
  io("truth", x.truth);
}

/// Written once all ports are open.
struct Ready {
  sim::SimulatedCell::Ports ports;
  bool by_bridge;
  std::optional<std::uint16_t> admin;
};
void layout(record::Io& io, Ready& x) {
  io(x.by_bridge ? "bridge_port" : "tracker_port", x.ports.tracker);
  io("pid", getpid());
  io.optional("eki_port", record::Unless<std::uint16_t>{0, x.ports.eki});
  io.optional("eki_state_port", record::Unless<std::uint16_t>{0, x.ports.eki_state});
  record::ByName<std::uint16_t> others;
  for (const sim::EkiPort& its : x.ports.others) others.emplace_back(its.channel, its.port);
  io.optional("eki_channels", others);
  io.optional("admin_port", x.admin);
}

/// A line of the admin port that is no fault of the scenario.
struct Steering {
  enum class Question { Program, Statistics };
  std::optional<Question> ask;
  std::optional<Eigen::Vector3d> put_reflector;
  std::optional<std::vector<double>> jog;
};
constexpr std::array kQuestions{truepose::Named{"program", Steering::Question::Program},
                                truepose::Named{"statistics", Steering::Question::Statistics}};
void layout(record::Io& io, Steering& x) {
  io.optional("ask", x.ask, kQuestions);
  io.optional("put_reflector", x.put_reflector, record::Xyz{});
  io.optional("jog", x.jog);
}

/// The answer to one that asked for nothing.
struct Outcome {
  std::string error;
};
void layout(record::Io& io, Outcome& x) {
  io.optional("error", x.error);
  io.where(x.error.empty(), "ok", true);
}

std::string json_of(const auto& record) { return control::json_text(record::to_json(record)); }

/// What a line of the admin port comes to.
std::string steered(const std::string& line, sim::SimulatedCell& cell, const config::Scenario& scenario) try {
  const auto parsed = control::parse_json(line);
  if (!parsed) return json_of(Outcome{parsed.error()});
  const auto asked = record::from_json<Steering>(*parsed);
  if (!asked) return json_of(Outcome{asked.error()});
  cell.flush_path();
  if (asked->ask == Steering::Question::Program) return json_of(cell.program());
  if (asked->ask == Steering::Question::Statistics)
    return json_of(CellDocument{cell.statistics(), truth(scenario)});
  if (asked->put_reflector) {
    cell.put_reflector(*asked->put_reflector);
  } else if (asked->jog) {
    if (std::ssize(*asked->jog) != scenario.nominal.joint_count())
      return json_of(Outcome{"jog: expected an angle for each axis"});
    cell.jog(truepose::joints_from(*asked->jog, scenario.nominal));
  } else {
    cell.begin(config::parse_fault(line));
  }
  return json_of(Outcome{});
} catch (const std::exception& e) {
  return json_of(Outcome{e.what()});
}

/// A line for each program of the archive that is not simulated as a whole: what data lists declare and no
/// program uses keeps nothing from running.
void print_not_simulated(const std::vector<sim::krl::Fault>& refusals) {
  std::map<std::string, std::vector<sim::krl::Fault>> by_file;
  for (const sim::krl::Fault& refusal : refusals) {
    if (!truepose::krl::in_capitals(refusal.file).ends_with(".DAT")) by_file[refusal.file].push_back(refusal);
  }
  for (const auto& [file, of_file] : by_file) {
    const auto first = std::ranges::min_element(of_file, {}, &sim::krl::Fault::line);
    std::printf(
        "%s: %zu %s not simulated, the first in line %d: %s. A program stops where it comes to one.\n",
        file.c_str(), of_file.size(), of_file.size() == 1 ? "statement is" : "statements are", first->line,
        first->what.c_str());
  }
}

/// "EKI 54600 and 54601, ", of truepose's own channels that the controller has.
std::string eki_text(const sim::SimulatedCell::Ports& ports) {
  std::string text;
  for (const std::uint16_t port : {ports.eki, ports.eki_state}) {
    if (port != 0) text += (text.empty() ? "EKI " : " and ") + std::to_string(port);
  }
  return text.empty() ? text : text + ", ";
}

int run(Options options) {
  const config::Scenario scenario = config::load_scenario(options.scenario);
  const rsi::EthernetConfig ethernet = sendable_ethernet(scenario.ethernet_xml);
  choose_rsi_target(options, ethernet);

  truepose::drivers::SteadyClock clock;
  steering::EventLoop loop;
  sim::SimulatedCell cell{{.io = loop.executor(), .clock = clock}, scenario, ethernet, options.cell};
  std::optional<steering::LinePort> admin;
  if (options.admin_port) {
    try {
      admin.emplace(loop.executor(), *options.admin_port,
                    [&](const std::string& line) { return steered(line, cell, scenario); });
    } catch (const boost::system::system_error& e) {
      throw sim::PortError{"admin", *options.admin_port, e.code()};
    }
  }

  if (!options.truth_file.empty())
    config::write_text_file(options.truth_file, json_of(truth(scenario)) + "\n");
  if (!options.ready_file.empty())
    config::write_text_file(options.ready_file,
                            json_of(Ready{cell.ports(), options.cell.bridge_port.has_value(),
                                          admin ? std::optional{admin->port()} : std::nullopt}) +
                                "\n");
  if (!options.json) {
    const sim::SimulatedCell::Ports ports = cell.ports();
    std::printf("%s%s %u, RSI to %s:%u\n", eki_text(ports).c_str(),
                options.cell.bridge_port ? "tracker's bridge" : "tracker", ports.tracker,
                options.cell.rsi_host.c_str(), options.cell.rsi_port);
    for (const sim::EkiPort& its : ports.others)
      std::printf("EKI channel %s: port %u\n", its.channel.c_str(), its.port);
    print_not_simulated(cell.not_simulated());
    std::fflush(stdout);
  }
  loop.run();

  if (options.json) std::puts(json_of(CellDocument{cell.statistics(), truth(scenario)}).c_str());
  if (!options.ready_file.empty()) std::filesystem::remove(options.ready_file);
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  auto options = options_of(argc, argv);
  return options ? run(*std::move(options)) : 0;
} catch (const sim::PortError& e) {
  std::fprintf(stderr, "truepose-sim: %s\n", e.what());
  return steering::kUnreachable;
} catch (const std::exception& e) {
  std::fprintf(stderr, "truepose-sim: %s\n", e.what());
  return steering::kBadInput;
}
