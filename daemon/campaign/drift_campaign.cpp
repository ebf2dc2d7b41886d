#include "daemon/campaign/drift_campaign.hpp"

#include <memory>
#include <utility>

#include "config/cell_setup.hpp"

namespace truepose::daemon {

namespace {

// The tracker may have been moved since the model was made: to find that is what the check is for.
constexpr double kReach = 2;

using Done = std::expected<void, CampaignError>;

}  // namespace

DriftCampaign::DriftCampaign(MeasuringSession& session, DriftReference reference) : session_{session} {
  session_.expect(reference.cell, kReach);
  session_.add_to_total(session_.config().campaign.drift_poses);
  session_.result().kind = CampaignKind::DriftCheck;
  session_.result().drift_reference = std::move(reference);
}

CampaignOutcome<void> DriftCampaign::run() {
  Done done = co_await plan();
  if (!done) co_return done;
  session_.enter(CampaignPhase::Validate);
  auto measured = co_await session_.measure_all(targets_);
  if (!measured) co_return std::unexpected(measured.error());
  done = co_await judge();
  co_return done;
}

CampaignOutcome<void> DriftCampaign::plan() {
  const config::CellConfig& config = session_.config();
  PlanOptions options = config::plan_options(config, config.campaign.drift_poses);
  // What tells most of all parameters, so that whatever changed shows.
  options.criterion = DesignCriterion::D;
  options.reference_every = 0;
  CalibratedCell cell = config::rough_cell(config);
  cell.base = session_.expected().base;
  cell.reflectors = session_.expected().reflectors;
  Done done = co_await session_.plan(cell, options);
  if (!done) co_return done;
  for (const JointVector& q : session_.planned().poses)
    targets_.push_back(session_.new_target(PointPurpose::Validate, q, Replacement::Informative));
  co_return done;
}

CampaignOutcome<void> DriftCampaign::judge() {
  session_.enter(CampaignPhase::Compute);
  CampaignResult& result = session_.result();
  std::vector<Measurement> points = result.data.points;
  for (std::size_t i = 0; i < points.size(); ++i) points[i].row = static_cast<int>(i) + 1;
  auto check = std::make_shared<std::expected<DriftCheck, std::string>>();
  std::function<void()> job = [check, reference = *result.drift_reference, points] {
    *check = drift_check(reference, points);
  };
  co_await session_.compute(job);
  if (!*check) co_return std::unexpected(CampaignError{CampaignFault::Calibration, check->error()});
  result.data.points = std::move(points);
  result.drift = **check;
  co_return Done{};
}

}  // namespace truepose::daemon
