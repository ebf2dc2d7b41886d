#include <memory>
#include <utility>

#include "config/cell_setup.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/campaign/stored_model.hpp"

namespace truepose::daemon {

namespace {

constexpr std::size_t kPoints = 5, kApproaches = 9;
// Long enough for the joints to take up their backlash, short enough to stay about the point.
constexpr double kApproach_mm = 100;

std::string name_of(std::size_t point) { return "P" + std::to_string(point + 1); }

std::string direction_name(const PointApproach& approach) {
  return {approach.upwards ? '+' : '-', "xyz"[approach.axis]};
}

class Iso9283Campaign final : public CampaignProcedure {
 public:
  Iso9283Campaign(MeasuringSession& session, Iso9283Order order);
  CampaignOutcome<void> run() override;

 private:
  /// A stop and its joints.
  struct Stop : Iso9283Stop {
    JointVector q_target, q_commanded;
    JointVector q_from;                   ///< empty: the stop before
    std::vector<std::int8_t> directions;  ///< of the joints there, see DeviationBasis::Approach
  };

  CampaignOutcome<void> plan();
  std::vector<Stop> stops() const;
  void foresee_directions();
  std::expected<void, std::string> compensate();
  MeasuringTarget target_of(const Stop& stop);
  CampaignOutcome<void> measure_cycles();
  std::vector<TestPoint> measured_points();
  CampaignOutcome<void> evaluate();

  MeasuringSession& session_;
  Iso9283Order order_;
  TestCubePoses poses_;
  std::vector<Stop> stops_;
};

}  // namespace

Iso9283Campaign::Iso9283Campaign(MeasuringSession& session, Iso9283Order order)
    : session_{session}, order_{std::move(order)} {
  if (order_.cell) session_.search().expect(*order_.cell);
  session_.result().findings = Iso9283Test{};
  const std::size_t stops = kPoints + (order_.variation ? kApproaches : 0);
  session_.progress().add_to_total(static_cast<int>(stops) * order_.cycles);
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
  Done done = co_await session_.plan().choose(cell, options);
  if (!done) co_return done;

  Scene scene = config::scene_of(config);
  scene.sight.X_WB = cell.base.isometry();
  scene.sight.p_FS_mm = cell.reflectors.front().p_FS_mm;
  scene.sight.further.clear();
  TestCubeRequest request = config.iso9283.cube;
  request.seed = config.campaign.seed;
  request.task = config.task;
  request.approach_mm = order_.variation ? kApproach_mm : 0;
  auto job = [scene, request] { return place_test_cube(scene, request); };
  auto placed = co_await session_.compute(job);
  if (!placed) co_return std::unexpected(CampaignError{CampaignFault::Planning, placed.error()});
  poses_ = *std::move(placed);
  stops_ = stops();
  if (!order_.compensate) co_return done;
  const auto compensated = compensate();
  if (!compensated) co_return std::unexpected(CampaignError{CampaignFault::Planning, compensated.error()});
  co_return done;
}

/// They end at P1, so that the next cycle comes to P5 from there.
std::vector<Iso9283Campaign::Stop> Iso9283Campaign::stops() const {
  std::vector<Stop> stops;
  for (std::size_t i = kPoints; i-- > 0;) stops.push_back({{i, {}}, poses_.q[i], poses_.q[i], {}, {}});
  for (const PointApproach& approach : poses_.approaches) {
    const JointVector& q = poses_.q[approach.point];
    stops.push_back({{approach.point, direction_name(approach)}, q, q, approach.q_start, {}});
  }
  return stops;
}

/// By the straight ways; in the second cycle each stop is come to from the one before.
void Iso9283Campaign::foresee_directions() {
  std::vector<std::int8_t> directions;
  JointVector here = stops_.back().q_target;
  const auto go_to = [&](const JointVector& q) {
    directions = direction_after(std::move(directions), q - here);
    here = q;
  };
  const double side_rad = approach_way_rad(session_.config().campaign, 1);
  for (int cycle = 0; cycle < 2; ++cycle) {
    for (Stop& stop : stops_) {
      if (stop.q_from.size() > 0) {
        go_to(stop.q_from);
      } else if (side_rad != 0) {
        go_to(approach_start(session_.config().robot.model, stop.q_target, side_rad));
      }
      go_to(stop.q_target);
      stop.directions = directions;
    }
  }
}

/// From the nominal joints to those of the model, the starts of approaches likewise.
std::expected<void, std::string> Iso9283Campaign::compensate() {
  foresee_directions();
  const config::CellConfig& config = session_.config();
  const RobotModel& nominal = config.robot.model;
  for (Stop& stop : stops_) {
    const auto solved = compensated(stop.q_target, stop.directions, config, *order_.cell);
    if (!solved)
      return std::unexpected(name_of(stop.point) + ", compensated: " + described(solved.error(), nominal));
    stop.q_commanded = solved->q;
    if (stop.q_from.size() > 0) stop.q_from += stop.q_commanded - stop.q_target;
  }
  return {};
}

MeasuringTarget Iso9283Campaign::target_of(const Stop& stop) {
  return {.pose = session_.plan().next_number(),
          .purpose = PointPurpose::Cycle,
          .q_target = stop.q_target,
          .q_commanded = stop.q_commanded,
          .way_rad = approach_way_rad(session_.config().campaign, 1),
          .q_from = stop.q_from};
}

CampaignOutcome<void> Iso9283Campaign::measure_cycles() {
  session_.progress().enter(CampaignPhase::Cycles);
  // So that the first P5 too is come to from P1.
  Done done = co_await session_.visit(stops_.back().q_commanded);
  for (int cycle = 0; done && cycle < order_.cycles; ++cycle) {
    for (std::size_t i = 0; done && i < stops_.size(); ++i) {
      auto point = co_await session_.measure(target_of(stops_[i]));
      if (!point) done = std::unexpected(point.error());
    }
  }
  co_return done;
}

std::vector<TestPoint> Iso9283Campaign::measured_points() {
  std::vector<TestPoint> points;
  for (std::size_t i = 0; i < kPoints; ++i)
    points.push_back({.name = name_of(i), .commanded = {poses_.p_B_mm[i], {}}, .attained = {}});
  for (const StoredPoint& point : session_.corrected().points) {
    const Stop& stop = stops_[static_cast<std::size_t>(point.pose - 1) % stops_.size()];
    points[stop.point].attained.push_back({{*point.p_WS_mm, {}}, stop.direction, {}});
  }
  return points;
}

CampaignOutcome<void> Iso9283Campaign::evaluate() {
  session_.progress().enter(CampaignPhase::Compute);
  std::vector<TestPoint> points = measured_points();
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
  Iso9283Test test{.frame = order_.cell ? record::Iso9283Frame::Model : record::Iso9283Frame::Fitted,
                   .compensated = order_.compensate,
                   .cube = poses_.cube,
                   .stops = {stops_.begin(), stops_.end()},
                   .points = in_base(std::move(points), X_BW),
                   .result = {}};
  auto result = evaluate_iso9283(test.points);
  if (!result) co_return std::unexpected(CampaignError{CampaignFault::Calibration, result.error()});
  test.result = *std::move(result);
  session_.result().findings = std::move(test);
  co_return Done{};
}

std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, Iso9283Order order) {
  return std::make_unique<Iso9283Campaign>(session, std::move(order));
}

}  // namespace truepose::daemon
