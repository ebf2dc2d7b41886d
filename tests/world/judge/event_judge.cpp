#include "tests/world/judge/event_judge.hpp"

#include <algorithm>
#include <array>
#include <boost/json/array.hpp>
#include <boost/json/value_to.hpp>
#include <string_view>
#include <utility>

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

EventJudge::EventJudge(const std::vector<std::string>& clients, SoakLog& log) : log_{log} {
  for (const std::string& name : clients) readers_.push_back({.name = name});
}

void EventJudge::take(std::size_t client, const json::object& event) {
  const auto seq = event.at("seq").to_number<Seq>();
  Reader& reader = readers_.at(client);
  if (const json::value* const dropped = event.if_contains("dropped")) {
    Gap gap{.first = reader.last + 1, .last = seq - 1};
    for (const auto& [topic, count] : dropped->as_object()) gap.topics.insert(topic);
    reader.gaps.push_back(std::move(gap));
  }
  reader.last = seq;
  std::string topic = text_at(event, "topic");
  if (seq <= judged_ || !is_kept(topic)) return;
  Seen& seen = events_[seq];
  seen.by.insert(client);
  seen.topic = std::move(topic);
  if (events_.size() % kMany == 0) judge();
}

void EventJudge::subscribed(std::size_t client, const json::object& answer) {
  const json::array& missing = answer.at("missing").as_array();
  for (const json::value& each : missing) {
    const json::object& range = each.as_object();
    readers_.at(client).gaps.push_back(
        {.first = range.at("first").to_number<Seq>(), .last = range.at("last").to_number<Seq>()});
  }
  if (answer.at("complete").as_bool() != missing.empty())
    log_.broken("events that may be missing, and `complete`, contradict each other");
}

void EventJudge::restored() {
  judged_ = std::ranges::max(readers_, {}, &Reader::last).last;
  events_.clear();
}

bool EventJudge::may_miss(const Reader& reader, Seq seq, const std::string& topic) {
  return std::ranges::any_of(reader.gaps, [&](const Gap& gap) {
    return gap.first <= seq && seq <= gap.last && (gap.topics.empty() || gap.topics.contains(topic));
  });
}

void EventJudge::judge() {
  const Seq common = std::ranges::min(readers_, {}, &Reader::last).last;
  for (auto event = events_.begin(); event != events_.end() && event->first <= common;
       event = events_.erase(event))
    judge_event(event->first, event->second);
  judged_ = std::max(judged_, common);
  for (Reader& reader : readers_)
    std::erase_if(reader.gaps, [this](const Gap& gap) { return gap.last <= judged_; });
}

void EventJudge::judge_event(Seq seq, const Seen& seen) {
  ++compared;
  for (std::size_t client = 0; client < readers_.size(); ++client) {
    const Reader& reader = readers_[client];
    if (!seen.by.contains(client) && !may_miss(reader, seq, seen.topic))
      log_.broken("event " + std::to_string(seq) + " of " + seen.topic + " never comes to " + reader.name);
  }
}

}  // namespace truepose::world
