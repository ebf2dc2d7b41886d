#include "daemon/control/commands.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/error.hpp>
#include <boost/system/system_error.hpp>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "daemon/store/audit_witness.hpp"
#include "daemon/threads/worker.hpp"
#include "proto/control/json_text.hpp"
#include "proto/rpc/events.hpp"
#include "proto/rpc/methods.hpp"
#include "proto/text/digest.hpp"

namespace truepose::daemon {

namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;

json::string text_value(std::string_view text) { return json::string(text.data(), text.size()); }

bool is_of_control(std::string_view method) { return method.starts_with("control."); }

bool is_always_carried_out(std::string_view method) {
  const rpc::Method* const known = rpc::method_named(method);
  return known && known->is_always_carried_out;
}

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

/// Records of the trail, newest first.
std::expected<std::vector<rpc::AuditRecord>, std::string> records_of(AuditTrail& audit, std::uint64_t before,
                                                                     std::size_t limit) {
  auto found = audit.records(before, limit);
  if (!found) return std::unexpected(found.error());
  return record::from_json<std::vector<rpc::AuditRecord>>(*std::move(found), "records");
}

/// The answer to a numbered command of before a restart that comes again; none where it was refused, so that
/// it may well be carried out now.
/// @param end  the record of what became of it; null: there is none
std::optional<Commands::Result> answer_again(const rpc::AuditRecord* end) {
  const auto unknown = [](const std::string& what) {
    return rpc::refused("command_id", "the daemon was restarted since it came first: " + what +
                                          "; see cell.status, and give what is still to be done another "
                                          "command_id");
  };
  if (end == nullptr) return unknown("whether it was carried out is not known");
  if (end->result != "ok") return std::nullopt;
  if (end->answer) return *end->answer;
  return unknown("it was carried out, and the answer is not kept");
}

std::string symbol_of(const Commands::Result& result) {
  return result ? "ok" : std::string{control::symbol(result.error().code)};
}

rpc::Control control_record(const ControlLease::Holder& holder, drivers::TimePoint now) {
  return {.holder = holder.who.name,
          .role = holder.who.role,
          .left_s = std::chrono::ceil<std::chrono::seconds>(holder.end() - now)};
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
  // By the numbers of their commands, which stand before them.
  std::map<std::uint64_t, rpc::AuditRecord> ends;
  std::set<std::pair<std::string, std::string>> seen;
  std::uint64_t before = audit_->count() + 1;
  const std::uint64_t last = before - std::min(before, kMostRecords);
  for (auto page = records_of(*audit_, before, kPage); page && !page->empty();
       page = records_of(*audit_, before, kPage)) {
    for (const rpc::AuditRecord& each : *page) {
      before = each.n;
      if (before <= last || seen.size() == CommandMemory::kMost) return;
      if (each.of) ends[*each.of] = each;
      if (!each.command_id) continue;
      const std::string who = each.who.value(), id = *each.command_id;
      // What became of the last one of an id is what holds.
      if (!seen.emplace(who, id).second) continue;
      const auto end = ends.find(each.n);
      auto answer = answer_again(end == ends.end() ? nullptr : &end->second);
      if (!answer) continue;
      std::string text = command_text(each.method.value(), each.params.value());
      CommandMemory::end(*memory_.begin(who, id, std::move(text), now, executor_), *std::move(answer));
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

asio::awaitable<Commands::Result> Commands::carry_out(Caller caller, std::string from,
                                                      control::Request request) {
  const auto taken = rpc::take_params<rpc::CommandId>(request.params);
  if (!taken) co_return std::unexpected(taken.error());
  if (!taken->command_id) {
    Outcome outcome = co_await once(std::move(caller), std::move(from), std::move(request));
    co_return std::move(outcome.result);
  }
  const drivers::TimePoint now = parts_.clock.now();
  const std::string id = *taken->command_id;
  std::string text = command_text(request.method, audited_params(request.params));
  if (const auto known = memory_.find(caller.name, id, now)) {
    if (known->text != text) co_return rpc::refused("command_id", "was given to another command");
    while (!known->result) co_await known->ended.wait();
    co_return *known->result;
  }
  const auto command = memory_.begin(caller.name, id, std::move(text), now, executor_);
  const std::string name = caller.name;
  Outcome outcome = co_await once(std::move(caller), std::move(from), std::move(request), id);
  CommandMemory::end(*command, outcome.result);
  if (!outcome.carried_out) memory_.forget(name, id);
  co_return std::move(outcome.result);
}

asio::awaitable<Commands::Outcome> Commands::once(Caller caller, std::string from, control::Request request,
                                                  std::string id) {
  co_await look();
  const bool of_audit = rpc::is_of<rpc::AuditAcknowledge>(request.method);
  const bool of_cell = !of_audit && !is_of_control(request.method);
  if (of_cell && !is_always_carried_out(request.method)) {
    auto refused = lease_.refusal(caller, parts_.clock.now());
    if (refused) co_return Outcome{std::unexpected(*std::move(refused))};
  }
  // A panel renews its control every few seconds for months, which commands nothing and changes no hands.
  const bool renews = !of_cell && !of_audit && !rpc::is_of<rpc::ControlRelease>(request.method) &&
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
  const auto refused = [](ErrorCode code, std::string why) {
    return Outcome{std::unexpected(RpcError{code, std::move(why)})};
  };
  const auto acknowledged = rpc::read_params<rpc::AuditAcknowledge>(request.params);
  if (!acknowledged) co_return Outcome{std::unexpected(acknowledged.error())};
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
  Act act = [fault]() -> asio::awaitable<Result> {
    co_return record::to_json(rpc::AuditAcknowledge::Result{.acknowledged = fault});
  };
  Outcome outcome = co_await on_record(std::move(command), std::move(act));
  auto acknowledge = [this] { audit_->acknowledge(); };
  co_await parts_.worker.run(acknowledge);
  show_audit_fault("");
  co_return std::move(outcome);
}

asio::awaitable<Commands::Outcome> Commands::on_record(json::object command, Act act) {
  const std::string method{command.at("method").as_string()}, by{command.at("who").as_string()};
  const bool may_come_again = command.contains("command_id");
  const bool must_be_on_record = !is_always_carried_out(method);
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
  if (!is_of_control(method))
    parts_.events.publish(
        rpc::ControlChanged{.change = "command", .by = by, .method = method, .result = symbol_of(result)});
  co_return Outcome{std::move(result), true};
}

asio::awaitable<Commands::Result> Commands::act(Caller caller, control::Request request) {
  if (is_of_control(request.method)) co_return change_control(caller, request);
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

std::vector<std::string_view> Commands::own_methods() {
  return {rpc::ControlAcquire::method().name, rpc::ControlTakeover::method().name,
          rpc::ControlRelease::method().name, rpc::AuditAcknowledge::method().name};
}

Commands::Result Commands::change_control(const Caller& caller, const control::Request& request) {
  const bool releases = rpc::is_of<rpc::ControlRelease>(request.method);
  const auto control = releases ? release(caller, request.params) : take(caller, request);
  if (!control) return std::unexpected(control.error());
  return record::to_json(*control);
}

Answer<rpc::ControlRelease> Commands::release(const Caller& caller, const json::object& params) {
  const auto read = rpc::read_params<rpc::ControlRelease>(params);
  if (!read) return std::unexpected(read.error());
  if (lease_.release(caller, parts_.clock.now()))
    parts_.events.publish(rpc::ControlChanged{.change = "released", .by = caller.name});
  return who_has_control();
}

Answer<rpc::ControlAcquire> Commands::take(const Caller& caller, const control::Request& request) {
  const auto asked = rpc::read_params<rpc::ControlAcquire>(request.params);
  if (!asked) return std::unexpected(asked.error());
  const drivers::TimePoint now = parts_.clock.now();
  const auto time = asked->lease_s.value_or(ControlLease::kUsual);
  const bool by_force = rpc::is_of<rpc::ControlTakeover>(request.method);
  const auto before = lease_.holder(now);
  const auto taken = by_force ? lease_.take_over(caller, time, now) : lease_.acquire(caller, time, now);
  if (!taken) return std::unexpected(taken.error());
  see_connections();  // his may have ended while the command was put on record
  if (!before) parts_.events.publish(rpc::ControlChanged{.change = "acquired", .by = caller.name});
  if (before && before->who.name != caller.name)
    parts_.events.publish(
        rpc::ControlChanged{.change = "taken-over", .by = caller.name, .from = before->who.name});
  return control_record(*taken, now);
}

rpc::Control Commands::who_has_control() const {
  const drivers::TimePoint now = parts_.clock.now();
  const auto held = lease_.holder(now);
  return held ? control_record(*held, now) : rpc::Control{};
}

Reply<rpc::AuditList> Commands::records(rpc::AuditList request) {
  constexpr std::size_t kUsual = 50;
  constexpr auto kNoBound = std::numeric_limits<std::uint64_t>::max();
  if (!audit_) co_return rpc::AuditList::Result{};
  auto job = [this, before = request.before.value_or(kNoBound), limit = request.limit.value_or(kUsual)] {
    return records_of(*audit_, before, limit);
  };
  auto found = co_await parts_.worker.ask(job);
  if (!found) co_return std::unexpected(RpcError{ErrorCode::Internal, found.error()});
  co_return rpc::AuditList::Result{*std::move(found)};
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
  parts_.events.publish(rpc::ControlChanged{.change = "lost", .by = lost->name});
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
