#include "daemon/cell/model_service.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "config/cell_setup.hpp"
#include "config/model_file.hpp"
#include "core/math/angles.hpp"
#include "core/math/statistics.hpp"
#include "core/planted_bug.hpp"
#include "daemon/campaign/arm_check.hpp"
#include "daemon/log/log.hpp"
#include "proto/rpc/events.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::ErrorCode;
using control::RpcError;

namespace {

constexpr const char* kActiveModel = "active model";  // what the store may still have to take
constexpr std::size_t kModelsRemembered = 8;          // of those that the stream was given

/// Not validated = no number.
std::optional<double> error_or_none(double mean_mm) {
  return mean_mm > 0 ? std::optional{mean_mm} : std::nullopt;
}

rpc::ModelSummary summary_of(const ModelRecord& record) {
  return {.id = record.id,
          .created = record.created,
          .campaign_id = record.campaign_id,
          .robot_serial = record.robot_serial,
          .validation_before_mm = error_or_none(record.validation_before_mm),
          .validation_after_mm = error_or_none(record.validation_after_mm),
          .active = record.active};
}

/// "judged red when it was made: ..", of a verdict that failed.
std::optional<std::string> warning_of(const std::optional<CalibrationVerdict>& verdict) {
  if (!verdict || !verdict->failed()) return std::nullopt;
  return "judged " + std::string{name_of(kVerdictColorNames, verdict->color())} +
         " when it was made: " + verdict->findings.front().sentence;
}

rpc::Parameter parameter_of(const IdentifiedParameter& parameter) {
  return {.name = parameter.name,
          .nominal = parameter.nominal,
          .value = parameter.value,
          .sigma = parameter.sigma,
          .identified = parameter.identified};
}

RpcError no_model(const std::string& id) {
  return {ErrorCode::NotFound, id.empty() ? "no model is active" : "no such model"};
}

}  // namespace

ModelService::ModelService(const CellParts& parts, CellRunner& runner, StoreWatch& store,
                           const DeviceService& devices, ToolService& tools)
    : parts_{parts}, runner_{runner}, store_{store}, devices_{devices}, tools_{tools} {
  tools.when_changed([this] {
    if (active_) give_to_stream(*active_);
  });
}

std::vector<Served<ModelService>> ModelService::methods() {
  return {&ModelService::list,     &ModelService::get,        &ModelService::activate,
          &ModelService::rollback, &ModelService::deactivate, &ModelService::export_yaml};
}

asio::awaitable<StoreResult<void>> ModelService::load_active() {
  auto found = co_await read("");
  if (!found) co_return std::unexpected(found.error());
  if (!*found || !(*found)->checked) {
    forget();
    if (!*found) co_return StoreResult<void>{};
    const std::string& refused = (*found)->checked.error();
    log_error(refused);
    runner_.faults().begin({FaultCode::Model, refused});
    refused_ = (*found)->record;
    co_return StoreResult<void>{};
  }
  runner_.faults().end(FaultCode::Model);
  refused_.reset();
  const StoredModel& model = *(*found)->checked;
  active_ = Active{(*found)->record, model.file.cell, config::drift_reference(model.file),
                   warning_of(model.file.verdict)};
  give_to_stream(*active_);
  if (!model.unchecked.empty()) log_warning(model.unchecked);
  co_return StoreResult<void>{};
}

void ModelService::give_to_stream(const Active& model) {
  const Given& given = given_with_tool(model);
  if (given.number == 1 || !planted("the stream keeps its first model"))
    parts_.stream.use_model(given.cell.robot, given.number, given.cell.reflectors.front().p_FS_mm);
  compare_frame();
}

