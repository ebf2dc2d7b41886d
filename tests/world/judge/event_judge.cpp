#include "tests/world/judge/event_judge.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/value_to.hpp>
#include <string_view>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace json = boost::json;

namespace {

constexpr std::size_t kMany = 1000;

/// The reference keeps others of some topics alone.
bool is_kept(std::string_view topic) {
  constexpr std::array<std::string_view, 6> kKept{"cell",  "campaign", "measurement",
                                                  "model", "fault",    "control"};
  return std::ranges::find(kKept, topic) != kKept.end();
}

}  // namespace

void EventJudge::take(std::size_t client, const json::object& event) {
  const auto seq = event.at("seq").to_number<Seq>();
  if (event.contains("dropped") && seq > 0) missing_[client].emplace_back(last_[client] + 1, seq - 1);
  last_[client] = seq;
  std::string topic = text_at(event, "topic");
  if (seq <= judged_ || !is_kept(topic)) return;
  Seen& seen = events_[seq];
  seen.by[client] = true;
  seen.topic = std::move(topic);
  if (events_.size() > kMany) judge();
}

void EventJudge::subscribed(std::size_t client, const json::object& answer) {
  const json::array& missing = answer.at("missing").as_array();
  for (const json::value& each : missing) {
    const json::object& range = each.as_object();
    missing_[client].emplace_back(range.at("first").to_number<Seq>(), range.at("last").to_number<Seq>());
  }
  if (answer.at("complete").as_bool() != missing.empty())
    log_.broken("events that may be missing, and `complete`, contradict each other");
}

void EventJudge::restored() {
  judged_ = std::max(last_[0], last_[1]);
  events_.clear();
}

bool EventJudge::may_miss(std::size_t client, Seq seq) const {
  return std::ranges::any_of(missing_[client],
                             [seq](const auto& range) { return range.first <= seq && seq <= range.second; });
}

void EventJudge::judge() {
  const Seq common = std::min(last_[0], last_[1]);
  for (auto event = events_.begin(); event != events_.end() && event->first <= common;) {
    const auto& [seq, seen] = *event;
    for (std::size_t client = 0; client < seen.by.size(); ++client)
      if (!seen.by[client] && !may_miss(client, seq))
        log_.broken("event " + std::to_string(seq) + " of " + seen.topic + " never comes to " +
                    (client == 0 ? "the panel" : "the supervisor"));
    ++compared;
    event = events_.erase(event);
  }
  judged_ = std::max(judged_, common);
}

}  // namespace truepose::world
