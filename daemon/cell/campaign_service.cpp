#include "daemon/cell/campaign_service.hpp"

#include <utility>

#include "daemon/log/log.hpp"
#include "drivers/net/spawn.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
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

std::vector<Served<CampaignService>> CampaignService::methods() {
  return {&CampaignService::start, &CampaignService::drift_check, &CampaignService::pause,
          &CampaignService::resume, &CampaignService::abort};
}

// To start one.

Reply<rpc::CampaignStart> CampaignService::start(rpc::CampaignStart asked, std::string by) {
  auto refused = co_await store_.try_it();
  if (refused) co_return std::unexpected(*refused);
  auto campaign = requests_.start(asked);
  if (!campaign) co_return std::unexpected(campaign.error());
  co_return begin(*std::move(campaign), by);
}

Reply<rpc::DriftCheck> CampaignService::drift_check(rpc::DriftCheck asked, std::string by) {
  auto refused = co_await store_.try_it();
  if (refused) co_return std::unexpected(*refused);
  auto campaign = requests_.drift_check(asked);
  if (!campaign) co_return std::unexpected(campaign.error());
  co_return begin(*std::move(campaign), by);
}

Answer<rpc::CampaignStart> CampaignService::begin(CampaignRequest asked, const std::string& by) {
  StoreJournal::Options options{.campaign_id = random_uuid(parts_.random),
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
  return rpc::CampaignStart::Result{.id = run_->id(), .total = run_->campaign.progress().total};
}

std::expected<void, RpcError> CampaignService::launch(StoreJournal::Options options, CampaignOrder order,
                                                      const CellEvent& event, const std::string& by,
                                                      std::shared_ptr<const CampaignPast> past) {
  const char* const reason = past ? "resumed by an operator" : "asked for by an operator";
  if (auto refused = runner_.apply(event, reason, by)) return std::unexpected(*refused);
  options.model_id = random_uuid(parts_.random);
  CampaignObserver& observer = *this;
  const CampaignDevices devices{devices_.robot(), devices_.tracker(), parts_.clock};
  run_ =
      std::make_shared<Run>(std::move(options), parts_, devices, observer, std::move(order), std::move(past));
  devices_.serve(run_->campaign.needs());
  net::spawn(parts_.io, run(run_), net::rethrow);
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
  publish(last_progress());
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
  publish(last_progress());
}

CampaignService::Progress CampaignService::request(const CellEvent& event, const std::string& reason,
                                                   const std::string& by) {
  if (auto refused = runner_.apply(event, reason, by)) return std::unexpected(*refused);
  return last_progress();
}

Reply<rpc::CampaignPause> CampaignService::pause(rpc::CampaignPause, std::string by) {
  co_return request(CampaignPauseRequested{}, "paused by an operator", by);
}

Answer<rpc::CampaignPause> CampaignService::pause_because(const std::string& why, const std::string& by) {
  return request(CampaignPauseRequested{}, "paused, since " + why + ": resume the campaign or abort it", by);
}

Reply<rpc::CampaignResume> CampaignService::resume(rpc::CampaignResume asked, std::string by) {
  const std::string id = asked.id.value_or("");
  if (!id.empty() && !(running() && id == run_->id())) {
    auto resumed = co_await resume_interrupted(id, by);
    co_return resumed;
  }
  if (id.empty() && !runner_.in<Paused>()) co_return std::unexpected(nothing_paused());
  co_return request(CampaignResumeRequested{id}, "resumed by an operator", by);
}

Reply<rpc::CampaignAbort> CampaignService::abort(rpc::CampaignAbort asked, std::string by) {
  const std::string id = asked.id.value_or("");
  if (!id.empty() && !(running() && id == run_->id())) {
    auto aborted = co_await abort_interrupted(id);
    co_return aborted;
  }
  const Progress accepted = request(CampaignAbortRequested{}, "aborted by an operator", by);
  if (!accepted) co_return accepted;
  while (running()) co_await runner_.changed();
  co_return last_progress();
}

void CampaignService::interrupt(const std::string& reason) {
  stopping_ = true;
  if (run_) run_->campaign.interrupt(reason);
}

// Events for clients.

void CampaignService::publish(const rpc::CampaignProgress& progress) { parts_.events.publish(progress); }

void CampaignService::publish(const StoredPoint& point, std::optional<double> error_mm,
                              const std::string& why_not) {
  rpc::PointMeasured measured{seen_point(point)};
  measured.campaign_id = run_->id();
  measured.error_mm = error_mm;
  measured.reason = why_not;
  parts_.events.publish(measured);
}

void CampaignService::on_progress(const CampaignProgress&) { publish(last_progress()); }

void CampaignService::on_point(const StoredPoint& point, double deviation_mm,
                               const CampaignProgress& progress) {
  publish(point, progress.error_mm ? std::optional{deviation_mm} : std::nullopt, "");
  on_progress(progress);
}

void CampaignService::on_skipped(const StoredPoint& wanted, const std::string& reason,
                                 const CampaignProgress& progress) {
  log_warning("pose " + std::to_string(wanted.pose) + " skipped: " + reason);
  publish(wanted, std::nullopt, reason);
  on_progress(progress);
}

void CampaignService::on_trouble(const std::string& sentence) {
  log_warning(sentence);
  rpc::CampaignProgress progress = last_progress();
  progress.trouble = sentence;
  publish(progress);
}

void CampaignService::on_waiting(CellDevice device, const std::string& reason) {
  runner_.await(device, reason);
}

void CampaignService::on_paused(const std::string& sentence) { runner_.apply(CampaignPaused{}, sentence); }

rpc::CampaignProgress CampaignService::last_progress() const {
  const CampaignProgress progress = run_->campaign.progress();
  const CampaignRecord& record = run_->journal.record();
  const bool waits = running() && (runner_.waits() || runner_.in<Paused>());
  std::string phase{phase_name(progress.phase)};
  if (run_->ended)
    phase = record.state;
  else if (runner_.in<Paused>())
    phase = "paused";
  rpc::CampaignProgress seen{.id = record.id,
                             .kind = record.kind,
                             .phase = phase,
                             .done = progress.done,
                             .total = progress.total,
                             .error_mm = progress.error_mm,
                             .skipped = progress.skipped,
                             .left = progress.left(),
                             .reason = record.reason};
  if (!waits && !run_->ended) seen.eta_s = progress.time_left_s;
  if (!record.model_id.empty()) seen.model_id = record.model_id;
  return seen;
}

std::optional<rpc::CampaignProgress> CampaignService::status() const {
  return running() ? std::optional{last_progress()} : std::nullopt;
}

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
  return CampaignArchive::Current{running(), std::move(record), last_progress()};
}

}  // namespace truepose::daemon
