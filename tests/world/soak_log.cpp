#include "tests/world/soak_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace truepose::world {

namespace {

constexpr std::size_t kEvents = 30;
constexpr std::chrono::minutes kEffects{10};  // of a fault that is over

}  // namespace

std::string time_text(std::chrono::milliseconds since_begin) {
  const auto ms = since_begin.count();
  return fmt::format("{} {:02}:{:02}:{:02}.{:03}", ms / 86'400'000, ms / 3'600'000 % 24, ms / 60'000 % 60,
                     ms / 1000 % 60, ms % 1000);
}

std::chrono::milliseconds SoakLog::since_begin() const {
  return std::chrono::floor<std::chrono::milliseconds>(now() - begin_);
}

void SoakLog::trace(const std::string& topic, const std::string& text) {
  const std::string time = time_text(since_begin());
  trace_(time, topic, text);
  events_.push_back(fmt::format("{} {}: {:.300}", time, topic, text));
  if (events_.size() > kEvents) events_.pop_front();
}

void SoakLog::broken(const std::string& promise) {
  broken_.push_back({since_begin(), promise, {events_.begin(), events_.end()}});
  trace("broken", promise);
}

void SoakLog::take_broken(std::vector<std::string>& promises) {
  for (const std::string& promise : std::exchange(promises, {})) broken(promise);
}

void SoakLog::begin_fault(std::string_view name) {
  ++faults_[std::string{name}].under_way;
  trace("fault", std::string{name} + " begins");
}

void SoakLog::end_fault(std::string_view name) {
  Fault& fault = faults_[std::string{name}];
  --fault.under_way;
  fault.last_end = now();
  trace("fault", std::string{name} + " is over");
}

bool SoakLog::is_disturbed() const {
  return std::ranges::any_of(faults_, [this](const auto& each) {
    return each.second.under_way > 0 || now() - each.second.last_end < kEffects;
  });
}

bool SoakLog::had_fault(std::initializer_list<std::string_view> names, drivers::Duration within) const {
  return std::ranges::any_of(names, [&](std::string_view name) {
    const auto found = faults_.find(name);
    return found != faults_.end() && (found->second.under_way > 0 || now() - found->second.last_end < within);
  });
}

}  // namespace truepose::world
