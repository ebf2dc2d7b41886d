#include "tests/world/judge/audit_judge.hpp"

#include <algorithm>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <fstream>
#include <set>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace fs = std::filesystem;
namespace json = boost::json;

namespace {

/// The files of a trail, in the order in which they were written.
std::vector<fs::path> trail_of(const fs::path& store) {
  const std::string name = store.filename().string() + ".audit";
  std::map<std::uint64_t, fs::path> full;
  for (const auto& entry : fs::directory_iterator{fs::absolute(store).parent_path()}) {
    const std::string file = entry.path().filename().string();
    // "cell.sqlite.audit.1-40000". One that was put aside has the time in its name.
    const bool is_full = file.starts_with(name + ".") && file.find('-') != std::string::npos &&
                         file.find_first_not_of("0123456789-", name.size() + 1) == std::string::npos;
    if (is_full) full[std::stoull(file.substr(name.size() + 1))] = entry.path();
  }
  std::vector<fs::path> files;
  for (const auto& [first, file] : full) files.push_back(file);
  files.push_back(fs::absolute(store).parent_path() / name);
  return files;
}

/// Of an order that the daemon may refuse, or carry out, without a record.
bool may_be_unrecorded(const std::string& method, const std::string& outcome) {
  if (method == "audit.acknowledge" && outcome != "ok") return true;
  const bool renews = method == "control.acquire" || method == "control.takeover";
  return outcome.empty() || outcome == "E_CONTROL" || outcome == "E_FORBIDDEN" || outcome == "E_STORE" ||
         (renews && outcome == "ok");
}

}  // namespace

void AuditJudge::answered(const Client& client, const Request& request, bool disk_fails) {
  if (!methods_.commands(request.method)) return;
  Order& order = orders_[text_at(request.params, "command_id")];
  order.text = client.user() + ' ' + request.method;
  order.may_be_unrecorded |= disk_fails && methods_.is_always_carried_out(request.method);
  // What becomes of a job comes later.
  order.outcomes.push_back(request.params.contains("job") ? std::string{} : outcome_of(request.answer));
}

void AuditJudge::judge(const fs::path& store) {
  records_.clear();
  last_ = 0;
  for (const fs::path& file : trail_of(store)) {
    std::ifstream lines{file};
    for (std::string line; std::getline(lines, line);) take(json::parse(line).as_object());
  }
  std::map<std::string, std::vector<const Record*>> of_id;
  for (const auto& [n, record] : records_) {
    const std::string id = text_at(record.command, "command_id");
    if (!orders_.contains(id) && text_at(record.command, "who") != "trueposed")
      log_.broken("the audit trail has an order that was not given: " + json::serialize(record.command));
    of_id[id].push_back(&record);
  }
  for (const auto& [id, order] : orders_) judge_order(order, of_id[id]);
}

void AuditJudge::take(const json::object& record) {
  const auto n = record.at("n").to_number<std::uint64_t>();
  if (n != ++last_) log_.broken("the audit trail continues with record " + std::to_string(n));
  last_ = n;
  if (record.contains("method")) records_[n].command = record;
  if (const json::value* const of = record.if_contains("of"))
    records_[of->to_number<std::uint64_t>()].results.push_back(text_at(record, "result"));
}

void AuditJudge::judge_order(const Order& order, const std::vector<const Record*>& records) {
  const std::string method = order.text.substr(order.text.rfind(' ') + 1);
  const auto wrong = [&](const std::string& what) {
    log_.broken("the audit trail: " + order.text + ' ' + what);
  };
  std::size_t carried_out = 0;
  std::set<std::string> results;
  for (const Record* const record : records) {
    if (text_at(record->command, "who") + ' ' + text_at(record->command, "method") != order.text)
      wrong("is " + json::serialize(record->command));
    if (record->results.size() > 1) wrong("has two results");
    results.insert(record->results.begin(), record->results.end());
    carried_out += std::ranges::count(record->results, "ok") > 0 ? 1U : 0U;
  }
  if (records.size() > order.outcomes.size()) wrong("is there twice");
  if (carried_out > 1) wrong("is carried out twice");
  // What is asked again is answered from memory.
  const std::string& first = order.outcomes.front();
  if (!order.may_be_unrecorded && !may_be_unrecorded(method, first) && !results.contains(first))
    wrong("was answered by " + first + ", which is not there");
}

}  // namespace truepose::world
