// The files of a new cell: cell file, token, and what its controller loads.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <system_error>

#include "config/cell_config.hpp"
#include "config/import/machine_data.hpp"
#include "config/number_text.hpp"
#include "config/robot_file.hpp"
#include "config/text_file.hpp"
#include "daemon/device_probe.hpp"
#include "proto/text/random_bytes.hpp"
#include "tools/truepose/cell/cell_commands.hpp"
#include "tools/truepose/cell/cell_file_text.hpp"
#include "tools/truepose/cell/child_process.hpp"
#include "tools/truepose/cell/questions.hpp"
#include "tools/truepose/offline/controller_set.hpp"
#include "tools/truepose/offline/imported_robot.hpp"

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;

struct CellNew {
  fs::path folder = ".", data = installed_data();
  std::string name, robot, controller, rsi_peer, rsi_listen, tracker, control, kss, protocol = "emscon";
};

constexpr std::uint16_t kLinkPort = 54600, kTrackerPort = 700, kRsiPort = 49152;

/// HOST or HOST:PORT.
std::expected<config::Endpoint, std::string> endpoint_of(const std::string& text, std::uint16_t usual) {
  if (!text.contains(':')) return config::parse_endpoint(text + ":" + std::to_string(usual));
  return config::parse_endpoint(text);
}

std::string why_no_endpoint(const std::string& text, std::uint16_t usual) {
  const auto endpoint = endpoint_of(text, usual);
  return endpoint ? "" : endpoint.error();
}

/// Of the unit, of folders and of the cell file alike.
std::string why_no_name(const std::string& name) {
  const bool fits = !name.empty() && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
  return fits ? "" : "expected letters, digits, _ and -, found " + config::in_quotes(name);
}

/// One of the installed robots, a robot file, or the controller's machine data.
fs::path robot_source(const CellNew& cell) {
  const fs::path installed = cell.data / "robots" / (cell.robot + ".yaml");
  return fs::absolute(fs::exists(installed) ? installed : fs::path{cell.robot}).lexically_normal();
}

/// As the cell file names it: an arm from an archive has its file among those of the cell.
fs::path robot_file(const CellNew& cell) {
  const fs::path source = robot_source(cell);
  return has_machine_data(source) ? fs::path{cell.name} / "robot.yaml" : source;
}

std::string why_no_robot(CellNew cell, const std::string& robot) {
  cell.robot = robot;
  const fs::path source = robot_source(cell);
  try {
    has_machine_data(source) ? config::load_machine_data(source) : config::load_robot(source);
  } catch (const config::ConfigError& error) {
    return error.what();
  }
  return "";
}

/// This PC's address towards the controller; empty where no network of this PC has it.
std::string address_towards(const std::string& host) {
  using boost::asio::ip::udp;
  boost::asio::io_context io;
  boost::system::error_code failed;
  const auto address = boost::asio::ip::make_address_v4(host, failed);
  udp::socket socket{io, udp::v4()};
  if (!failed) socket.connect({address, kRsiPort}, failed);
  if (failed) return "";
  const auto ours = socket.local_endpoint().address();
  return ours.is_loopback() ? "" : ours.to_string();
}

std::string rsi_listen_default(const CellNew& cell) {
  const std::string towards = address_towards(cell.rsi_peer);
  return config::text({towards.empty() ? "192.168.44.10" : towards, kRsiPort});
}

std::string why_not_of(const std::vector<std::string_view>& choices, const std::string& value) {
  if (std::ranges::find(choices, value) != choices.end()) return "";
  std::string all;
  for (const std::string_view choice : choices) all += (all.empty() ? "" : ", ") + std::string{choice};
  return "expected one of " + all + ", found " + config::in_quotes(value);
}

void ask_all(CellNew& c) {
  const auto with_port = [](std::uint16_t usual) {
    return [usual](const std::string& text) { return why_no_endpoint(text, usual); };
  };
  const auto says = [](std::string text) { return [text] { return text; }; };
  ask({{&c.name, "Name of the cell", says("cell1"), why_no_name},
       {&c.robot, "Robot: file, KUKA archive, or name of an installed one", says("kr210_r2700_2"),
        [&](const std::string& robot) { return why_no_robot(c, robot); }},
       {&c.controller, "Controller, network of EKI (KLI): HOST or HOST:PORT", says("172.31.1.147"),
        with_port(kLinkPort)},
       {&c.rsi_peer, "Controller, network of RSI: HOST",
        [&] { return endpoint_of(c.controller, kLinkPort)->host; }, with_port(kRsiPort)},
       {&c.rsi_listen, "This PC, network of RSI: HOST or HOST:PORT", [&] { return rsi_listen_default(c); },
        with_port(kRsiPort)},
       {&c.tracker, "Tracker: HOST or HOST:PORT", says("192.168.0.1"), with_port(kTrackerPort)},
       {&c.control, "Control port of the daemon: HOST:PORT", says("127.0.0.1:7210"), with_port(7210)},
       {&c.kss, "Version of the controller's software (KSS)", says("8.6"),
        [](const std::string& kss) { return why_not_of(kss_names(), kss); }}});
}

