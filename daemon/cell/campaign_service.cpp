#include "daemon/cell/campaign_service.hpp"

#include <boost/asio/co_spawn.hpp>
#include <utility>

#include "daemon/cell/new_uuid.hpp"
#include "daemon/log/log.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ParamReader;
using control::RpcError;

CampaignService::Run::Run(StoreJournal::Options options, const CellParts& parts, CampaignDevices devices,
                          CampaignObserver& observer, CampaignOrder order,
                          std::shared_ptr<const CampaignPast> past)
    : journal{options, parts.store, parts.store_thread, parts.wall_clock, parts.clock},
      campaign{
          options.config,
          devices,
          journal,
          observer,
          [&worker = parts.compute_thread](std::function<void()> job) { return worker.run(std::move(job)); },
          std::move(order),
          std::move(past)} {}

CampaignService::CampaignService(const CellParts& parts, CellRunner& runner, StoreWatch& store,
                                 DeviceService& devices, ModelService& models)
    : parts_{parts},
      runner_{runner},
      store_{store},
      devices_{devices},
      models_{models},
      requests_{parts.config, runner, models} {
  store_.when_usable([this]() -> asio::awaitable<void> {
    if (running() && runner_.in<Paused>() && run_->campaign.waits_for_room())
      runner_.reword(
          "paused, with the last point in memory, which the store can take again: resume the campaign");
    co_await keep_end();
  });
  runner_.on(CellCommand::PauseCampaign, [this](const std::string&) { run_->campaign.pause(); });
  runner_.on(CellCommand::ResumeCampaign, [this](const std::string&) { run_->campaign.resume(); });
  runner_.on(CellCommand::AbortCampaign, [this](const std::string& reason) { run_->campaign.abort(reason); });
}

std::vector<Method<CampaignService>> CampaignService::methods() {
  return {{"campaign.start", &CampaignService::start},
          {"drift.check", &CampaignService::drift_check},
          {"campaign.pause", &CampaignService::pause},
          {"campaign.resume", &CampaignService::resume},
          {"campaign.abort", &CampaignService::abort}};
}

// To start one.

MethodReply CampaignService::start(json::object params, std::string by) {
  auto refused = co_await store_.try_it();
  if (refused) co_return std::unexpected(*refused);
  auto asked = requests_.start(params);
  if (!asked) co_return std::unexpected(asked.error());
  co_return begin(*std::move(asked), by);
}

MethodReply CampaignService::drift_check(json::object params, std::string by) {
  auto refused = co_await store_.try_it();
  if (refused) co_return std::unexpected(*refused);
  auto asked = requests_.drift_check(params);
  if (!asked) co_return std::unexpected(asked.error());
  co_return begin(*std::move(asked), by);
}

MethodResult CampaignService::begin(CampaignRequest asked, const std::string& by) {
  StoreJournal::Options options{.campaign_id = new_uuid(),
                                .order = order_text(asked.order, asked.config, asked.activate),
                                .model_id = {},
                                .config = asked.config,
                                .kind = kind_name(asked.order),
                                .activate = asked.activate,
                                .started_by = by,
                                .note = std::move(asked.note)};
  const CampaignStartRequested start{options.campaign_id};
  const auto launched = launch(std::move(options), std::move(asked.order), start, by);
  if (!launched) return std::unexpected(launched.error());
  return json::object{{"id", run_->id()}, {"total", run_->campaign.progress().total}};
}

std::expected<void, RpcError> CampaignService::launch(StoreJournal::Options options, CampaignOrder order,
                                                      const CellEvent& event, const std::string& by,
                                                      std::shared_ptr<const CampaignPast> past) {
  const char* const reason = past ? "resumed by an operator" : "asked for by an operator";
  if (auto refused = runner_.apply(event, reason, by)) return std::unexpected(*refused);
  options.model_id = new_uuid();
  CampaignObserver& observer = *this;
  const CampaignDevices devices{devices_.robot(), devices_.tracker(), parts_.clock};
  run_ =
      std::make_shared<Run>(std::move(options), parts_, devices, observer, std::move(order), std::move(past));
  devices_.serve(run_->campaign.needs());
  asio::co_spawn(parts_.io, run(run_), [](std::exception_ptr failed) {
    if (failed) std::rethrow_exception(failed);
  });
  return {};
}

