#include "tests/world/judge/control_judge.hpp"

#include <algorithm>
#include <boost/json/serialize.hpp>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace json = boost::json;
using drivers::TimePoint;

namespace {

constexpr std::chrono::seconds kUnconnected{10};  // for which control outlives its holder's connection
constexpr std::chrono::seconds kMargin{2};        // of the daemon's clock and ours
constexpr std::chrono::seconds kUsual{30};

bool takes_control(const Request& request) {
  return request.method == "control.acquire" || request.method == "control.takeover";
}

std::chrono::seconds lease_of(const Request& request) {
  const json::value* const seconds = request.params.if_contains("lease_s");
  return seconds == nullptr ? kUsual : std::chrono::seconds{seconds->as_int64()};
}

}  // namespace

bool ControlJudge::Control::is_certain(const Request& during) const {
  const TimePoint end = unconnected_since ? std::min(until, *unconnected_since + kUnconnected) : until;
  return from <= during.asked && during.answered < end;
}

bool ControlJudge::Control::is_possible(const Request& during) const {
  const TimePoint end =
      unconnected_since ? std::min(latest, *unconnected_since + kUnconnected + kMargin) : latest;
  return asked_for > 0 || during.asked <= end;
}

void ControlJudge::asks(const Client& client, const Request& request) {
  Control& own = controls_[client.user()];
  if (takes_control(request)) {
    ++own.asked_for;
    own.until = std::min(own.until, request.asked + lease_of(request));
  }
  if (request.method == "control.release") own.until = std::min(own.until, request.asked);
  if (request.method != "control.takeover") return;
  for (auto& [user, control] : controls_)
    if (user != client.user()) control.until = std::min(control.until, request.asked);
}

void ControlJudge::answered(const Client& client, const Request& request) {
  judge_order(client, request);
  judge_holder(request);
  take_change(client, request);
}

void ControlJudge::take_change(const Client& client, const Request& request) {
  Control& own = controls_[client.user()];
  const std::string outcome = outcome_of(request.answer);
  if (request.method == "control.release" && outcome == "ok") own.latest = request.answered;
  if (!takes_control(request)) return;
  --own.asked_for;
  if (outcome.empty() || outcome == "ok")
    own.latest = std::max(own.latest, request.answered + lease_of(request) + kMargin);
  if (outcome != "ok") return;
  if (!own.is_certain({.asked = request.asked, .answered = request.asked})) own.from = request.answered;
  own.until = request.asked + lease_of(request);
  for (auto& [user, control] : controls_)
    if (user != client.user()) control.latest = std::min(control.latest, request.answered);
}

void ControlJudge::judge_order(const Client& client, const Request& request) {
  const std::string outcome = outcome_of(request.answer);
  if (outcome.empty() || !methods_.commands(request.method)) return;
  const std::string order = client.user() + "'s " + request.method;
  if (!methods_.allows(client.role(), request.method) || outcome == "E_FORBIDDEN") {
    if (methods_.allows(client.role(), request.method) || outcome != "E_FORBIDDEN")
      log_.broken(order + " as " + client.role() + " is answered by " + outcome);
    return;
  }
  const std::string holder = certain_holder(request, client.user());
  const bool is_refused = outcome == "E_CONTROL";
  if (is_refused && !can_be_held(request, client.user()))
    log_.broken(order + " is refused for control that no client has");
  const bool needs_control =
      request.method == "control.acquire" || !methods_.is_always_carried_out(request.method);
  const bool is_job = request.params.contains("job") && outcome == "ok";  // it may be refused later
  if (needs_control && !is_refused && !is_job && !holder.empty())
    log_.broken(order + " is answered by " + outcome + " while " + holder + " has control");
}

void ControlJudge::judge_holder(const Request& request) {
  if (request.method != "control.get" || !is_result(request.answer)) return;
  const std::string seen = text_at(result_of(request.answer), "holder"), certain = certain_holder(request);
  if (!certain.empty() && seen != certain) log_.broken("'" + seen + "' has control in place of " + certain);
  if (!seen.empty() && !can_be_held(request)) log_.broken(seen + " has control, which has to be over");
}

void ControlJudge::sees(const Client& client, bool is_open) {
  Control& own = controls_[client.user()];
  const TimePoint now = log_.now();
  if (!is_open) {
    own.unconnected_since = now;
  } else if (own.unconnected_since) {
    const TimePoint end = *own.unconnected_since + kUnconnected;
    if (now >= end) own.until = std::min(own.until, end);
    if (now >= end + kMargin) own.latest = std::min(own.latest, end + kMargin);
    own.unconnected_since.reset();
  }
}

void ControlJudge::restarted() {
  for (auto& [user, control] : controls_) control.until = control.latest = TimePoint::min();
}

std::string ControlJudge::certain_holder(const Request& during, const std::string& but) const {
  const auto holds = [&](const auto& each) { return each.first != but && each.second.is_certain(during); };
  const auto found = std::ranges::find_if(controls_, holds);
  return found == controls_.end() ? std::string{} : found->first;
}

bool ControlJudge::can_be_held(const Request& during, const std::string& but) const {
  return std::ranges::any_of(
      controls_, [&](const auto& each) { return each.first != but && each.second.is_possible(during); });
}

}  // namespace truepose::world
