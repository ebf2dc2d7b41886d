#include "tests/world/supervisor.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "drivers/net/spawn.hpp"
#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;
using Wait = asio::awaitable<void>;

void Supervisor::take(const json::object& event) {
  if (event.at("topic") != "control" || random_.uniform() < 0.3) return;
  const json::object& control = event.at("data").as_object();
  if (control.at("change") == "acquired" && text_at(control, "by") != cell_.supervisor.user())
    net::spawn(cell_.world.outside.get_executor(), cross(), net::rethrow);
}

Wait Supervisor::work(drivers::TimePoint end) {
  while (log_.now() < end) {
    co_await pass(20s, 12min);
    const bool open = co_await connect();
    if (!open) continue;
    const double which = random_.uniform();
    if (which < 0.6) {
      co_await look();
    } else if (which < 0.8) {
      co_await cross();
    } else {
      co_await take_control();
    }
  }
}

Wait Supervisor::look() {
  constexpr std::array kMethods{"campaign.list", "campaign.get", "stream.status",
                                "control.get",   "audit.list",   "system.info"};
  for (const std::string method : kMethods) co_await cell_.supervisor.ask(method);
  co_await agreement_.look();
}

/// Orders that the panel does not expect, and some that are not for operators.
Wait Supervisor::cross() {
  constexpr std::array kMethods{"campaign.pause",  "campaign.abort", "stream.arm",
                                "stream.disarm",   "stream.stop",    "cell.acknowledge",
                                "cell.disconnect", "model.rollback", "cell.connect"};
  const auto which = static_cast<std::size_t>(random_.uniform() * kMethods.size());
  const std::string method = kMethods.at(which);
  if (method == "cell.connect") {
    co_await connect_as_job();
    co_return;
  }
  const json::value answer = co_await orders_.give(method);
  if (method != "stream.arm" || !is_result(answer)) co_return;
  co_await pass(10s, 10min);
  co_await orders_.give("stream.disarm");
}

Wait Supervisor::connect_as_job() {
  json::object as_job{{"job", true}};
  const json::value begun = co_await orders_.give("cell.connect", std::move(as_job));
  if (!is_result(begun)) co_return;
  for (std::string state = "running"; state == "running";) {
    co_await pass(1s, 10s);
    json::object which{{"id", result_of(begun).at("job")}};
    const json::value job = co_await cell_.supervisor.ask("job.get", std::move(which));
    state = is_result(job) ? text_at(result_of(job), "state") : std::string{};
  }
}

/// For some leases; then gives it back, lets it run out, or loses it with the connection.
Wait Supervisor::take_control() {
  const auto lease_s = static_cast<std::int64_t>(random_.uniform(5, 60));
  const std::string first = random_.uniform() < 0.8 ? "control.acquire" : "control.takeover";
  json::object lease{{"lease_s", lease_s}};
  const json::value taken = co_await orders_.give(first, lease);
  if (!is_result(taken)) co_return;
  for (double more = random_.uniform(); more < 0.7; more = random_.uniform()) {
    co_await pass(1s, std::chrono::seconds{lease_s});
    co_await cell_.supervisor.ask("control.get");
    if (more < 0.3) co_await cross();
    co_await orders_.give("control.acquire", lease);
  }
  const double end = random_.uniform();
  if (end < 0.5) {
    co_await orders_.give("control.release");
  } else if (end < 0.8) {
    cell_.supervisor.disconnect();
    co_await pass(1s, 20s);
    co_await connect();
  }
  co_await cell_.supervisor.ask("control.get");
}

asio::awaitable<bool> Supervisor::connect() {
  if (cell_.supervisor.is_connected()) co_return true;
  const bool open = co_await cell_.supervisor.connect();
  co_return open;
}

Wait Supervisor::pass(drivers::Duration shortest, drivers::Duration longest) {
  const auto more = std::chrono::duration_cast<drivers::Duration>((longest - shortest) * random_.uniform());
  co_await cell_.world.pass(shortest + more);
}

}  // namespace truepose::world
