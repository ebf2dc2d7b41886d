#include "tests/world/mirror.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace json = boost::json;
using namespace std::chrono_literals;
using Wait = boost::asio::awaitable<void>;

void Mirror::take(const json::object& event) {
  constexpr std::array kChanging{"cell", "campaign", "model", "fault", "stream"};
  const std::string topic = text_at(event, "topic");
  if (topic == "cell" && !client_.is_late(event)) state_ = text_at(event.at("data").as_object(), "state");
  has_changed_ = has_changed_ || std::ranges::find(kChanging, topic) != kChanging.end();
  changed_.notify();
}

Wait Mirror::work() {
  for (;;) {
    while (!client_.is_connected()) {
      state_.clear();
      const bool open = co_await client_.connect();
      if (!open) co_await cell_.world.pass(1s);
    }
    co_await look();
    co_await cell_.world.pass(100ms);
    const drivers::TimePoint latest = log_.now() + 1min;
    while (!has_changed_ && log_.now() < latest) co_await changed_.wait_until(cell_.world.clock, latest);
  }
}

Wait Mirror::look() {
  has_changed_ = false;
  const json::value status = co_await client_.ask("cell.status");
  if (!is_result(status)) co_return;
  const std::string state = text_at(result_of(status), "state");
  if (state_.empty()) co_return;
  ++compared;
  if (state != state_) log_.broken("the status says " + state + ", the last event before it " + state_);
}

}  // namespace truepose::world
