#include "daemon/control/commands.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/error.hpp>
#include <boost/system/system_error.hpp>
#include <map>
#include <set>
#include <utility>

#include "daemon/store/audit_witness.hpp"
#include "daemon/threads/worker.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/param_reader.hpp"
#include "proto/control/schema.hpp"
#include "proto/text/device_text.hpp"
#include "proto/text/digest.hpp"

namespace truepose::daemon {

namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ErrorCode;
using control::ParamReader;
using control::RpcError;

json::string text_value(std::string_view text) { return json::string(text.data(), text.size()); }

/// Takes the member command_id away, since no method knows it.
std::expected<std::optional<std::string>, RpcError> take_command_id(json::object& params) {
  json::object its_own;
  if (const json::value* const given = params.if_contains("command_id")) its_own["command_id"] = *given;
  ParamReader read{its_own};
  auto id = read.id("command_id");
  if (auto error = read.finish()) return std::unexpected(*error);
  params.erase("command_id");
  return id;
}

constexpr const char* kAcknowledgeAudit = "audit.acknowledge";

/// Of what such a command leaves in the store the audit trail has to know.
bool changes_store(std::string_view method) {
  return std::ranges::any_of(std::array{"campaign.", "drift.", "model.", "tool."},
                             [method](const char* start) { return method.starts_with(start); });
}

constexpr std::size_t kMostBytesOnRecord = 4096;

/// What a record tells of parameters: themselves, or of many their digest.
json::value audited_params(const json::object& params) {
  const std::string text = control::json_text(params);
  if (text.size() <= kMostBytesOnRecord) return params;
  return {{"bytes", text.size()}, {"sha256", text::sha256_hex(text)}};
}

/// By what a command is known again.
std::string command_text(std::string_view method, const json::value& params) {
  return std::string{method} + control::json_text(params);
}

/// The answer to a numbered command of before a restart that comes again; none where it was refused, so that
/// it may well be carried out now.
/// @param end  the record of what became of it; null: there is none
std::optional<Commands::Result> answer_again(const json::object* end) {
  const auto unknown = [](const char* what) {
    return std::unexpected(
        RpcError{ErrorCode::InvalidParams,
                 std::string{"params.command_id: the daemon was restarted since it came first: "} + what +
                     "; see cell.status, and give what is still to be done another command_id",
                 "params.command_id"});
  };
  if (end == nullptr) return unknown("whether it was carried out is not known");
  if (end->at("result") != "ok") return std::nullopt;
  const json::value* const answer = end->if_contains("answer");
  if (answer) return *answer;
  return unknown("it was carried out, and the answer is not kept");
}

std::string symbol_of(const Commands::Result& result) {
  return result ? "ok" : std::string{control::symbol(result.error().code)};
}

json::value value_of(const ControlLease::Holder& holder, drivers::TimePoint now) {
  const auto left = std::chrono::ceil<std::chrono::seconds>(holder.end() - now);
  return {{"holder", holder.who.name},
          {"role", text_value(control::name(holder.who.role))},
          {"left_s", left.count()}};
}

}  // namespace

Commands::Commands(ControlServerParts& parts, asio::any_io_executor executor, std::optional<AuditTrail> audit,
                   Presence presence)
    : parts_{parts},
      executor_{std::move(executor)},
      audit_{std::move(audit)},
      presence_{std::move(presence)} {
  remember();
  show_audit_fault(audit_ ? audit_->fault() : "");
}

// By their order and never by their times, which are those of a clock that may have been set: what was asked
// a minute ago may be dated anyhow. So an id is known for ten minutes more, however long ago it was given.
void Commands::remember() {
  constexpr std::size_t kPage = 100;
  // More than clients command in ten minutes, and read in a moment.
  constexpr std::uint64_t kMostRecords = 10'000;
  if (!audit_) return;
  const drivers::TimePoint now = parts_.clock.now();
  std::map<std::int64_t, json::object> ends;  // by the numbers of their commands, which stand before them
  std::set<std::pair<std::string, std::string>> seen;
  std::uint64_t before = audit_->count() + 1;
  const std::uint64_t last = before - std::min(before, kMostRecords);
  for (auto page = audit_->records(before, kPage); page && !page->empty();
       page = audit_->records(before, kPage)) {
    for (const json::value& each : *page) {
      const json::object& record = each.as_object();
      const std::int64_t n = record.at("n").as_int64();
      before = static_cast<std::uint64_t>(n);
      if (before <= last || seen.size() == CommandMemory::kMost) return;
      if (const json::value* const of = record.if_contains("of")) ends[of->as_int64()] = record;
      const json::value* const id = record.if_contains("command_id");
      if (!id) continue;
      const std::string who{record.at("who").as_string()}, name{id->as_string()};
      // What became of the last one of an id is what holds.
      if (!seen.emplace(who, name).second) continue;
      const auto end = ends.find(n);
      auto answer = answer_again(end == ends.end() ? nullptr : &end->second);
      if (!answer) continue;
      std::string text = command_text(record.at("method").as_string(), record.at("params"));
      CommandMemory::end(*memory_.begin(who, name, std::move(text), now, executor_), *std::move(answer));
    }
  }
}

