#include <unistd.h>

#include <array>
#include <boost/system/system_error.hpp>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <random>
#include <stdexcept>

#include "config/program_options.hpp"
#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/proxy/proxy.hpp"
#include "tools/steering/event_loop.hpp"
#include "tools/steering/exit_code.hpp"
#include "tools/steering/line_port.hpp"

namespace {

namespace config = truepose::config;
namespace proxy = truepose::proxy;
namespace record = truepose::record;
namespace steering = truepose::steering;
using config::UsageError, config::number_of;

constexpr const char* kHelp =
    R"(Stands between two devices and does to their packets what bad networks do.
Usage: truepose-proxy [OPTIONS]

Options:
  -h,--help            Print this help message and exit
  --udp LISTEN=TARGET  forward datagrams, both HOST:PORT; several may be given. Port 0 picks one
  --tcp LISTEN=TARGET  forward connections
  --set JSON           faults from the start; several may be given, the later ones on top
  --timeline FILE      the same, one object a line, each with "at_ms" after the start
  --admin PORT         listen there on 127.0.0.1 for the same, one object a line; 0 picks a port
  --seed UINT          of what happens by chance; left out: a random one
  --ready-file FILE    written with seed and addresses once all of them are open

An object: {"route": "LISTEN", "direction": "to_target", "loss": 0.01, "burst": 3}. Left out: all routes, both
directions. Numbers stay until they are set again:
  delay_ms, jitter_ms (up to so much more), truncate, corrupt (shares), nul_bytes (behind each);
  of datagrams: loss, duplicate, reorder (shares), burst (mean length of a row of losses);
  of TCP: bytes_per_s, coalesce_ms (what comes within it arrives as one piece), half_open (true: nothing goes on).
"clear": true sets all of them back first, "cut": true resets the TCP connections, "statistics": true counts.
Statistics are printed at the end too (SIGINT, SIGTERM).
)";

/// Exit code 3.
struct AddressError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Options {
  std::vector<proxy::RouteOptions> routes;
  std::vector<proxy::Command> faults, timeline;
  std::optional<std::uint16_t> admin;
  std::uint64_t seed = std::random_device{}();
  std::filesystem::path ready_file;
};

/// Throws UsageError.
template <typename T>
T value_of(const char* option, std::expected<T, std::string> result) {
  if (!result) throw UsageError{std::string{option} + ": " + result.error()};
  return *std::move(result);
}

using Known = config::ProgramOption<Options>;

constexpr std::array kKnown{
    Known{
        "udp",
        [](Options& o) { o.routes.push_back(value_of("--udp", parse_route(proxy::Protocol::Udp, optarg))); }},
    Known{
        "tcp",
        [](Options& o) { o.routes.push_back(value_of("--tcp", parse_route(proxy::Protocol::Tcp, optarg))); }},
    Known{"set", [](Options& o) { o.faults.push_back(value_of("--set", proxy::parse_command(optarg))); }},
    Known{"timeline",
          [](Options& o) {
            o.timeline = value_of(optarg, proxy::parse_timeline(config::read_text_file(optarg)));
          }},
    Known{"admin", [](Options& o) { o.admin = number_of<std::uint16_t>("--admin"); }},
    Known{"seed", [](Options& o) { o.seed = number_of<std::uint64_t>("--seed"); }},
    Known{"ready-file", [](Options& o) { o.ready_file = optarg; }}};

/// @return none where help was asked for, and is printed. Throws UsageError
std::optional<Options> options_of(int argc, char** argv) {
  auto options = config::read_options<Options>(argc, argv, kKnown, kHelp);
  if (options && options->routes.empty())
    throw UsageError{std::string{"--udp or --tcp is required"} + config::kSeeHelp};
  return options;
}

void obey(proxy::Proxy& proxy, const proxy::Command& command) {
  const proxy::Reply reply = proxy.obey(command);
  if (!reply.error.empty()) throw UsageError{"--set: " + reply.error};
}

/// What a line of the admin port comes to.
proxy::Reply reply_to(proxy::Proxy& proxy, const std::string& line) {
  const auto command = proxy::parse_command(line);
  if (!command) return {.error = command.error()};
  if (command->at) return {.error = "at_ms belongs into a timeline"};
  return proxy.obey(*command);
}

/// What is open, once all is.
struct Started {
  std::uint64_t seed = 0;
  std::vector<std::string> listen{};
  std::optional<std::uint16_t> admin{};
};
void layout(record::Io& io, Started& x) {
  io("seed", x.seed);
  io("listen", x.listen);
  io.optional("admin", x.admin);
}

std::string json_of(const auto& record) { return truepose::control::json_text(record::to_json(record)); }

void print_line(const std::string& line) {
  std::puts(line.c_str());
  std::fflush(stdout);
}

int run(const Options& options) {
  steering::EventLoop loop;
  proxy::Proxy proxy{loop.executor(), options.seed};
  Started started{.seed = options.seed};
  for (const proxy::RouteOptions& route : options.routes) {
    const auto listens = proxy.add(route);
    if (!listens) throw AddressError{listens.error()};
    started.listen.push_back(*listens);
  }
  for (const proxy::Command& command : options.faults) obey(proxy, command);
  std::optional<steering::LinePort> admin;
  if (options.admin) {
    admin.emplace(loop.executor(), *options.admin,
                  [&proxy](const std::string& line) { return json_of(reply_to(proxy, line)); });
    started.admin = admin->port();
  }
  print_line(json_of(started));
  if (!options.ready_file.empty()) config::write_text_file(options.ready_file, json_of(started) + "\n");
  proxy.follow(options.timeline);
  loop.run();
  print_line(json_of(proxy.statistics()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const auto options = options_of(argc, argv);
  return options ? run(*options) : 0;
} catch (const AddressError& e) {
  std::fprintf(stderr, "truepose-proxy: %s\n", e.what());
  return steering::kUnreachable;
} catch (const boost::system::system_error& e) {
  std::fprintf(stderr, "truepose-proxy: --admin: %s\n", e.code().message().c_str());
  return steering::kUnreachable;
} catch (const std::exception& e) {
  std::fprintf(stderr, "truepose-proxy: %s\n", e.what());
  return steering::kBadInput;
}
