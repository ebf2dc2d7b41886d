// A simulated cell and its daemon on this machine: measured, calibrated and reported, without a file or
// device of the user.
#include <sys/stat.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/json/parse.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <thread>

#include "config/number_text.hpp"
#include "config/text_file.hpp"
#include "proto/record/json_io.hpp"
#include "proto/text/random_bytes.hpp"
#include "tools/truepose/cell/cell_commands.hpp"
#include "tools/truepose/cell/cell_file_text.hpp"
#include "tools/truepose/cell/child_process.hpp"

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;
namespace asio = boost::asio;

struct CellDemo {
  fs::path data = installed_data(), folder;
  double speedup = 100;
  std::string arm = "rigid";
  bool production = false;
};

/// Ports of the simulator's ready file.
struct SimulatorPorts {
  std::uint16_t eki = 0, eki_state = 0, tracker = 0, admin = 0;
};
void layout(record::Io& io, SimulatorPorts& x) {
  io("eki_port", x.eki);
  io("eki_state_port", x.eki_state);
  io("tracker_port", x.tracker);
  io("admin_port", x.admin);
}

std::string loopback(std::uint16_t port) { return config::text({"127.0.0.1", port}); }

/// Of the kernel's choice. Another program may take it before the daemon does, which then says so.
std::uint16_t free_udp_port() {
  using asio::ip::udp;
  asio::io_context io;
  return udp::socket{io, {asio::ip::address_v4::loopback(), 0}}.local_endpoint().port();
}

/// Waits until it is so. Throws CommandError (kFailed) where the program ends before, or needs too long.
void wait_until(const std::function<bool()>& is_so, ChildProcess& program, const std::string& what,
                const fs::path& log) {
  constexpr std::chrono::seconds kLongest{60};
  const auto until = std::chrono::steady_clock::now() + kLongest;
  while (!is_so()) {
    if (program.ended() || std::chrono::steady_clock::now() > until)
      throw CommandError{kFailed, what + " did not start. Its reason is in " + log.string() + "."};
    std::this_thread::sleep_for(std::chrono::milliseconds{20});
  }
}

bool is_served(const fs::path& control_socket) {
  using asio::local::stream_protocol;
  asio::io_context io;
  boost::system::error_code failed;
  stream_protocol::socket{io}.connect(control_socket.string(), failed);
  return !failed;
}

