// Campaigns that were under way when the daemon ended.

#include <algorithm>
#include <utility>

#include "config/frame_file.hpp"
#include "config/text_file.hpp"
#include "daemon/campaign/tool_cell.hpp"
#include "daemon/cell/campaign_service.hpp"
#include "daemon/cell/frame_order.hpp"
#include "daemon/log/log.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::ErrorCode;
using control::RpcError;

namespace {

std::string described(const InterruptedCampaign& one) {
  return one.record.kind + " " + one.record.id + ", " + std::to_string(one.done) + " of " +
         std::to_string(one.total) + " poses measured: " + one.record.reason;
}

const std::string& id_of(const InterruptedCampaign& one) { return one.record.id; }

int total_of(const InterruptedCampaign& one) { return std::max(one.total, one.done + one.skipped); }

rpc::CampaignProgress progress_of(const InterruptedCampaign& one) {
  return {.id = one.record.id,
          .kind = one.record.kind,
          .phase = one.record.state,
          .done = one.done,
          .total = total_of(one),
          .skipped = one.skipped,
          .left = std::max(0, one.total - one.done - one.skipped),
          .reason = one.record.reason};
}

}  // namespace

asio::awaitable<StoreResult<void>> CampaignService::load_interrupted() {
  auto job = [this] { return parts_.store.plans().interrupted(); };
  auto found = co_await parts_.store_thread.ask(job);
  if (!found) co_return std::unexpected(found.error());
  interrupted_ = *std::move(found);
  for (const InterruptedCampaign& one : interrupted_)
    log_warning("interrupted: " + described(one) + "; resume or abort it by its id");
  co_return StoreResult<void>{};
}

std::vector<rpc::InterruptedCampaign> CampaignService::interrupted_campaigns() const {
  std::vector<rpc::InterruptedCampaign> all;
  for (const InterruptedCampaign& one : interrupted_)
    all.push_back({.id = one.record.id,
                   .kind = one.record.kind,
                   .started = one.record.started,
                   .interrupted = one.record.ended,
                   .done = one.done,
                   .total = total_of(one),
                   .reason = one.record.reason});
  return all;
}

std::vector<std::string> CampaignService::also_allowed() const {
  if (interrupted_.empty()) return {};
  if (runner_.in<Disconnected>() || runner_.in<Ready>()) return {"campaign.resume", "campaign.abort"};
  return {};
}

std::expected<const InterruptedCampaign*, RpcError> CampaignService::interrupted(
    const std::string& id) const {
  const auto found = std::ranges::find(interrupted_, id, id_of);
  if (found != interrupted_.end()) return &*found;
  return std::unexpected(RpcError{ErrorCode::NotFound, "no campaign " + id + " was interrupted"});
}

RpcError CampaignService::nothing_paused() const {
  if (interrupted_.empty() || running()) return runner_.wrong_state("no campaign is paused");
  return runner_.wrong_state("no campaign is paused; interrupted: " + described(interrupted_.front()) +
                             "; give its id to resume it");
}

RpcError CampaignService::not_resumable_error(const std::string& id, const std::string& why) const {
  return runner_.wrong_state("campaign " + id + " cannot resume in this cell: " + why +
                             "; correct the cell file, or abort the campaign and start it again");
}

/// Of a base whose points are touched.
std::expected<BaseOrder, RpcError> CampaignService::touching_order(const KeptOrder& kept,
                                                                   const ModelService::Found& model) const {
  BaseOrder order = kept.base.value_or(BaseOrder{});
  try {
    order.touch =
        TouchOrder{config::parse_tool(kept.touching_tool, "its tool", parts_.config.robot.model), {}};
  } catch (const config::ConfigError& error) {
    return std::unexpected(runner_.wrong_state(error.what()));
  }
  const auto by = config::measuring_cell(model.checked->file);
  if (!by) return std::unexpected(RpcError{ErrorCode::Internal, "model " + kept.model_id + " has no noise"});
  const auto usable = use_model(*by, model.record, order);
  if (!usable) return std::unexpected(runner_.wrong_state(usable.error()));
  return order;
}

/// What it was to do, with the model that it was to do it by.
asio::awaitable<std::expected<CampaignOrder, RpcError>> CampaignService::order_of(std::string kind,
                                                                                  KeptOrder kept) {
  if (kind == "calibration") co_return CampaignOrder{CalibrationOrder{}};
  auto model = co_await models_.find_checked(kept.model_id);
  if (!model) co_return std::unexpected(model.error());
  if (kind == "tool") {
    auto order = kept.tool.value_or(ToolOrder{});
    const auto by = config::measuring_cell(model->checked->file);
    if (!by)
      co_return std::unexpected(RpcError{ErrorCode::Internal, "model " + kept.model_id + " has no noise"});
    order.by = *by;
    order.model_id = kept.model_id;
    order.model_serial = model->record.robot_serial;
    co_return CampaignOrder{std::move(order)};
  }
  if (kind == "base") {
    auto order = touching_order(kept, *model);
    if (!order) co_return std::unexpected(order.error());
    co_return CampaignOrder{*std::move(order)};
  }
  TargetsOrder order;
  order.cell = model->checked->file.cell;
  order.model_id = kept.model_id;
  order.model_serial = model->record.robot_serial;
  order.targets = kept.targets;
  order.loop = kept.loop;
  order.readings = kept.readings;
  co_return CampaignOrder{std::move(order)};
}