// While it is under way, and at its end.

asio::awaitable<void> CampaignService::run(std::shared_ptr<Run> run) {
  auto outcome = co_await run->campaign.run();
  std::optional<CampaignError> error;
  if (!outcome) error = outcome.error();
  // One that has outlasted its abort may not end what was started since.
  if (run == run_) co_await close(*run, std::move(error));
  run->ended = true;
  runner_.wake();
}

/// It has ended once its model is in effect.
asio::awaitable<void> CampaignService::close(Run& run, std::optional<CampaignError> error) {
  const std::string reason = error ? "the campaign ended: " + error->detail : "the campaign is done";
  error ? log_warning(reason) : log_info(reason);
  const bool lost =
      error && (error->fault == CampaignFault::Device || error->fault == CampaignFault::WrongArm);
  const CampaignRecord& record = run.journal.record();
  if (!error && !record.reason.empty()) log_warning(record.reason);
  if (record.state == "interrupted") co_await load_interrupted();
  const bool of_the_store = error && error->fault == CampaignFault::Store;
  if (of_the_store) store_.failed({error->detail});
  if (!of_the_store && !record.model_id.empty())
    co_await models_.announce_made(record.model_id, run.journal.activated(), record.started_by);
  run.ended = true;
  if (of_the_store && !run.journal.begun()) {
    runner_.apply(CampaignEnded{devices_.connected()}, reason);
  } else if (of_the_store) {
    runner_.apply(StoreFailed{{"store: " + error->detail}}, reason);
  } else {
    // One that is aborted may not have connected its devices yet, or cut a call to them short.
    const bool aborted = error && error->fault == CampaignFault::Aborted;
    bool connected = run.campaign.needs().tracker || devices_.connected();
    if (aborted) connected = stopping_ ? devices_.connected() : co_await devices_.connect_again();
    runner_.apply(CampaignEnded{lost || connected}, reason);
    if (lost) runner_.apply(DeviceLost{{error->detail, error->what_to_do}}, reason);
  }
  // Last: who waits for the end may command the cell at once.
  parts_.events.publish(control::Topic::Campaign, progress_json());
}

/// What the store could not take at the end of the last campaign.
asio::awaitable<void> CampaignService::keep_end() {
  if (!run_ || !run_->ended || run_->journal.ended()) co_return;
  const std::shared_ptr<Run> run = run_;
  auto kept = co_await run->journal.end_again();
  if (!kept) {
    store_.failed(kept.error());
    co_return;
  }
  if (run->journal.record().state == "interrupted") co_await load_interrupted();
  const std::string model = run->journal.record().model_id;
  const std::string by = run->journal.record().started_by;
  if (!model.empty()) co_await models_.announce_made(model, run->journal.activated(), by);
  parts_.events.publish(control::Topic::Campaign, progress_json());
}

MethodResult CampaignService::request(const json::object& params, const CellEvent& event,
                                      const std::string& reason, const std::string& by) {
  if (auto refused = runner_.request(params, event, reason, by)) return std::unexpected(*refused);
  return progress_json();
}

MethodReply CampaignService::pause(json::object params, std::string by) {
  co_return request(params, CampaignPauseRequested{}, "paused by an operator", by);
}

MethodResult CampaignService::pause_because(const std::string& why, const std::string& by) {
  return request({}, CampaignPauseRequested{}, "paused, since " + why + ": resume the campaign or abort it",
                 by);
}

MethodReply CampaignService::resume(json::object params, std::string by) {
  ParamReader read{params};
  const std::string id = read.id("id").value_or("");
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  if (!id.empty() && !(running() && id == run_->id())) {
    MethodResult resumed = co_await resume_interrupted(id, by);
    co_return resumed;
  }
  if (id.empty() && !runner_.in<Paused>()) co_return std::unexpected(nothing_paused());
  co_return request({}, CampaignResumeRequested{id}, "resumed by an operator", by);
}

