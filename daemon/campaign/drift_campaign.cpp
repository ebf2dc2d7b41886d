#include <memory>
#include <utility>

#include "config/cell_setup.hpp"
#include "daemon/campaign/campaign.hpp"

namespace truepose::daemon {

namespace {

// The tracker may have been moved since the model was made: to find that is what the check is for.
constexpr double kReach = 2;

class DriftCampaign final : public CampaignProcedure {
 public:
  DriftCampaign(MeasuringSession& session, DriftOrder order);
  CampaignOutcome<void> run() override;

 private:
  CampaignOutcome<void> plan();
  CampaignOutcome<void> judge();

  MeasuringSession& session_;
  std::vector<MeasuringTarget> targets_;
};

}  // namespace

DriftCampaign::DriftCampaign(MeasuringSession& session, DriftOrder order) : session_{session} {
  session_.search().expect(order.reference.cell, kReach);
  session_.progress().add_to_total(session_.config().campaign.drift_poses);
  session_.result().findings = DriftResult{.order = std::move(order)};
}

CampaignOutcome<void> DriftCampaign::run() {
  Done done = co_await plan();
  if (!done) co_return done;
  session_.progress().enter(CampaignPhase::Validate);
  done = co_await session_.measure_all(targets_);
  if (done) done = co_await judge();
  co_return done;
}

CampaignOutcome<void> DriftCampaign::plan() {
  const config::CellConfig& config = session_.config();
  PlanOptions options = config::plan_options(config, config.campaign.drift_poses);
  // What tells most of all parameters, so that whatever changed shows.
  options.criterion = DesignCriterion::D;
  options.reference_every = 0;
  CalibratedCell cell = config::rough_cell(config);
  cell.base = session_.search().expected().base;
  cell.reflectors = session_.search().expected().reflectors;
  Done done = co_await session_.plan().choose(cell, options);
  if (!done) co_return done;
  const bool update = session_.result().as<DriftResult>().order.update;
  const PointPurpose purpose = update ? PointPurpose::Identify : PointPurpose::Validate;
  for (const JointVector& q : session_.plan().chosen().poses)
    targets_.push_back(session_.plan().new_target(purpose, q, Replacement::Informative));
  co_return done;
}

CampaignOutcome<void> DriftCampaign::judge() {
  session_.progress().enter(CampaignPhase::Compute);
  DriftResult& result = session_.result().as<DriftResult>();
  // The session outlives the job, and does nothing else meanwhile.
  auto job = [&result,
              points = numbered_points(session_.corrected().points)]() -> std::expected<void, std::string> {
    auto check = drift_check(result.order.reference, points);
    if (!check) return std::unexpected(check.error());
    result.check = *std::move(check);
    if (!result.order.update) return {};
    auto update = update_after_drift(result.order.reference, points);
    if (!update) return std::unexpected(update.error());
    result.update = *std::move(update);
    return {};
  };
  auto judged = co_await session_.compute(job);
  if (!judged) co_return std::unexpected(CampaignError{CampaignFault::Calibration, judged.error()});
  co_return Done{};
}

std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, DriftOrder order) {
  return std::make_unique<DriftCampaign>(session, std::move(order));
}

}  // namespace truepose::daemon