const ModelService::Given& ModelService::given_with_tool(const Active& model) {
  if (parts_.config.stream.tool) tool_.number = parts_.config.stream.tool;
  const config::ToolFile* tool = tool_.number ? tools_.of(*tool_.number) : nullptr;
  const LinkMass* load = config::load_of(parts_.config, tool_.number);
  auto arm = config::corrected_arm(parts_.config, model.cell, tool, load, tool_.X);
  runner_.faults().stand(!arm, {FaultCode::Tool, arm ? "" : arm.error()});
  if (!arm && load) arm = config::corrected_arm(parts_.config, model.cell, tool, nullptr, tool_.X);
  tool_.is_measured = tool && arm;
  if (!arm) arm = config::corrected_arm(parts_.config, model.cell, nullptr);

  Given given{0, model.record, model.cell, tool_.is_measured ? tool_.number : std::nullopt, {}};
  if (given.tool) given.tool_of = tools_.campaign_of(*given.tool);
  given.cell.robot = arm->robot;
  given.cell.reflectors = {{"1", arm->p_F_mm}};
  // A program takes its tools in turn: the last recording shall know them all.
  const auto before = std::ranges::find_if(given_, [&](const Given& other) {
    return other.record.id == given.record.id && other.tool == given.tool && other.tool_of == given.tool_of &&
           other.cell.robot.payload == given.cell.robot.payload &&
           other.cell.robot.X_flange.matrix() == given.cell.robot.X_flange.matrix();
  });
  given.number = before == given_.end() ? ++number_ : before->number;
  if (before != given_.end()) given_.erase(before);
  if (given_.size() == kModelsRemembered) given_.pop_front();
  return given_.emplace_back(std::move(given));
}

void ModelService::controller_has(std::optional<int> tool,
                                  const std::optional<std::array<double, 6>>& frame) {
  if (tool && frame) {
    const std::array<double, 6>& at = *frame;
    frames_[*tool] = pose_from_kuka({at[0], at[1], at[2]}, {at[3], at[4], at[5]});
  }
  const auto& fixed = parts_.config.stream.tool;
  const std::optional<int> number = fixed ? fixed : tool;
  const auto found = number ? frames_.find(*number) : frames_.end();
  const auto X = found == frames_.end() ? std::nullopt : std::optional{found->second};
  const bool same_frame = X.has_value() == tool_.X.has_value() && (!X || X->isApprox(*tool_.X));
  const bool same_tool = number == tool_.number;
  tool_.is_current = (frame && number == tool) || (tool_.is_current && same_tool && same_frame);
  if (same_tool && same_frame) {
    if (active_) compare_frame();
    return;
  }
  const bool was_measured = tool_.is_measured;
  const LinkMass* const carried = config::load_of(parts_.config, tool_.number);
  tool_ = {.number = number, .X = X, .is_current = tool_.is_current};
  const bool is_measured = tool_.number && tools_.of(*tool_.number);
  const bool carries_else = config::load_of(parts_.config, tool_.number) != carried;
  if (active_ && (was_measured || is_measured || carries_else)) give_to_stream(*active_);
}

/// Whether the measured frame is in TOOL_DATA.
void ModelService::compare_frame() {
  const config::ToolFile* const tool = tool_.number ? tools_.of(*tool_.number) : nullptr;
  const std::string differs =
      tool && tool_.X && tool_.is_current ? config::other_tool_data(*tool, *tool_.X) : "";
  runner_.faults().stand(!differs.empty(), {FaultCode::ToolData, differs});
}

void ModelService::forget() {
  active_.reset();
  refused_.reset();
  parts_.stream.use_no_model();
  runner_.faults().end(FaultCode::Model);
  runner_.faults().end(FaultCode::ToolData);
}

ModelService::Lack ModelService::lacks_model(const std::string& why) {
  return {why, std::string{kNeedsModelOfTheArm}, {"model.activate", "campaign.start"}};
}

RpcError ModelService::refusal(const Lack& lack) const {
  std::string allowed;
  for (const std::string& method : lack.allowed) allowed += (allowed.empty() ? "" : ", ") + method;
  return runner_.wrong_state(lack.why + "; allowed: " + allowed, lack.allowed);
}