asio::awaitable<std::expected<std::uint64_t, std::string>> Commands::write_down(json::object record,
                                                                                bool must_be) {
  if (!audit_) co_return 0;
  record["time"] = control::rfc3339(parts_.wall_clock());
  if (!must_be) {
    auto job = [this, record = std::move(record)]() mutable { return audit_->take(std::move(record)); };
    const AuditTrail::Taken taken = co_await parts_.worker.ask(std::move(job));
    has_pending_ = !taken.why_pending.empty();
    if (has_pending_) cannot_write(taken.why_pending);
    co_return taken.number;
  }
  auto job = [this, record = std::move(record)]() mutable { return audit_->append(std::move(record)); };
  auto written = co_await parts_.worker.ask(std::move(job));
  if (!written) cannot_write(written.error());
  if (written) complaint_.clear();
  co_return written;
}

void Commands::cannot_write(const std::string& why) {
  const std::string sentence = "the audit trail cannot be written: " + why;
  if (std::exchange(complaint_, why) != why) parts_.warn("control: " + sentence);
  parts_.cell.unrecorded(sentence);
}

void Commands::show_audit_fault(const std::string& fault) {
  parts_.cell.stand(
      !fault.empty(),
      {FaultCode::Audit,
       "the audit trail is not what was written: " + fault +
           "; find out who did that, then acknowledge it: truepose audit acknowledge --name NAME"});
}

asio::awaitable<void> Commands::bear_witness() {
  if (!audit_) co_return;
  auto job = [this] {
    if (parts_.witness) static_cast<void>(parts_.witness->keep_audit_head(audit_->end()));
    return audit_->end();
  };
  const control::AuditHead end = co_await parts_.worker.ask(job);
  parts_.note("audit trail: " + std::to_string(end.count) + " records, head " + end.hash);
}

void Commands::tell(const char* change, const std::string& by, json::object more) {
  more["change"] = change;
  more["by"] = by;
  parts_.events.publish(control::Topic::Control, more);
}

asio::awaitable<Commands::Result> Commands::carry_out(Caller caller, std::string from,
                                                      control::Request request) {
  const auto id = take_command_id(request.params);
  if (!id) co_return std::unexpected(id.error());
  if (!*id) {
    Outcome outcome = co_await once(std::move(caller), std::move(from), std::move(request));
    co_return std::move(outcome.result);
  }
  const drivers::TimePoint now = parts_.clock.now();
  std::string text = command_text(request.method, audited_params(request.params));
  if (const auto known = memory_.find(caller.name, **id, now)) {
    if (known->text != text)
      co_return std::unexpected(RpcError{
          ErrorCode::InvalidParams, "params.command_id: was given to another command", "params.command_id"});
    while (!known->result) co_await known->ended.wait();
    co_return *known->result;
  }
  const auto command = memory_.begin(caller.name, **id, std::move(text), now, executor_);
  const std::string name = caller.name;
  Outcome outcome = co_await once(std::move(caller), std::move(from), std::move(request), **id);
  CommandMemory::end(*command, outcome.result);
  if (!outcome.carried_out) memory_.forget(name, **id);
  co_return std::move(outcome.result);
}

