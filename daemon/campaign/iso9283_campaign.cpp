#include "daemon/campaign/iso9283_campaign.hpp"

#include <memory>
#include <utility>

#include "config/cell_setup.hpp"
#include "core/compensation/target_compensation.hpp"
#include "daemon/campaign/known_cell.hpp"

namespace truepose::daemon {

namespace {

using Done = std::expected<void, CampaignError>;

constexpr std::size_t kPoints = 5;

/// The joints to command for the five poses; those of the nominal arm where nothing compensates.
std::expected<std::array<JointVector, kPoints>, std::string> commanded(const TestCubePoses& poses,
                                                                       const config::CellConfig& config,
                                                                       const CalibratedCell& cell) {
  const RobotModel& nominal = config.robot.model;
  const double way_rad = approach_way_rad(config.campaign, 0);
  std::array<JointVector, kPoints> q;
  const auto side = static_cast<std::int8_t>((way_rad > 0) - (way_rad < 0));
  const std::vector<std::int8_t> direction(nominal.joints.size(), side);
  const TargetCompensation compensation{nominal, cell.robot, config::compensation_options(config, direction)};
  for (std::size_t i = 0; i < kPoints; ++i) {
    const auto solved = compensation.at_joints(poses.q[i], cell.reflectors.front().p_FS_mm);
    if (!solved) {
      return std::unexpected("P" + std::to_string(i + 1) +
                             ", compensated: " + described(solved.error(), nominal));
    }
    q[i] = solved->q;
  }
  return q;
}

}  // namespace

Iso9283Campaign::Iso9283Campaign(MeasuringSession& session, Iso9283Order order)
    : session_{session}, order_{std::move(order)} {
  if (order_.cell) session_.expect(*order_.cell);
  session_.result().kind = CampaignKind::Iso9283;
  session_.add_to_total(static_cast<int>(kPoints) * order_.cycles);
}

CampaignOutcome<void> Iso9283Campaign::run() {
  Done done = co_await plan();
  if (done) done = co_await measure_cycles();
  if (done) done = co_await evaluate();
  co_return done;
}

CampaignOutcome<void> Iso9283Campaign::plan() {
  const config::CellConfig& config = session_.config();
  PlanOptions options = config::plan_options(config, config.campaign.drift_poses);
  options.reference_every = 0;
  const CalibratedCell cell = order_.cell ? known_cell(config, *order_.cell) : config::rough_cell(config);
  Done done = co_await session_.plan(cell, options);
  if (!done) co_return done;

  Scene scene = config::scene_of(config);
  scene.sight.X_WB = cell.base.isometry();
  scene.sight.p_FS_mm = cell.reflectors.front().p_FS_mm;
  auto placed = std::make_shared<std::expected<TestCubePoses, std::string>>();
  TestCubeWish wish = config.iso9283.cube;
  wish.seed = config.campaign.seed;
  wish.task = config.task;
  std::function<void()> job = [placed, scene, wish] { *placed = place_test_cube(scene, wish); };
  co_await session_.compute(job);
  if (!*placed) co_return std::unexpected(CampaignError{CampaignFault::Planning, placed->error()});
  poses_ = **placed;
  q_commanded_ = poses_.q;
  if (!order_.compensate) co_return done;
  const auto q = commanded(poses_, config, *order_.cell);
  if (!q) co_return std::unexpected(CampaignError{CampaignFault::Planning, q.error()});
  q_commanded_ = *q;
  co_return done;
}

CampaignOutcome<void> Iso9283Campaign::measure_cycles() {
  session_.enter(CampaignPhase::Cycles);
  // So that the first P5 too is come to from P1.
  Done done = co_await session_.visit(q_commanded_[0]);
  for (int cycle = 0; done && cycle < order_.cycles; ++cycle) {
    for (std::size_t i = kPoints; done && i-- > 0;) {
      MeasuringTarget target = session_.new_target(PointPurpose::Cycle, poses_.q[i]);
      target.q_commanded = q_commanded_[i];
      target.way_rad = approach_way_rad(session_.config().campaign, 0);
      auto point = co_await session_.measure(target);
      if (!point) done = std::unexpected(point.error());
    }
  }
  co_return done;
}

CampaignOutcome<void> Iso9283Campaign::evaluate() {
  session_.enter(CampaignPhase::Compute);
  std::vector<TestPoint> points(kPoints);
  for (std::size_t i = 0; i < kPoints; ++i)
    points[i] = {.name = "P" + std::to_string(i + 1), .commanded = {poses_.p_B_mm[i], {}}, .attained = {}};
  for (const StoredPoint& point : session_.result().points)
    points[kPoints - 1 - static_cast<std::size_t>(point.pose) % kPoints].attained.push_back(
        {{point.p_WS_mm, {}}, {}, {}});
  for (const TestPoint& point : points) {
    if (point.attained.empty())
      co_return std::unexpected(
          CampaignError{CampaignFault::Calibration, point.name + " was never measured"});
  }

  Eigen::Isometry3d X_BW;
  if (order_.cell) {
    X_BW = order_.cell->base.isometry().inverse();
  } else {
    const auto fitted = fitted_frame(points);
    if (!fitted) co_return std::unexpected(CampaignError{CampaignFault::Calibration, fitted.error()});
    X_BW = *fitted;
  }
  Iso9283Test test{.frame = order_.cell ? control::Iso9283Frame::Model : control::Iso9283Frame::Fitted,
                   .compensated = order_.compensate,
                   .cube = poses_.cube,
                   .points = in_base(std::move(points), X_BW),
                   .result = {}};
  auto result = evaluate_iso9283(test.points);
  if (!result) co_return std::unexpected(CampaignError{CampaignFault::Calibration, result.error()});
  test.result = *std::move(result);
  session_.result().iso9283 = std::move(test);
  co_return Done{};
}

}  // namespace truepose::daemon