std::optional<ModelService::Lack> ModelService::lack() const {
  if (!active_) {
    const std::string refused = runner_.faults().text(FaultCode::Model);
    return lacks_model(refused.empty() ? "no model is active" : refused);
  }
  const std::string other = devices_.other_arm("the active model", active_->record.robot_serial);
  return other.empty() ? std::nullopt : std::optional{lacks_model(other)};
}

std::optional<ModelService::Lack> ModelService::missing_for_correction() const {
  if (auto of_model = lack()) return of_model;
  std::string refused = tools_.refusal();
  const auto& fixed = parts_.config.stream.tool;
  if (fixed && !tools_.of(*fixed) && !config::load_of(parts_.config, fixed))
    refused = "stream.tool: " + std::to_string(*fixed) +
              " is in no file of tools, has no load, and is no tool in use that a campaign measured";
  if (refused.empty() && tool_.number && tools_.of(*tool_.number) && !tool_.is_measured)
    refused = runner_.faults().text(FaultCode::Tool);
  if (refused.empty()) return std::nullopt;
  return Lack{
      refused, "activate the arm's tool, or deactivate this one", {"tool.activate", "tool.deactivate"}};
}

std::expected<const ModelService::Active*, RpcError> ModelService::needed() const {
  if (const auto of_model = lack()) return std::unexpected(refusal(*of_model));
  return &*active_;
}

std::expected<const ModelService::Active*, RpcError> ModelService::needed_for_drift() const {
  auto active = needed();
  if (active && !(*active)->drift_reference)
    return std::unexpected(refusal(lacks_model("the active model holds no noise and was not validated")));
  return active;
}

std::expected<const ModelService::Active*, RpcError> ModelService::needed_to_correct() const {
  if (const auto of_correction = missing_for_correction()) return std::unexpected(refusal(*of_correction));
  return &*active_;
}

asio::awaitable<StoreResult<std::optional<ModelService::Found>>> ModelService::read(std::string id) {
  auto job = [this, id]() -> StoreResult<std::optional<Found>> {
    auto record = id.empty() ? parts_.store.active_model() : parts_.store.model(id);
    if (!record) return std::unexpected(record.error());
    if (!*record) return std::nullopt;
    const auto points = parts_.store.points((*record)->campaign_id);
    if (!points) return std::unexpected(points.error());
    return Found{**record, checked_model(**record, *points, parts_.config)};
  };
  auto found = co_await parts_.store_thread.ask(job);
  co_return found;
}

asio::awaitable<std::expected<ModelService::Found, RpcError>> ModelService::find_checked(std::string id) {
  auto found = co_await read(id);
  if (!found) co_return std::unexpected(store_unusable(found.error()));
  if (!*found) co_return std::unexpected(no_model(id));
  if (!(*found)->checked) co_return std::unexpected(runner_.wrong_state((*found)->checked.error()));
  co_return **std::move(found);
}

asio::awaitable<std::expected<ModelRecord, RpcError>> ModelService::find(std::string id) {
  auto job = [this, id] { return id.empty() ? parts_.store.active_model() : parts_.store.model(id); };
  auto record = co_await parts_.store_thread.ask(job);
  if (!record) co_return std::unexpected(store_unusable(record.error()));
  if (!*record) co_return std::unexpected(no_model(id));
  co_return **record;
}

Reply<rpc::ModelList> ModelService::list(rpc::ModelList request) {
  auto job = [this] { return parts_.store.models(); };
  auto records = co_await parts_.store_thread.ask(job);
  if (!records) co_return std::unexpected(store_unusable(records.error()));
  for (ModelRecord& record : *records) record.active = is_in_effect(record.id);
  co_return rpc::ModelList::Result{.models = page_of(*records, request, &summary_of),
                                   .total = static_cast<int>(records->size())};
}

Reply<rpc::ModelGet> ModelService::get(rpc::ModelGet request) {
  auto record = co_await find(request.id.value_or(""));
  if (!record) co_return std::unexpected(record.error());
  auto read = [record = *record] { return unaltered_model(record); };
  const auto file = co_await parts_.store_thread.ask(read);
  if (!file) co_return std::unexpected(runner_.wrong_state(file.error()));
  record->active = is_in_effect(record->id);
  rpc::ModelGet::Result result{.model = summary_of(*record)};
  std::ranges::transform(file->parameters, std::back_inserter(result.parameters), parameter_of);
  co_return result;
}