asio::awaitable<Commands::Outcome> Commands::once(Caller caller, std::string from, control::Request request,
                                                  std::string id) {
  co_await look();
  const bool of_audit = request.method == kAcknowledgeAudit;
  const bool of_cell = !of_audit && !request.method.starts_with("control.");
  if (of_cell && !control::is_always_carried_out(request.method)) {
    auto refused = lease_.refusal(caller, parts_.clock.now());
    if (refused) co_return Outcome{std::unexpected(*std::move(refused))};
  }
  // A panel renews its control every few seconds for months, which commands nothing and changes no hands.
  const bool renews = !of_cell && !of_audit && request.method != "control.release" &&
                      lease_.is_held_by(caller, parts_.clock.now());
  if (renews) co_return Outcome{change_control(caller, request), true};
  json::object command{{"who", caller.name},
                       {"role", text_value(control::name(caller.role))},
                       {"from", from},
                       {"method", request.method},
                       {"params", audited_params(request.params)}};
  if (!id.empty()) command["command_id"] = id;
  if (of_audit) {
    Outcome acknowledged = co_await acknowledge_audit(std::move(command), request);
    co_return std::move(acknowledged);
  }
  Act act = [this, caller, request] { return this->act(caller, request); };
  Outcome outcome = co_await on_record(std::move(command), std::move(act));
  co_return std::move(outcome);
}

// Before anything is put on record the files are put in their places.
asio::awaitable<Commands::Outcome> Commands::acknowledge_audit(json::object command,
                                                               const control::Request& request) {
  const auto refused = [](ErrorCode code, std::string why, std::string param = {}) {
    return Outcome{std::unexpected(RpcError{code, std::move(why), std::move(param)})};
  };
  ParamReader read{request.params};
  const std::string name = read.required(read.text("name", 64), "name");
  if (auto error = read.finish()) co_return Outcome{std::unexpected(*error)};
  if (text::device_text(name) != name || name.empty())
    co_return refused(ErrorCode::InvalidParams, "params.name: expected your name", "params.name");
  if (!audit_) co_return refused(ErrorCode::NotFound, "this daemon keeps no audit trail");
  const std::string time = control::rfc3339(parts_.wall_clock());
  auto job = [this, time]() -> std::expected<std::string, std::string> {
    if (auto restored = audit_->restore(time); !restored) return std::unexpected(restored.error());
    return audit_->fault();
  };
  const auto restored = co_await parts_.worker.ask(job);
  if (!restored)
    co_return refused(ErrorCode::Store, "the audit trail cannot be written: " + restored.error());
  const std::string fault = *restored;
  if (fault.empty())
    co_return refused(ErrorCode::WrongState, "nothing is to be acknowledged of the audit trail");
  Act act = [fault]() -> asio::awaitable<Result> { co_return json::object{{"acknowledged", fault}}; };
  Outcome outcome = co_await on_record(std::move(command), std::move(act));
  auto acknowledge = [this] { audit_->acknowledge(); };
  co_await parts_.worker.run(acknowledge);
  show_audit_fault("");
  co_return std::move(outcome);
}

asio::awaitable<Commands::Outcome> Commands::on_record(json::object command, Act act) {
  const std::string method{command.at("method").as_string()}, by{command.at("who").as_string()};
  const bool may_come_again = command.contains("command_id");
  const bool must_be_on_record = !control::is_always_carried_out(method);
  const auto asked = co_await write_down(std::move(command), must_be_on_record);
  if (!asked)
    co_return Outcome{std::unexpected(RpcError{
        ErrorCode::Store, "not carried out, since the audit log cannot be written: " + asked.error() +
                              ", then cell.acknowledge"})};

  auto acting = act();
  Result result = co_await std::move(acting);
  json::object record{{"of", *asked}, {"result", symbol_of(result)}};
  if (!result) record["message"] = result.error().message;
  if (result && may_come_again && control::json_text(*result).size() <= kMostBytesOnRecord)
    record["answer"] = *result;
  const auto ended = co_await write_down(std::move(record), false);
  static_cast<void>(ended);  // it is done
  if (changes_store(method)) co_await bear_witness();
  if (!method.starts_with("control."))
    tell("command", by, {{"method", method}, {"result", symbol_of(result)}});
  co_return Outcome{std::move(result), true};
}

asio::awaitable<Commands::Result> Commands::act(Caller caller, control::Request request) {
  if (request.method.starts_with("control.")) co_return change_control(caller, request);
  if (request.method == "cell.acknowledge" && audit_) {
    auto job = [this] { return audit_->in_place(); };
    const auto there = co_await parts_.worker.ask(job);
    if (!there)
      co_return std::unexpected(
          RpcError{ErrorCode::Store, "the audit trail still cannot be written: " + there.error()});
  }
  Result result =
      co_await call_cell(std::move(request.method), std::move(request.params), std::move(caller.name));
  co_return result;
}

