#include "daemon/control/jobs.hpp"

#include <algorithm>
#include <utility>

#include "drivers/deadline.hpp"
#include "drivers/net/spawn.hpp"
#include "proto/control/json_text.hpp"
#include "proto/text/random_bytes.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::ErrorCode;
using control::RpcError;

namespace {

rpc::JobError error_record(const RpcError& error) {
  return {.code = static_cast<int>(error.code), .message = error.message, .data = control::error_data(error)};
}

}  // namespace

rpc::Job Jobs::Job::record() const {
  rpc::Job job{
      .id = id, .method = method, .state = "running", .doing = doing, .started = control::rfc3339(started)};
  if (!result) return job;
  job.state = *result ? "done" : "failed";
  job.ended = control::rfc3339(ended);
  if (!*result) job.error = error_record(result->error());
  return job;
}

std::expected<std::string, RpcError> Jobs::begin(std::string method, std::string by, Call call, Tell tell) {
  forget_old();
  const auto running = std::ranges::count_if(jobs_, [](const auto& kept) { return !kept.second->result; });
  if (static_cast<std::size_t>(running) >= kMostRunning)
    return std::unexpected(
        RpcError{ErrorCode::Busy, std::to_string(running) + " jobs are under way already; wait for one"});
  std::string id = random_hex(8, parts_.random);
  // In place: it cannot be moved.
  const Kept job{new Job{id, std::move(method), std::move(by), parts_.wall_clock(), std::move(tell)}};
  jobs_[id] = job;
  const auto ended = [job](std::exception_ptr) {};
  net::spawn(executor_, carry_out(job, std::move(call)), ended, job->cancel.slot());
  return id;
}

std::optional<rpc::Job> Jobs::find(const std::string& id, const std::string& by) {
  forget_old();
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || found->second->by != by) return std::nullopt;
  const Job& job = *found->second;
  rpc::Job known = job.record();
  if (job.result && *job.result) known.result = **job.result;
  return known;
}

void Jobs::stop() {
  const std::map<std::string, Kept> all = jobs_;
  for (const auto& [id, job] : all) job->cancel.emit(asio::cancellation_type::terminal);
}

asio::awaitable<void> Jobs::carry_out(Kept job, Call call) {
  co_await drivers::unless(follow(job), finish(job, call));
}

asio::awaitable<void> Jobs::finish(Kept job, Call call) {
  Result result = co_await call();
  job->result = std::move(result);
  job->doing.clear();
  job->ended = parts_.wall_clock();
  job->forgotten_from = parts_.clock.now() + kKept;
  job->tell(job->record());
}

asio::awaitable<void> Jobs::follow(Kept job) {
  while (!job->result) {
    std::string doing = parts_.cell.doing();
    if (doing != job->doing) {
      job->doing = std::move(doing);
      job->tell(job->record());
    }
    const drivers::TimePoint next = parts_.clock.now() + kLook;
    co_await parts_.clock.sleep_until(next);
  }
}

void Jobs::forget_old() {
  std::erase_if(jobs_, [now = parts_.clock.now()](const auto& kept) {
    return kept.second->result && now >= kept.second->forgotten_from;
  });
  const auto ended_first = [](const auto& one, const auto& other) {
    return std::pair{!one.second->result, one.second->ended} <
           std::pair{!other.second->result, other.second->ended};
  };
  while (jobs_.size() >= kMost) jobs_.erase(std::ranges::min_element(jobs_, ended_first));
}

}  // namespace truepose::daemon