/// The folder for all files of a demo.
fs::path demo_folder(const CellDemo& demo) {
  if (demo.folder.empty()) {
    std::string name = (fs::temp_directory_path() / "truepose-demo-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw CommandError{kFailed, name + ": the folder cannot be made. Give another one (--out)."};
    return name;
  }
  if (fs::exists(demo.folder) && !fs::is_empty(demo.folder))
    throw CommandError{kBadInput, demo.folder.string() + ": is not empty. Give a new folder (--out)."};
  fs::create_directories(demo.folder);
  return fs::absolute(demo.folder);
}

void copy_data(const fs::path& data, const fs::path& folder) {
  for (const char* const part : {"robots", "kuka", "scenarios"}) {
    if (!fs::exists(data / part)) {
      throw CommandError{
          kBadInput,
          (data / part).string() +
              ": not found. Install the packages truepose and truepose-sim; from a build give --data config."};
    }
    fs::copy(data / part, folder / part, fs::copy_options::recursive);
  }
}

/// A demo that runs: simulator and daemon end with it.
class RunningDemo {
 public:
  RunningDemo(const CellDemo& demo, fs::path folder) : folder_{std::move(folder)}, demo_{demo} {
    copy_data(demo.data, folder_);
    const bool heavy = demo.arm == "heavy";
    const fs::path scenario = folder_ / "scenarios/demo.yaml";
    if (heavy) config::write_text_file(scenario, with_replaced(scenario, {{"#drives:", "drives:"}}));
    start_simulator(scenario);
    start_daemon(heavy);
  }

  /// Runs a command of this program against the daemon. @return whether it succeeded
  bool succeeds(std::vector<std::string> words) {
    words.insert(words.end(), {"--daemon", (folder_ / "run/control.sock").string()});
    exit_code_ = run_program("/proc/self/exe", words);
    return exit_code_ == kDone;
  }
  int exit_code() const { return exit_code_; }

  /// The program GLUING, corrected from its start to its end. @return whether it reached that
  bool corrects_production() {
    if (!succeeds({"stream", "arm"})) return false;
    require(steer(R"({"kind": "program-select", "program": "GLUING"})").contains("\"ok\":true"),
            "GLUING was not selected");
    print_to_stderr("GLUING works, about a minute and a half");
    constexpr int kLookInTheMidst = 80;
    for (int looks = 1;; ++looks) {
      const std::string program = steer(R"({"ask": "program"})");
      if (program.contains("\"ended\"")) break;
      require(program.contains("\"active\""), "GLUING has stopped: " + program);
      if (looks == kLookInTheMidst && !succeeds({"stream", "status"})) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds{500});
    }
    return succeeds({"stream", "disarm"});
  }

  bool reports() {
    std::vector<std::string> words{"report",          "--truth",    in("truth.json"), "--html",
                                   in("report.html"), "--out-json", in("report.json")};
    if (demo_.production) words.insert(words.end(), {"--path", in("path.csv")});
    return succeeds(std::move(words));
  }

  /// Ends both in order.
  void end() {
    require(daemon_->terminate() == kDone, "the daemon failed. Its reason is in " + in("daemon.log"));
    require(simulator_->terminate() == kDone, "the simulator failed. Its reason is in " + in("sim.log"));
  }

 private:
  static void require(bool is_so, const std::string& what) {
    if (!is_so) throw CommandError{kFailed, "cell demo: " + what};
  }
  std::string in(const char* file) const { return (folder_ / file).string(); }

  void start_simulator(const fs::path& scenario) {
    const std::string ready = in("sim.json");
    simulator_ = std::make_unique<ChildProcess>(
        installed_program("truepose-sim", "truepose-sim"),
        std::vector<std::string>{"--scenario",     scenario.string(),
                                 "--seed",         "0",
                                 "--speedup",      config::format_number(demo_.speedup),
                                 "--rsi-target",   loopback(rsi_port_),
                                 "--eki-port",     "0",
                                 "--tracker-port", "0",
                                 "--admin-port",   "0",
                                 "--path-file",    in("path.csv"),
                                 "--truth-file",   in("truth.json"),
                                 "--ready-file",   ready},
        in("sim.log"));
    wait_until([&] { return fs::exists(ready); }, *simulator_, "the simulated cell", in("sim.log"));
    ports_ = record::from_json<SimulatorPorts>(boost::json::parse(config::read_text_file(ready))).value();
  }

  void start_daemon(bool heavy) {
    Replacements cell{{"127.0.0.1:54600", loopback(ports_.eki)},
                      {"127.0.0.1:54601", loopback(ports_.eki_state)},
                      {"127.0.0.1:49152", loopback(rsi_port_)},
                      {"127.0.0.1:7000", loopback(ports_.tracker)},
                      {"127.0.0.1:7210", loopback(0)},
                      {"#web:", "web: {listen: 127.0.0.1:0} #"},
                      {"\n#runtime: /run/truepose/demo", "\nruntime: run"}};
    if (heavy) {
      cell.insert(cell.end(), {{"non_geometric: none", "non_geometric: auto"},
                               {"approach: any", "approach: alternate"},
                               {"identify_poses: 30", "identify_poses: 80"}});
    }
    std::string text = with_replaced(demo_.data / "cell.yaml", cell);
    // The installed file demands real-time priority, which the user of a demo seldom has.
    if (const std::size_t at = text.find("realtime: require"); at != text.npos)
      text.replace(at, std::string_view{"realtime: require"}.size(), "realtime: prefer ");
    config::write_text_file(in("cell.yaml"), text);
    const mode_t usual = ::umask(0077);
    config::write_text_file(in("token"), random_hex(16, kernel_random) + "\n");
    ::umask(usual);
    daemon_ = std::make_unique<ChildProcess>(installed_program("trueposed", "trueposed"),
                                             std::vector<std::string>{"--config", in("cell.yaml")},
                                             in("daemon.log"));
    wait_until([&] { return is_served(in("run/control.sock")); }, *daemon_, "the daemon", in("daemon.log"));
  }

  /// Has the simulated cell do something. @return what it answers
  std::string steer(const std::string& line) {
    asio::ip::tcp::iostream admin{"127.0.0.1", std::to_string(ports_.admin)};
    std::string answer;
    admin << line << std::endl;
    std::getline(admin, answer);
    return answer;
  }

  fs::path folder_;
  const CellDemo& demo_;
  std::uint16_t rsi_port_ = free_udp_port();
  SimulatorPorts ports_;
  int exit_code_ = kDone;
  std::unique_ptr<ChildProcess> simulator_, daemon_;
};

int run_demo(const CellDemo& demo) {
  installed_program("trueposed", "trueposed");
  installed_program("truepose-sim", "truepose-sim");
  const fs::path folder = demo_folder(demo);
  RunningDemo running{demo, folder};
  if (!running.succeeds({"connect"}) || !running.succeeds({"campaign", "start", "--watch"}) ||
      (demo.production && !running.corrects_production()) || !running.reports())
    return running.exit_code();
  running.end();
  std::printf("\nreport: %s, %s\n", (folder / "report.html").c_str(), (folder / "report.json").c_str());
  return kDone;
}

}  // namespace

Command cell_commands() {
  return {.name = "cell", .help = "A simulated cell, and the files of a real one", .task = Task::Cell};
}

Command cell_demo_command() {
  const auto command = std::make_shared<CellDemo>();
  CellDemo& c = *command;
  return {.name = "cell demo",
          .help = "Measures, calibrates and reports a simulated cell on this PC, with a daemon of its own",
          .options = {Option("--out", &c.folder,
                             "New folder for report, logs and files; default: one in /tmp", {.type = "DIR"}),
                      Option("--speedup", &c.speedup, "Robot and tracker are this much faster than real",
                             {.shows_default = true, .check = in_range(0.1, 10000.0)}),
                      Option("--arm", &c.arm,
                             "heavy: its joints also bend, have backlash and gear harmonics; 80 poses",
                             {.shows_default = true, .check = available({"rigid", "heavy"})}),
                      Option("--production", &c.production,
                             "Also correct a program while it works (KRL), in real time: two minutes more"),
                      Option("--data", &c.data, "Folder of the installed cell.yaml, robots, kuka, scenarios",
                             {.type = "DIR"})},
          .run = [command] { return run_demo(*command); }};
}

}  // namespace truepose::tools