asio::awaitable<Commands::Result> Commands::call_cell(std::string method, json::object params,
                                                      std::string by) {
  auto call = parts_.cell.call(method, std::move(params), std::move(by));
  return result_of(std::move(method), std::move(call));
}

asio::awaitable<Commands::Result> Commands::result_of(std::string method, asio::awaitable<Result> call) {
  std::string failure;
  try {
    Result result = co_await std::move(call);
    co_return result;
  } catch (const boost::system::system_error& error) {
    if (error.code() == asio::error::operation_aborted) throw;
    failure = error.what();
  } catch (const std::exception& error) {
    failure = error.what();
  }
  parts_.warn(method + " failed unexpectedly: " + failure);
  co_return std::unexpected(RpcError{ErrorCode::Internal, method + " failed unexpectedly: " + failure});
}

Commands::Result Commands::change_control(const Caller& caller, const control::Request& request) {
  const drivers::TimePoint now = parts_.clock.now();
  ParamReader read{request.params};
  if (request.method == "control.release") {
    if (auto error = read.finish()) return std::unexpected(*error);
    const bool released = lease_.release(caller, now);
    if (released) tell("released", caller.name, {});
    return who_has_control({});
  }
  const auto given = read.integer("lease_s", ControlLease::kShortest.count(), ControlLease::kLongest.count());
  const auto time = given ? std::chrono::seconds{*given} : ControlLease::kUsual;
  if (auto error = read.finish()) return std::unexpected(*error);
  const bool by_force = request.method == "control.takeover";
  const auto before = lease_.holder(now);
  const auto taken = by_force ? lease_.take_over(caller, time, now) : lease_.acquire(caller, time, now);
  if (!taken) return std::unexpected(taken.error());
  see_connections();  // his may have ended while the command was put on record
  if (!before) tell("acquired", caller.name, {});
  if (before && before->who.name != caller.name)
    tell("taken-over", caller.name, {{"from", before->who.name}});
  return value_of(*taken, now);
}

Commands::Result Commands::who_has_control(const json::object& params) const {
  ParamReader read{params};
  if (auto error = read.finish()) return std::unexpected(*error);
  const drivers::TimePoint now = parts_.clock.now();
  const auto held = lease_.holder(now);
  return held ? value_of(*held, now) : json::value{{"holder", nullptr}};
}

asio::awaitable<Commands::Result> Commands::records(json::object params) {
  constexpr std::int64_t kMost = 200, kUsual = 50, kNoBound = std::int64_t{1} << 53;
  ParamReader read{params};
  const auto limit = static_cast<std::size_t>(read.integer("limit", 1, kMost).value_or(kUsual));
  const auto before = static_cast<std::uint64_t>(read.integer("before", 1, kNoBound).value_or(kNoBound));
  if (auto error = read.finish()) co_return std::unexpected(*error);
  if (!audit_) co_return json::object{{"records", json::array{}}};
  auto job = [this, before, limit] { return audit_->records(before, limit); };
  auto found = co_await parts_.worker.ask(job);
  if (!found) co_return std::unexpected(RpcError{ErrorCode::Internal, found.error()});
  co_return json::object{{"records", *std::move(found)}};
}

asio::awaitable<void> Commands::look() {
  if (audit_) {
    auto job = [this, owes = has_pending_] { return owes ? audit_->pay() : audit_->in_place(); };
    const auto there = co_await parts_.worker.ask(job);
    if (!there && !has_pending_) cannot_write(there.error());
    has_pending_ = has_pending_ && !there;
  }
  const std::string daemon = control::kDaemonName;
  const auto lost = lease_.lost(parts_.clock.now(), presence_.is_known);
  if (!lost) co_return;
  parts_.warn("control: " + lost->why);
  tell("lost", lost->name, {});
  json::object command{{"who", daemon},
                       {"role", text_value(control::name(control::Role::Admin))},
                       {"from", "control of " + lost->name + " was lost"},
                       {"method", "campaign.pause"},
                       {"params", json::object{}}};
  Act pause = [this, daemon, why = lost->why] {
    return result_of("campaign.pause", parts_.cell.pause(why, daemon));
  };
  const Outcome paused = co_await on_record(std::move(command), std::move(pause));
  static_cast<void>(paused);  // there may be no campaign
}

}  // namespace truepose::daemon
