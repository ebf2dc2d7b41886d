#include "daemon/campaign/session_devices.hpp"

#include <utility>

#include "core/math/units.hpp"

namespace truepose::daemon {

using namespace std::chrono_literals;

namespace {

constexpr Duration kBeforeRetry = 1s;

/// A device's error that ends the campaign.
CampaignError fatal(const DeviceError& error) {
  return {.fault = error.remedy == Remedy::WrongArm ? CampaignFault::WrongArm : CampaignFault::Device,
          .detail = error.detail,
          .what_to_do = error.what_to_do};
}

/// What the tracker reports of it.
StoredPoint stored_point(const drivers::SmrPoint& measured) {
  return {.p_WS_mm = measured.p_WS_mm,
          .orientation = measured.orientation,
          .std_mm = measured.std_mm,
          .temperature_c = measured.temperature_c,
          .pressure_mbar = measured.pressure_mbar,
          .humidity_percent = measured.humidity_percent};
}

}  // namespace

std::vector<std::int8_t> approach_direction(const MeasuringTarget& target, const RobotModel& robot) {
  const auto side = static_cast<std::int8_t>((target.way_rad > 0) - (target.way_rad < 0));
  return std::vector<std::int8_t>(robot.joints.size(), side);
}

SessionDevices::SessionDevices(CampaignRun& run, CampaignDevices devices, RunJob run_compute)
    : run_{run},
      cell_{run.config(), devices,
            [&run](const std::string& sentence) { run.observer().on_trouble(sentence); },
            [&run](CellDevice device, const std::string& reason) {
              run.observer().on_waiting(device, reason);
            }},
      motion_{run.config().robot.model, cell_, std::move(run_compute)},
      search_{run.config(), cell_} {}

CampaignOutcome<Identities> SessionDevices::connect(CampaignNeeds needs) {
  const ArmProof proof = needs.moving_arm ? ArmProof::ByMotion : ArmProof::AsItStands;
  for (int tries_left = run_.config().campaign.retries;; --tries_left) {
    auto identities = co_await cell_.connect(proof, needs.tracker);
    if (identities) co_return *std::move(identities);
    const DeviceError& error = identities.error();
    if (error.remedy == Remedy::WrongArm || tries_left == 0) co_return std::unexpected(fatal(error));
    run_.observer().on_trouble(error.detail + "; trying again");
    co_await run_.clock().sleep_until(run_.clock().now() + kBeforeRetry);
  }
}

CampaignOutcome<void> SessionDevices::prove_arm() {
  for (int tries_left = run_.config().campaign.retries;; --tries_left) {
    co_await run_.pause().wait();
    auto proven = co_await cell_.prove_arm();
    if (proven) co_return Done{};
    if (proven.error().remedy == Remedy::Retry && tries_left == 0)
      co_return std::unexpected(fatal(proven.error()));
    run_.observer().on_trouble("the first small motions: " + proven.error().detail);
    Done recovered = co_await recover(proven.error());
    if (!recovered) co_return recovered;
  }
}

CampaignOutcome<void> SessionDevices::recover(DeviceError error) {
  if (error.remedy == Remedy::WrongArm) co_return std::unexpected(fatal(error));
  if (error.remedy == Remedy::Retry) {
    co_await run_.clock().sleep_until(run_.clock().now() + kBeforeRetry);
    co_return Done{};
  }
  auto recovered = co_await cell_.recover(std::move(error));
  if (!recovered) co_return std::unexpected(fatal(recovered.error()));
  co_return Done{};
}

CellDevices::Outcome<std::vector<StoredPoint>> SessionDevices::read(MeasuringTarget target) {
  auto reached = co_await reach(target);
  if (!reached) co_return std::unexpected(reached.error());
  ReflectorSearch::ArmPosture posture{.q = *reached,
                                      .direction = motion_.direction(),
                                      .purpose = target.purpose,
                                      .readings = target.readings,
                                      .two_face = in_two_faces(target.pose)};
  auto seen = co_await search_.measure(std::move(posture));
  if (!seen) co_return std::unexpected(seen.error());
  for (const std::string& sentence : seen->missed)
    run_.observer().on_trouble("pose " + std::to_string(target.pose) + ": " + sentence);
  std::vector<StoredPoint> points;
  for (const ReflectorSearch::ReflectorResult& found : seen->found) {
    const std::string& smr = search_.name(found.reflector);
    // First, so that a point that is there is known to have been seen in both faces.
    if (found.measured.face1)
      points.emplace_back(point_at(target, *reached, *found.measured.face1, smr)).purpose =
          PointPurpose::Face1;
    points.push_back(point_at(target, *reached, found.measured.point, smr));
  }
  co_return points;
}

CellDevices::Outcome<StoredPoint> SessionDevices::read_fixed(FixedReflector what,
                                                             CellDevices::MeasureRequest request) {
  auto q = co_await cell_.position();
  if (!q) co_return std::unexpected(q.error());
  auto measured = co_await cell_.measure(request);
  if (!measured) co_return std::unexpected(measured.error());
  StoredPoint point = stored_point(measured->point);
  point.pose = what.number;
  point.purpose = what.purpose;
  point.smr = what.name;
  point.q_target = point.q_commanded = point.q_actual = *q;
  co_return point;
}

CellDevices::Outcome<StoredPoint> SessionDevices::read_again(StoredPoint before, Eigen::Vector3d p_W_mm) {
  const config::CampaignConfig& campaign = run_.config().campaign;
  const bool is_nest = before.purpose == PointPurpose::Nest;
  const double search_mm = is_nest ? run_.config().tracker.first_search_radius_mm : search_.clear_radius_mm();
  CellDevices::MeasureRequest request{.p_W_mm = p_W_mm, .search_mm = search_mm, .gate_mm = search_mm};
  if (is_nest) {
    const FixedReflector nest{before.pose, before.smr, PointPurpose::Check};
    co_return co_await read_fixed(nest, request);
  }
  request.two_face = in_two_faces(before.pose);
  const MeasuringTarget target{.pose = before.pose,
                               .purpose = PointPurpose::Check,
                               .q_target = before.q_target,
                               .q_commanded = before.q_commanded,
                               .way_rad = before.purpose == PointPurpose::Reference
                                              ? campaign.approach_deg * kRadPerDeg
                                              : approach_way_rad(campaign, before.pose)};
  auto reached = co_await reach(target);
  if (!reached) co_return std::unexpected(reached.error());
  auto measured = co_await cell_.measure(request);
  if (!measured) co_return std::unexpected(measured.error());
  co_return point_at(target, *reached, measured->point, before.smr);
}

CellDevices::Outcome<JointVector> SessionDevices::reach(MeasuringTarget target) {
  if (target.q_from.size() > 0) {
    auto start = co_await motion_.drive(target.q_from);
    if (!start) co_return start;
    target.way_rad = 0;
  }
  co_return co_await motion_.arrive(target.q_commanded, target.way_rad);
}

/// Of what was measured there.
StoredPoint SessionDevices::point_at(const MeasuringTarget& target, const JointVector& reached,
                                     const drivers::SmrPoint& measured, const std::string& smr) const {
  StoredPoint point = stored_point(measured);
  point.pose = target.pose;
  point.purpose = target.purpose;
  point.q_target = target.q_target;
  point.q_commanded = target.q_commanded;
  point.q_actual = reached;
  point.direction = motion_.direction();
  point.smr = smr;
  return point;
}

bool SessionDevices::in_two_faces(int pose) const {
  const int every = run_.config().campaign.two_face_every;
  return every > 0 && pose % every == 0;
}

}  // namespace truepose::daemon
