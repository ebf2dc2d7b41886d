#include "tests/integration/live_cell.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <charconv>
#include <stdexcept>
#include <thread>

#include "tests/integration/power_cut.hpp"

namespace truepose {
namespace {

const std::string kConfig = TRUEPOSE_SOURCE_DIR "/config";
const std::string kShippedTimeout = "timeout_cycles: 100 ";

/// A shipped file with other texts in it. A text that is not there has been changed meanwhile: the test is
/// wrong.
std::string changed(const std::string& file, const Replacements& replacements) {
  std::string text = text_of(kConfig + "/" + file);
  for (const auto& [from, to] : replacements) {
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::runtime_error{file + " has no \"" + from + "\""};
    text.replace(at, from.size(), to);
  }
  return text;
}

Replacements together(Replacements first, const Replacements& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

std::string loopback(std::int64_t port) { return "127.0.0.1:" + std::to_string(port); }

/// One processor for the controller, its PC and this test, the controller first: what the machine takes away
/// for a while, a second even, is taken from all, and no side sees the other fall behind. Concurrent tests
/// may take another.
void share_one_processor() {
  static const bool shared = [] {
    cpu_set_t allowed;
    if (::sched_getaffinity(0, sizeof allowed, &allowed) != 0) return false;
    int skip = ::getpid() % CPU_COUNT(&allowed);
    for (std::size_t processor = 0; processor < CPU_SETSIZE; ++processor) {
      if (!CPU_ISSET(processor, &allowed) || skip-- > 0) continue;
      cpu_set_t one;
      CPU_ZERO(&one);
      CPU_SET(processor, &one);
      return ::sched_setaffinity(0, sizeof one, &one) == 0;
    }
    return false;
  }();
  static_cast<void>(shared);
}

}  // namespace

std::uint16_t free_udp_port() {
  using boost::asio::ip::udp;
  boost::asio::io_context context;
  return udp::socket{context, {boost::asio::ip::address_v4::loopback(), 0}}.local_endpoint().port();
}

LiveCell::LiveCell(const Options& options) {
  share_one_processor();
  const std::string timeout = options.patient ? "timeout_cycles: 2500 " : kShippedTimeout;
  const Replacements scenario{{"../robots", kConfig + "/robots"},
                              {"../kuka", kConfig + "/kuka"},
                              {"gluing.src", kConfig + "/scenarios/gluing.src"},
                              {"gluing.dat", kConfig + "/scenarios/gluing.dat"},
                              {kShippedTimeout, timeout},
                              {"faults: []", "faults: " + options.faults}};
  folder_.write("scenario.yaml", changed("scenarios/demo.yaml", together(scenario, options.scenario)));
  std::vector<std::string> arguments{"--scenario",   folder() / "scenario.yaml",
                                     "--ready-file", folder() / "ready.json",
                                     "--rsi-target", loopback(rsi_port_),
                                     "--admin-port", "0",
                                     "--speedup",    std::to_string(options.speedup),
                                     "--json"};
  simulator_ = std::make_unique<sim::SimulatorProcess>(folder_, std::move(arguments));
  const std::string ready = simulator_->ready(folder() / "ready.json");
  if (ready.empty()) throw std::runtime_error{"no simulator: " + simulator_->errors()};
  const boost::json::value ports = boost::json::parse(ready);
  admin_port_ = static_cast<std::uint16_t>(ports.at("admin_port").as_int64());
  const auto port = [&ports](const char* name) { return loopback(ports.at(name).as_int64()); };

  const Replacements cell{{"robots/kr210", kConfig + "/robots/kr210"},
                          {"kuka/rsi", kConfig + "/kuka/rsi"},
                          {"127.0.0.1:54600", port("eki_port")},
                          {"127.0.0.1:54601", port("eki_state_port")},
                          {"127.0.0.1:49152", loopback(rsi_port_)},
                          {"127.0.0.1:7000", port("tracker_port")},
                          {"127.0.0.1:7210", loopback(0)},
                          {"#web:", "web: {listen: " + loopback(0) + "} #"},
                          {kShippedTimeout, timeout},
                          {"priority: 80", "priority: 40"},  // the simulator's is 60
                          {"#runtime: /run/truepose/demo", "runtime: run"}};
  folder_.write("cell.yaml", changed("cell.yaml", together(cell, options.cell)));
  write_token("0123456789abcdef0123456789abcdef\n");
}

void LiveCell::write_token(const std::string& token) const {
  folder_.write("token", token);
  std::filesystem::permissions(token_file(), std::filesystem::perms::owner_read);
}

void LiveCell::start_daemon(std::vector<std::string> environment) {
  environment.push_back(notify_.environment());
  daemon_ = std::make_unique<Process>(
      folder(), "trueposed", std::vector<std::string>{"--config", cell_file()}, std::move(environment));
  std::string ready;
  while (ready.find("READY=1") == std::string::npos) {
    if (!daemon_->wait_readable(notify_.descriptor()))
      throw std::runtime_error{"no daemon: " + daemon_->errors()};
    ready = notify_.next();
  }
  const auto read_port = [&ready](const std::string& before, std::uint16_t& port) {
    const auto at = ready.find(before);
    if (at != ready.npos)
      std::from_chars(ready.data() + at + before.size(), ready.data() + ready.size(), port);
  };
  read_port("control port ", control_port_);
  read_port("TLS port ", tls_port_);
}

int LiveCell::cut_power(std::mt19937_64& random) {
  for (const auto& entry : std::filesystem::directory_iterator{folder() / "run"})
    std::filesystem::remove_all(entry.path());
  return test::cut_power(store_file(), random);
}

bool LiveCell::daemon_tells(const std::string& text) {
  while (daemon_->wait_readable(notify_.descriptor())) {
    if (notify_.next().find(text) != std::string::npos) return true;
  }
  return false;
}

Finished LiveCell::truepose(std::vector<std::string> arguments) const {
  for (const std::string& argument :
       {std::string{"--daemon"}, loopback(control_port_), std::string{"--token-file"}, token_file().string()})
    arguments.push_back(argument);
  return run_program("truepose", arguments);
}

tools::RpcClient LiveCell::client() const {
  auto client = tools::RpcClient::connect({loopback(control_port_), token_file()});
  if (!client) throw std::runtime_error{client.error().message};
  return *std::move(client);
}

boost::json::value LiveCell::steer(const boost::json::object& line) const {
  using boost::asio::ip::tcp;
  boost::asio::io_context context;
  tcp::socket socket{context};
  socket.connect({boost::asio::ip::address_v4::loopback(), admin_port_});
  boost::asio::write(socket, boost::asio::buffer(boost::json::serialize(line) + "\n"));
  std::string reply;
  boost::asio::read_until(socket, boost::asio::dynamic_buffer(reply), '\n');
  return boost::json::parse(reply);
}

boost::json::value LiveCell::simulated() const { return steer({{"ask", "statistics"}}); }

boost::json::value LiveCell::end_simulator() {
  simulator_->terminate();
  if (simulator_->wait() != 0) throw std::runtime_error{"the simulator failed: " + simulator_->errors()};
  return boost::json::parse(simulator_->output());
}

boost::json::value called(tools::RpcClient& client, const std::string& method,
                          const boost::json::object& params) {
  auto result = client.call(method, params);
  if (!result) throw std::runtime_error{method + ": " + result.error().message};
  return *std::move(result);
}

double number(const boost::json::value& value, const char* pointer) {
  return value.at_pointer(pointer).to_number<double>();
}

Finished small_campaign(const LiveCell& cell) {
  return cell.truepose(
      {"campaign", "start", "--identify", "12", "--validate", "6", "--remeasure", "--watch"});
}

}  // namespace truepose
