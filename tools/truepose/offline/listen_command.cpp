#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <map>
#include <memory>
#include <thread>

#include "config/cell_config.hpp"
#include "config/ethernet_file.hpp"
#include "config/text_file.hpp"
#include "drivers/kuka/rsi_port.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/doctor/rsi_report.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {
namespace {

using drivers::TimePoint;

struct ListenCommand {
  std::string where;
  std::string cell_file, ethernet_file;
  std::optional<double> seconds;
  std::optional<std::uint64_t> frames;
  bool json = false;
};

/// What to listen to, and what should come.
struct Expectation {
  config::Endpoint listen{"0.0.0.0", 0};
  std::optional<rsi::EthernetConfig> ethernet;
};

/// "49152" or "192.168.44.10:49152". Throws CommandError.
config::Endpoint endpoint_of(const std::string& where) {
  const bool number = where.find_first_not_of("0123456789") == std::string::npos;
  const auto endpoint = config::parse_endpoint(number ? "0.0.0.0:" + where : where);
  if (!endpoint) throw bad_usage("listen: " + endpoint.error());
  return *endpoint;
}

Expectation expectation_of(const ListenCommand& command) {
  Expectation expected;
  std::string ethernet_file = command.ethernet_file;
  if (!command.cell_file.empty()) {
    const config::StreamConfig stream = config::load_cell(command.cell_file).stream;
    expected.listen = stream.listen;
    ethernet_file = stream.ethernet_xml;
  }
  if (!ethernet_file.empty()) expected.ethernet = config::load_ethernet(ethernet_file);
  if (expected.ethernet && command.cell_file.empty()) expected.listen.port = expected.ethernet->port;
  if (!command.where.empty()) expected.listen = endpoint_of(command.where);
  if (expected.listen.port == 0)
    throw bad_usage("listen: give the port, or --cell or --ethernet, which name it");
  return expected;
}

std::atomic<bool> interrupted = false;

/// Tells once a second what each sender sent in it.
class Ticker {
 public:
  explicit Ticker(TimePoint now) : next_{now + kTick} {}

  void look(const RsiWatch& watch, TimePoint now) {
    if (now < next_) return;
    next_ = now + kTick;
    for (const RsiSender& sender : watch.senders()) {
      std::uint64_t& before = before_[text(sender.source)];
      print(sender_line(sender, sender.frames - before) + "\n");
      before = sender.frames;
    }
  }

 private:
  static constexpr std::chrono::seconds kTick{1};
  TimePoint next_;
  std::map<std::string, std::uint64_t> before_;
};

/// Until Ctrl-C, the time is over, or so many frames came.
void watch_port(drivers::RsiPort& port, const ListenCommand& command, RsiWatch& watch) {
  const TimePoint begin = std::chrono::steady_clock::now();
  Ticker ticker{begin};
  for (TimePoint now = begin; !interrupted; now = std::chrono::steady_clock::now()) {
    if (command.seconds && now - begin >= std::chrono::duration<double>(*command.seconds)) return;
    if (command.frames && watch.frames() >= *command.frames) return;
    if (const auto received = port.receive()) watch.take(received->datagram, received->cut);
    if (!command.json) ticker.look(watch, now);
  }
}

/// What is printed.
struct ListenReport {
  std::string listened;
  bool good = false;
  std::vector<SenderReport> senders;
};
void layout(record::Io& io, ListenReport& x) {
  io("listened", x.listened);
  io("good", x.good);
  io("senders", x.senders);
}

ListenReport report_of(const RsiWatch& watch, const Expectation& expected) {
  ListenReport report{.listened = config::text(expected.listen), .senders = {}};
  for (const RsiSender& sender : watch.senders()) {
    report.senders.push_back(sender_report(sender, expected.ethernet));
    report.good |= is_of_kind(sender, expected.ethernet);
  }
  return report;
}

std::string text_of(const ListenReport& report) {
  std::string lines;
  for (const SenderReport& sender : report.senders) lines += "\n" + sender_text(sender);
  if (!lines.empty()) return lines;
  return "no packet came to " + report.listened + ": run `truepose doctor --cell FILE`, which says why\n";
}

int run_listen(const ListenCommand& command) {
  const Expectation expected = expectation_of(command);
  auto port = drivers::RsiPort::bind(expected.listen.host, expected.listen.port, std::nullopt);
  if (!port) throw CommandError{kUnreachable, "listen: " + port.error().text};
  std::signal(SIGINT, [](int) { interrupted = true; });
  std::signal(SIGTERM, [](int) { interrupted = true; });
  if (!command.json)
    print("listening to " + config::text({expected.listen.host, port->number()}) + ", answering nothing\n");
  RsiWatch watch;
  watch_port(*port, command, watch);
  const ListenReport report = report_of(watch, expected);
  print(command.json ? control::json_text(record::to_json(report)) + "\n" : text_of(report));
  return report.good ? kDone : kFailed;
}

}  // namespace

Command listen_command() {
  const auto command = std::make_shared<ListenCommand>();
  ListenCommand& c = *command;
  return {.name = "listen",
          .help = "Who sends RSI datagrams here, and what; answers nothing",
          .options = {Option("PORT", &c.where,
                             "PORT or HOST:PORT of this PC; left out: that of --cell or --ethernet",
                             {.type = "PORT"}),
                      Option("--cell", &c.cell_file, "Cell file: its elements are expected",
                             {.excludes = {"--ethernet"}, .file = FileUse::Read}),
                      Option("--ethernet", &c.ethernet_file,
                             "RSI ethernet configuration (XML): its elements are expected",
                             {.file = FileUse::Read}),
                      Option("--for", &c.seconds, "End after so many seconds; default: Ctrl-C",
                             {.check = in_range(0.0, 1e9), .type = "SECONDS"}),
                      Option("--frames", &c.frames, "End after so many good frames"),
                      Option("--json", &c.json, "Print one JSON document")},
          .run = [command] { return run_listen(*command); },
          .task = Task::Diagnosis,
          .examples = {{"listen --cell cell.yaml --for 10"}, {"listen 49152"}}};
}

}  // namespace truepose::tools