/// What it continues with, or what speaks against that.
asio::awaitable<std::expected<CampaignService::ResumableCampaign, RpcError>>
CampaignService::resumable_campaign(std::string id) {
  auto job = [this, id] { return read_past(parts_.store, id); };
  auto read = co_await parts_.store_thread.ask(job);
  if (!read) co_return std::unexpected(store_unusable(read.error()));
  const auto past = std::make_shared<CampaignPast>(*std::move(read));
  auto kept = kept_order(past->plan.order);
  if (!kept) co_return std::unexpected(not_resumable_error(id, "its order cannot be read: " + kept.error()));
  config::CellConfig config = parts_.config;
  std::string unreadable;
  try {
    config::use_campaign_options(config, kept->options);
  } catch (const config::ConfigError& error) {
    unreadable = error.what();
  }
  if (!unreadable.empty()) co_return std::unexpected(not_resumable_error(id, unreadable));
  auto order = co_await order_of(past->record.kind, *kept);
  if (!order) co_return std::unexpected(order.error());
  if (const auto* tool = std::get_if<ToolOrder>(&*order)) config = cell_with_tool(std::move(config), *tool);
  past->nests = kept->nests;
  auto judge = [past, config] { return past->misfit(config); };
  const auto misfit = co_await parts_.compute_thread.ask(judge);
  if (misfit) co_return std::unexpected(not_resumable_error(id, *misfit));

  StoreJournal::Options options{.campaign_id = id,
                                .order = past->plan.order,
                                .model_id = {},
                                .config = config,
                                .kind = kind_name(*order),
                                .activate = kept->activate,
                                .interrupted = past->record};
  if (!past->points.empty()) options.measured_before = past->points.back().time;
  co_return ResumableCampaign{past, std::move(options), *std::move(order)};
}

/// What of an interrupted campaign has changed.
asio::awaitable<StoreResult<void>> CampaignService::keep(CampaignRecord record) {
  auto job = [this, record] { return parts_.store.end_campaign(record); };
  auto kept = co_await parts_.store_thread.ask(job);
  if (!kept) store_.failed(kept.error());
  if (kept && run_ && !running() && run_->id() == record.id) run_.reset();  // the store knows more of it now
  co_return kept;
}

asio::awaitable<void> CampaignService::keep_interrupted(std::string id, std::string why) {
  const auto one = std::ranges::find(interrupted_, id, id_of);
  if (one == interrupted_.end()) co_return;  // another client has aborted it meanwhile
  one->record.reason = std::move(why);
  publish(progress_of(*one));
  const auto kept = co_await keep(one->record);
  static_cast<void>(kept);  // a fault says where it is not
}

asio::awaitable<CampaignService::Progress> CampaignService::resume_interrupted(std::string id,
                                                                               std::string by) {
  if (const auto known = interrupted(id); !known) co_return std::unexpected(known.error());
  auto with = co_await resumable_campaign(id);
  if (!with && with.error().code != ErrorCode::Store) co_await keep_interrupted(id, with.error().message);
  if (!with) co_return std::unexpected(with.error());
  // Another client may have aborted it meanwhile.
  if (const auto still = interrupted(id); !still) co_return std::unexpected(still.error());
  const CampaignResumeRequested resume{id};
  const auto launched =
      launch(std::move(with->options), std::move(with->order), resume, by, std::move(with->past));
  if (!launched) co_return std::unexpected(launched.error());
  std::erase_if(interrupted_, [&id](const InterruptedCampaign& one) { return one.record.id == id; });
  co_return last_progress();
}

asio::awaitable<CampaignService::Progress> CampaignService::abort_interrupted(std::string id) {
  const auto known = interrupted(id);
  if (!known) co_return std::unexpected(known.error());
  InterruptedCampaign ended = **known;
  ended.record.state = "aborted";
  ended.record.reason = "aborted by an operator after it was interrupted";
  ended.record.ended = control::rfc3339(parts_.wall_clock());
  std::erase_if(interrupted_, [&id](const InterruptedCampaign& one) { return one.record.id == id; });
  auto kept = co_await keep(ended.record);
  if (!kept) {
    co_await load_interrupted();
    co_return std::unexpected(store_unusable(kept.error()));
  }
  const rpc::CampaignProgress progress = progress_of(ended);
  publish(progress);
  co_return progress;
}

}  // namespace truepose::daemon