MethodReply CampaignService::abort(json::object params, std::string by) {
  ParamReader read{params};
  const std::string id = read.id("id").value_or("");
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  if (!id.empty() && !(running() && id == run_->id())) {
    MethodResult aborted = co_await abort_interrupted(id);
    co_return aborted;
  }
  const MethodResult accepted = request({}, CampaignAbortRequested{}, "aborted by an operator", by);
  if (!accepted) co_return accepted;
  while (running()) co_await runner_.changed();
  co_return progress_json();
}

void CampaignService::interrupt(const std::string& reason) {
  stopping_ = true;
  if (run_) run_->campaign.interrupt(reason);
}

// Events for clients.

void CampaignService::on_progress(const CampaignProgress&) {
  parts_.events.publish(control::Topic::Campaign, progress_json());
}

/// @param why_not  it was not measured
void CampaignService::publish_measurement(const StoredPoint& point, json::value error_mm,
                                          const std::string& why_not) {
  json::object event = seen_json(point);
  event["campaign_id"] = run_->id();
  event["error_mm"] = std::move(error_mm);
  event["reason"] = why_not;
  parts_.events.publish(control::Topic::Measurement, std::move(event));
}

void CampaignService::on_point(const StoredPoint& point, double deviation_mm,
                               const CampaignProgress& progress) {
  publish_measurement(point, progress.error_mm ? json::value(deviation_mm) : json::value{}, "");
  on_progress(progress);
}

void CampaignService::on_skipped(const StoredPoint& wanted, const std::string& reason,
                                 const CampaignProgress& progress) {
  log_warning("pose " + std::to_string(wanted.pose) + " skipped: " + reason);
  publish_measurement(wanted, nullptr, reason);
  on_progress(progress);
}

void CampaignService::on_trouble(const std::string& sentence) {
  log_warning(sentence);
  json::object progress = progress_json();
  progress["trouble"] = sentence;
  parts_.events.publish(control::Topic::Campaign, progress);
}

void CampaignService::on_waiting(CellDevice device, const std::string& reason) {
  runner_.await(device, reason);
}

void CampaignService::on_paused(const std::string& sentence) { runner_.apply(CampaignPaused{}, sentence); }

json::object CampaignService::progress_json() const {
  const CampaignProgress progress = run_->campaign.progress();
  const CampaignRecord& record = run_->journal.record();
  const bool waits = running() && (runner_.waits() || runner_.in<Paused>());
  const bool tells_eta = progress.time_left_s && !waits && !run_->ended;
  std::string_view phase = phase_name(progress.phase);
  if (run_->ended)
    phase = record.state;
  else if (runner_.in<Paused>())
    phase = "paused";
  return {{"id", record.id},
          {"kind", record.kind},
          {"phase", phase},
          {"done", progress.done},
          {"total", progress.total},
          {"error_mm", progress.error_mm ? json::value(*progress.error_mm) : json::value{}},
          {"eta_s", tells_eta ? json::value(*progress.time_left_s) : json::value{}},
          {"skipped", progress.skipped},
          {"left", progress.left()},
          {"reason", record.reason},
          {"model_id", record.model_id.empty() ? json::value{} : json::value(record.model_id)}};
}

json::value CampaignService::json() const { return running() ? progress_json() : json::value{}; }

std::optional<CampaignProgress> CampaignService::progress() const {
  return running() ? std::optional{run_->campaign.progress()} : std::nullopt;
}

std::optional<CampaignArchive::Current> CampaignService::current() const {
  if (!run_) return std::nullopt;
  CampaignRecord record = run_->journal.record();
  if (running()) {
    record.state = "running";
    record.ended.clear();
  }
  return CampaignArchive::Current{running(), std::move(record), progress_json()};
}

}  // namespace truepose::daemon