bool is_of_service(const CellNew& c) { return fs::weakly_canonical(c.folder) == "/etc/truepose"; }

/// As the cell file names it: the service may not write to its folder in /etc.
fs::path store_folder(const CellNew& c) {
  return is_of_service(c) ? fs::path{"/var/lib/truepose"} / c.name : fs::path{c.name};
}

/// The cell file, for a place where a folder of the cell's name stands next to it.
/// @param model  the controller's own name of the arm; empty: not known
std::string cell_text(const CellNew& c, const std::string& ethernet_xml, const std::string& model) {
  const config::Endpoint motion = *endpoint_of(c.controller, kLinkPort);
  const config::Endpoint state{motion.host, static_cast<std::uint16_t>(motion.port + 1)};
  std::string text = with_replaced(
      c.data / "cell.yaml",
      {{"# An example cell: one KUKA arm and one laser tracker, here both simulated on this machine.",
        "# Made by `truepose cell new`. Enter tracker.robot_base, reflector and surroundings of this cell."},
       {"name: demo", "name: " + c.name},
       {"file: robots/kr210_r2700_2.yaml", "file: " + robot_file(c).string()},
       {"eki_motion: 127.0.0.1:54600", "eki_motion: " + config::text(motion)},
       {"eki_state: 127.0.0.1:54601", "eki_state: " + config::text(state)},
       {"rsi_peer: 127.0.0.1", "rsi_peer: " + endpoint_of(c.rsi_peer, kRsiPort)->host},
       {"expect_model: KR210R2700_2",
        model.empty() ? "#expect_model: NAME" : "expect_model: \"" + model + "\""},
       {"listen: 127.0.0.1:49152", "listen: " + config::text(*endpoint_of(c.rsi_listen, kRsiPort))},
       {"ethernet_xml: kuka/rsi/truepose_rsi_ethernet.xml", "ethernet_xml: " + ethernet_xml},
       {"protocol: emscon", "protocol: " + c.protocol},
       {"address: 127.0.0.1:7000", "address: " + config::text(*endpoint_of(c.tracker, kTrackerPort))},
       {"reflector: CCR-1.5in", "#reflector: NAME"},
       {"listen: 127.0.0.1:7210", "listen: " + config::text(*endpoint_of(c.control, 7210))},
       {"token_file: token", "token_file: " + c.name + "/token"},
       {"store: demo.sqlite", "store: " + (store_folder(c) / (c.name + ".sqlite")).string()},
       {"/run/truepose/demo", "/run/truepose/" + c.name}});
  // The example runs without real-time priority, a cell must not.
  constexpr std::string_view kOfExample = "realtime: prefer ";
  if (const std::size_t at = text.find(kOfExample); at != text.npos)
    text.replace(at, kOfExample.size(), "realtime: require");
  return text;
}

/// Asks the devices who they are, and says it. @return the controller's own name of the arm; empty: no answer
std::string probed_model(const config::CellConfig& cell) {
  const auto robot = daemon::observe_robot(cell.robot);
  const auto tracker = daemon::observe_tracker(cell.tracker);
  std::printf("robot    %s\n", robot ? robot->identity.model.c_str() : robot.error().detail.c_str());
  std::printf("tracker  %s\n", tracker ? tracker->model.c_str() : tracker.error().detail.c_str());
  return robot ? robot->identity.model : "";
}

/// Root's files are read by the group of the folder, as the daemon's of /etc/truepose. None: only by their
/// owner.
std::optional<gid_t> shared_group(const fs::path& folder) {
  struct stat found {};
  if (::geteuid() != 0 || ::stat(folder.c_str(), &found) != 0 || found.st_gid == 0) return std::nullopt;
  return found.st_gid;
}

/// All files in a folder of their own, which goes with it where they do not take their places.
class StagedCell {
 public:
  explicit StagedCell(const CellNew& cell) : cell_{cell} {
    std::error_code failed;
    made_ = fs::create_directories(cell.folder, failed);
    std::string name = (cell.folder / ("." + cell.name + "-XXXXXX")).string();
    if (!failed && ::mkdtemp(name.data()) == nullptr) failed = {errno, std::generic_category()};
    if (failed) {
      throw CommandError{kBadInput, cell.folder.string() + ": cannot be written to (" + failed.message() +
                                        "). Give another folder (--out)" +
                                        (::geteuid() == 0 ? "." : ", or run as root.")};
    }
    stage_ = name;
    fs::create_directory(stage_ / cell.name);
  }
  ~StagedCell() {
    std::error_code ignored;
    fs::remove_all(stage_, ignored);
    if (made_) fs::remove(cell_.folder, ignored);  // where it is empty
  }
  StagedCell(const StagedCell&) = delete;
  StagedCell& operator=(const StagedCell&) = delete;

