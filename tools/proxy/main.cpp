#include <getopt.h>
#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/system/system_error.hpp>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>

#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "tools/proxy/admin_port.hpp"
#include "tools/proxy/proxy.hpp"

namespace {

namespace asio = boost::asio;
namespace json = boost::json;
namespace config = truepose::config;
namespace proxy = truepose::proxy;

constexpr int kBadUsage = 2, kUnreachable = 3;
constexpr const char* kSeeHelp = "; --help shows the options";

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
directions. Numbers stay until they are set anew:
  delay_ms, jitter_ms (up to so much more), truncate, garble (shares), nul_bytes (behind each);
  of datagrams: loss, duplicate, reorder (shares), burst (mean length of a row of losses);
  of TCP: bytes_per_s, join_ms (what comes within it arrives as one piece), half_open (true: nothing goes on).
"clear": true sets all of them back first, "cut": true resets the TCP connections, "statistics": true counts.
Statistics are printed at the end too (SIGINT, SIGTERM).
)";

/// One line for the operator, exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
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

template <typename Number>
Number number_of(const char* option) {
  const std::string_view text{optarg};
  Number number{};
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault == std::errc{} && end == text.data() + text.size()) return number;
  throw UsageError{std::string{option} + ": expected a whole number, found " + config::in_quotes(text) +
                   kSeeHelp};
}

/// An option, and what it does with its value.
struct Known {
  const char* name;
  void (*take)(Options& options);
};

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
std::optional<Options> read_options(int argc, char** argv) {
  std::array<option, kKnown.size() + 2> names{};  // the last one ends the list
  for (std::size_t i = 0; i < kKnown.size(); ++i)
    names[i] = {kKnown[i].name, required_argument, nullptr, static_cast<int>(i)};
  names[kKnown.size()] = {"help", no_argument, nullptr, 'h'};
  Options options;
  opterr = 0;
  for (int found; (found = getopt_long(argc, argv, ":h", names.data(), nullptr)) != -1;) {
    if (found == 'h') {
      std::fputs(kHelp, stdout);
      return std::nullopt;
    }
    const std::string word = argv[optind - 1];
    if (found == ':') throw UsageError{word + " needs a value" + kSeeHelp};
    if (found == '?') throw UsageError{word + " is no option" + kSeeHelp};
    kKnown[static_cast<std::size_t>(found)].take(options);
  }
  if (optind < argc) throw UsageError{std::string{argv[optind]} + " belongs to no option" + kSeeHelp};
  if (options.routes.empty()) throw UsageError{std::string{"--udp or --tcp is required"} + kSeeHelp};
  return options;
}

void obey(proxy::Proxy& proxy, const proxy::Command& command) {
  const json::object reply = proxy.obey(command);
  if (const json::value* error = reply.if_contains("error"))
    throw UsageError{"--set: " + std::string{error->as_string()}};
}

void print_line(const json::value& value) {
  std::puts(truepose::control::json_text(value).c_str());
  std::fflush(stdout);
}

int run(const Options& options) {
  asio::io_context io{1};
  proxy::Proxy proxy{io.get_executor(), options.seed};
  json::array addresses;
  for (const proxy::RouteOptions& route : options.routes) {
    const auto listens = proxy.add(route);
    if (!listens) throw AddressError{listens.error()};
    addresses.emplace_back(*listens);
  }
  for (const proxy::Command& command : options.faults) obey(proxy, command);
  json::object started{{"seed", options.seed}, {"listen", std::move(addresses)}};
  std::optional<proxy::AdminPort> admin;
  if (options.admin) {
    admin.emplace(io.get_executor(), *options.admin, proxy);
    started["admin"] = admin->port();
  }
  print_line(started);
  if (!options.ready_file.empty())
    config::write_text_file(options.ready_file, truepose::control::json_text(started) + "\n");
  asio::signal_set ends{io, SIGTERM, SIGINT};
  ends.async_wait([&io](boost::system::error_code, int) { io.stop(); });
  proxy.follow(options.timeline);
  io.run();
  print_line(proxy.statistics());
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const auto options = read_options(argc, argv);
  return options ? run(*options) : 0;
} catch (const AddressError& e) {
  std::fprintf(stderr, "truepose-proxy: %s\n", e.what());
  return kUnreachable;
} catch (const boost::system::system_error& e) {
  std::fprintf(stderr, "truepose-proxy: --admin: %s\n", e.code().message().c_str());
  return kUnreachable;
} catch (const std::exception& e) {
  std::fprintf(stderr, "truepose-proxy: %s\n", e.what());
  return kBadUsage;
}