Reply<rpc::ModelExport> ModelService::export_yaml(rpc::ModelExport request) {
  auto record = co_await find(request.id.value_or(""));
  if (!record) co_return std::unexpected(record.error());
  co_return rpc::ModelExport::Result{.id = record->id, .yaml = record->yaml};
}

std::string ModelService::why_not_activated(const Found& found) const {
  if (!improves(found.record.validation_before_mm, found.record.validation_after_mm))
    return "the model is no better than the nominal arm on validation poses";
  if (std::string other = devices_.other_arm("the model", found.record.robot_serial); !other.empty())
    return other;
  if (found.checked) return {};
  log_error(found.checked.error());
  return found.checked.error();
}

Reply<rpc::ModelActivate> ModelService::activate(rpc::ModelActivate request, std::string by) {
  return make_active(std::move(request.id), std::move(by));
}

Reply<rpc::ModelRollback> ModelService::rollback(rpc::ModelRollback, std::string by) {
  auto job = [this] { return parts_.store.model_before(); };
  const auto before = co_await parts_.store_thread.ask(job);
  if (!before) co_return std::unexpected(store_unusable(before.error()));
  if (!*before) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no other model was active before"});
  auto activated = co_await make_active((*before)->id, std::move(by));
  co_return activated;
}

Reply<rpc::ModelActivate> ModelService::make_active(std::string id, std::string by) {
  auto found = co_await read(id);
  if (!found) co_return std::unexpected(store_unusable(found.error()));
  if (!*found) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such model"});
  if (const std::string why_not = why_not_activated(**found); !why_not.empty())
    co_return std::unexpected(runner_.wrong_state(why_not));
  auto job = [this, id] { return parts_.store.activate_model(id); };
  auto activated = co_await parts_.store_thread.ask(job);
  if (!activated) co_return std::unexpected(store_unusable(activated.error()));
  store_.forget(kActiveModel);
  auto loaded = co_await load_active();
  if (!loaded) co_return std::unexpected(store_unusable(loaded.error()));
  if (!active_) {
    const std::string refused = runner_.faults().text(FaultCode::Model);
    co_return std::unexpected(runner_.wrong_state(refused.empty() ? "no model is active" : refused));
  }
  publish("activated", active_->record, by);
  co_return *active_summary();
}

Reply<rpc::ModelDeactivate> ModelService::deactivate(rpc::ModelDeactivate, std::string by) {
  const std::optional<ModelRecord> before = active_ ? std::optional{active_->record} : refused_;
  forget();
  auto job = [this] { return parts_.store.activate_model(""); };
  co_await store_.keep(kActiveModel, job);
  if (before) publish("deactivated", *before, by);
  rpc::ModelDeactivate::Result result;
  if (before) result.deactivated = before->id;
  co_return result;
}

asio::awaitable<void> ModelService::announce_made(std::string id, bool activated, std::string by) {
  auto model = co_await find(std::move(id));
  if (model) publish("made", *model, by);
  if (!activated) co_return;
  store_.forget(kActiveModel);
  auto loaded = co_await load_active();
  if (!loaded) log_error(loaded.error().detail);
  if (active_) publish("activated", active_->record, by);
}

void ModelService::publish(const char* change, const ModelRecord& record, const std::string& by) {
  log_info("model " + record.id + " " + change);
  rpc::ModelChanged changed{.by = text_or_none(by), .change = change, .model = summary_of(record)};
  parts_.events.publish(changed);
}

std::optional<rpc::ModelSummary> ModelService::active_summary() const {
  if (!active_) return std::nullopt;
  rpc::ModelSummary summary = summary_of(active_->record);
  summary.warning = active_->warning;
  return summary;
}

}  // namespace truepose::daemon