  void fill() {
    write(cell_.name + "/token", random_hex(16, kernel_random) + "\n");
    if (const fs::path source = robot_source(cell_); has_machine_data(source))
      write(robot_file(cell_), imported_robot_text({config::load_machine_data(source), {}}, source));
    const std::string ethernet_xml =
        cell_.name + (is_iiqka(cell_.kss) ? "/kuka/RobotSensorInterface/" : "/kuka/SensorInterface/") +
        "truepose_rsi_ethernet.xml";
    write(file(), cell_text(cell_, ethernet_xml, ""));
    const config::CellConfig config = config::load_cell(stage_ / file());
    for (const ControllerFile& its : controller_files_of(config, file(), cell_.kss))
      write(cell_.name + "/kuka/" + its.name, its.text);
    if (const std::string model = probed_model(config); !model.empty())
      write(file(), cell_text(cell_, ethernet_xml, model));
    share_with_group();
  }

  /// The cell file last: where it is, all else is.
  void take_place() const {
    const fs::path folder = cell_.folder / cell_.name;
    fs::rename(stage_ / cell_.name, folder);
    try {
      fs::rename(stage_ / file(), cell_.folder / file());
    } catch (...) {
      fs::remove_all(folder);
      throw;
    }
  }

 private:
  std::string file() const { return cell_.name + ".yaml"; }
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((stage_ / name).parent_path());
    config::write_text_file(stage_ / name, text);
  }
  void share_with_group() const {
    const auto group = shared_group(cell_.folder);
    if (!group) return;
    for (const auto& entry : fs::recursive_directory_iterator{stage_}) {
      if (::lchown(entry.path().c_str(), static_cast<uid_t>(-1), *group) != 0)
        throw CommandError{kFailed, entry.path().string() + ": its group cannot be set"};
      fs::permissions(entry.path(), fs::perms::group_read, fs::perm_options::add);
      if (entry.is_directory()) fs::permissions(entry.path(), fs::perms::group_exec, fs::perm_options::add);
    }
  }

  const CellNew& cell_;
  fs::path stage_;
  bool made_ = false;  // the folder that it stands in
};

int run_new(CellNew& cell) {
  const fs::path daemon = installed_program("trueposed", "trueposed");
  ask_all(cell);
  const fs::path file = cell.folder / (cell.name + ".yaml"), folder = cell.folder / cell.name;
  for (const fs::path& taken : {file, folder}) {
    if (fs::exists(taken))
      throw CommandError{kBadInput,
                         taken.string() + ": is there already. Choose another name, or remove it."};
  }
  if (is_of_service(cell)) fs::create_directories(store_folder(cell));  // the unit makes it the daemon's
  const mode_t usual = ::umask(0077);
  StagedCell staged{cell};
  staged.fill();
  staged.take_place();
  ::umask(usual);
  if (has_machine_data(robot_source(cell)))
    std::printf("%s: robot, from the archive. Compare it with the pendant: truepose robot check\n",
                (cell.folder / robot_file(cell)).c_str());
  std::printf(
      "%s: cell file. Enter tracker.robot_base, reflector and surroundings.\n%s: token of the control port\n"
      "%s: what the controller loads; where each file goes: truepose kuka write --help, docs/kuka.md\n\n",
      file.c_str(), (folder / "token").c_str(), (folder / "kuka").c_str());
  // The daemon accepts a token that its own group can read.
  if (const auto group = shared_group(cell.folder); group && ::setgid(*group) != 0)
    throw CommandError{kFailed, "the group of " + cell.folder.string() + " cannot be taken"};
  return run_program(daemon, {"--config", file.string(), "--check", "--probe"});
}

}  // namespace

Command cell_new_command() {
  const auto command = std::make_shared<CellNew>();
  CellNew& c = *command;
  const auto option = [](const char* name, std::string& value, const char* help, const char* type) {
    return Option(name, &value, std::string{help} + "; asked for where it is not given", {.type = type});
  };
  return {
      .name = "cell new",
      .help =
          "Writes cell file, token and the controller's files of a cell, and checks them with its devices",
      .options = {option("--name", c.name, "Name of the cell", "NAME"),
                  option("--robot", c.robot, "Robot file, KUKA archive, or name of an installed one", "FILE"),
                  option("--controller", c.controller,
                         "Controller in the network of EKI; CellState has the next port", "HOST[:PORT]"),
                  option("--rsi-peer", c.rsi_peer, "Controller in the network of RSI", "HOST"),
                  option("--rsi-listen", c.rsi_listen, "This PC in the network of RSI", "HOST[:PORT]"),
                  option("--tracker", c.tracker, "Tracker, or the bridge to it", "HOST[:PORT]"),
                  option("--control", c.control, "Control port of the daemon", "HOST[:PORT]"),
                  option("--kss", c.kss, "Version of the controller's software", "VERSION"),
                  Option("--protocol", &c.protocol, "Protocol of the tracker",
                         {.shows_default = true, .check = available({"emscon", "bridge"})}),
                  Option("--out", &c.folder, "Folder for the files; of the service: /etc/truepose",
                         {.shows_default = true, .type = "DIR"}),
                  Option("--data", &c.data, "Folder of the installed cell.yaml and robots", {.type = "DIR"})},
      .run = [command] { return run_new(*command); }};
}

}  // namespace truepose::tools
