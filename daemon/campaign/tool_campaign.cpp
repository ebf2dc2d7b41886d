#include <algorithm>
#include <memory>
#include <utility>

#include "config/cell_setup.hpp"
#include "core/arm/forward.hpp"
#include "core/formatted.hpp"
#include "core/frames/tool_frame.hpp"
#include "core/frames/tool_turn.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/campaign/nest_watch.hpp"

namespace truepose::daemon {

namespace {

// Nearer to the model's reflector than this it is likely to be that one.
constexpr double kSameReflector_mm = 2;

class ToolCampaign final : public CampaignProcedure {
 public:
  ToolCampaign(MeasuringSession& session, ToolOrder order);
  CampaignOutcome<void> run() override;

 private:
  bool by_hand() const { return !order_.together && order_.points.size() > 1; }
  CampaignOutcome<void> plan();
  Done judge_orientations() const;
  Done judge_target();
  CampaignOutcome<void> put_reflector_at(std::size_t point);
  CampaignOutcome<void> measure();
  CampaignOutcome<void> learn_place();
  FrameReadings readings();
  std::vector<std::optional<Eigen::Vector3d>> places_mm();
  CampaignOutcome<void> evaluate();

  MeasuringSession& session_;
  NestWatch nests_{session_};
  ToolOrder order_;
  std::vector<MeasuringTarget> targets_;
  std::size_t known_ = 0;  ///< points whose place was learnt from readings
};

}  // namespace

ToolCampaign::ToolCampaign(MeasuringSession& session, ToolOrder order)
    : session_{session}, order_{std::move(order)} {
  session_.result().findings = ToolResult{.order = order_};
  session_.progress().add_to_total(order_.poses * (by_hand() ? static_cast<int>(order_.points.size()) : 1));
}

CampaignOutcome<void> ToolCampaign::run() {
  if (!order_.assumed.empty()) session_.observer().on_trouble(order_.assumed);
  Done done = co_await plan();
  if (!done) co_return done;
  session_.progress().enter(CampaignPhase::Frame);
  done = co_await nests_.measure();
  const std::size_t stages = by_hand() ? order_.points.size() : 1;
  for (std::size_t point = 0; done && point < stages; ++point) {
    if (by_hand()) done = co_await put_reflector_at(point);
    if (done) done = co_await measure();
  }
  if (done) done = co_await nests_.measure();
  if (done) done = co_await evaluate();
  co_return done;
}

CampaignOutcome<void> ToolCampaign::plan() {
  const config::CellConfig& config = session_.config();
  PlanOptions options = config::plan_options(config, order_.poses);
  options.by_orientation = true;
  options.reference_every = 0;
  const Reflectors reflectors = order_.together ? Reflectors::All : Reflectors::First;
  Done done = co_await session_.plan().choose(config::rough_cell(config), options, reflectors);
  if (!done) co_return done;
  std::vector<JointVector> poses = session_.plan().chosen().poses;
  // Of one that continues, what came up on the way follows.
  poses.resize(std::min(poses.size(), static_cast<std::size_t>(order_.poses)));
  for (const JointVector& q : poses)
    targets_.push_back(session_.plan().new_target(PointPurpose::Frame, q, Replacement::Near));
  if (order_.poses >= kFewestOrientations) done = judge_orientations();
  if (done) done = co_await session_.plan().keep(targets_);
  co_return done;
}

Done ToolCampaign::judge_orientations() const {
  std::vector<Eigen::Matrix3d> turns;
  for (const MeasuringTarget& target : targets_)
    turns.push_back(forward_kinematics(session_.config().robot.model, target.q_target).linear());
  const std::string alike = too_alike(turns);
  if (alike.empty()) return {};
  return std::unexpected(
      CampaignError{CampaignFault::Planning,
                    "where the tracker sees the reflector, " + alike +
                        ", so the arm's error along it would stay in the TCP: turn the reflector's "
                        "opening, or give the arm more room"});
}

/// Waits for the hand that puts it there. The poses are the same for all points, which are next to each
/// other.
CampaignOutcome<void> ToolCampaign::put_reflector_at(std::size_t point) {
  session_.search().look_for_single(point);
  if (point == 0) co_return Done{};
  const std::string sentence = "put the reflector at point \"" + order_.points[point].point.name +
                               "\" of tool " + std::to_string(order_.number) +
                               ", opened to where it was opened to before, then resume the campaign";
  co_await session_.wait_for_operator(sentence);
  // Only the positions of the points before it are known.
  const config::TrackerConfig& tracker = session_.config().tracker;
  CalibratedCell cell = session_.search().expected();
  if (order_.points[point].p_F_mm == order_.points.front().p_F_mm)
    cell.reflectors[point].p_FS_mm = cell.reflectors.front().p_FS_mm;
  session_.search().expect(std::move(cell), tracker.first_search_radius_mm / tracker.search_radius_mm);
  for (MeasuringTarget& target : targets_)
    target = session_.plan().new_target(PointPurpose::Frame, target.q_target, Replacement::Near);
  co_return co_await session_.plan().keep(targets_);
}

CampaignOutcome<void> ToolCampaign::measure() {
  const auto after_each = [this]() -> CampaignOutcome<void> {
    Done done = judge_target();
    if (done) done = co_await learn_place();
    if (done) done = co_await nests_.after_pose();
    co_return done;
  };
  co_return co_await session_.measure_all(targets_, after_each);
}

/// Few poses are enough for a 6-D target alone.
Done ToolCampaign::judge_target() {
  const bool is_6d = std::ranges::all_of(
      session_.corrected().points, [](const StoredPoint& point) { return point.orientation.has_value(); });
  if (order_.poses >= kFewestOrientations || is_6d) return {};
  return std::unexpected(
      CampaignError{CampaignFault::Planning,
                    formatted("tool %d: %d of at least %d poses are enough for a 6-D target alone, and the "
                              "tracker reported no orientation: start it with more poses, better ten",
                              order_.number, order_.poses, kFewestOrientations)});
}

/// Of each point the mean of where the readings so far have it in the flange frame; none without.
std::vector<std::optional<Eigen::Vector3d>> ToolCampaign::places_mm() {
  const FrameReadings data = readings();
  const Eigen::Isometry3d X_BW = order_.by.cell.base.isometry().inverse();
  std::vector<std::optional<Eigen::Vector3d>> places(data.points.size());
  std::vector<int> counts(data.points.size(), 0);
  for (const FrameReading& reading : data.readings) {
    const Eigen::Isometry3d X_FB = forward_kinematics(order_.by.cell.robot, reading.q).inverse();
    const Eigen::Vector3d p_F_mm = X_FB * (X_BW * *reading.p_WS_mm);
    auto& place = places[reading.point];
    place = place.value_or(Eigen::Vector3d(0, 0, 0)) + p_F_mm;
    ++counts[reading.point];
  }
  for (std::size_t i = 0; i < places.size(); ++i)
    if (places[i]) *places[i] /= counts[i];
  return places;
}

/// The first reading already says within a millimetre where the tracker has to look.
CampaignOutcome<void> ToolCampaign::learn_place() {
  const auto places = places_mm();
  const auto known = static_cast<std::size_t>(
      std::ranges::count_if(places, [](const auto& place) { return place.has_value(); }));
  // Several at once are distinguished by their shape until all were seen.
  if (known == 0 || (order_.together && known < places.size())) co_return Done{};
  CalibratedCell cell = order_.by.cell;
  cell.reflectors = config::rough_cell(session_.config()).reflectors;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (places[i]) cell.reflectors[i].p_FS_mm = *places[i];
  const bool is_new = std::exchange(known_, known) != known;
  const Eigen::Vector3d p_F_mm = cell.reflectors.front().p_FS_mm;
  session_.search().expect(std::move(cell));
  if (!is_new) co_return Done{};
  session_.progress().enter(CampaignPhase::Frame);  // from here on the deviation is from a good prediction
  const double off_mm = (p_F_mm - order_.by.cell.reflectors.front().p_FS_mm).norm();
  if (known == 1 && off_mm < kSameReflector_mm)
    session_.observer().on_trouble(formatted(
        "the reflector is within %.2f mm of the place that it was calibrated with: see that it sits at the tool",
        off_mm));
  co_return Done{};
}

FrameReadings ToolCampaign::readings() {
  std::vector<FramePoint> points;
  for (const ToolPoint& point : order_.points) points.push_back(point.point);
  FrameReadings data = frame_readings(session_.corrected().points, std::move(points));
  return order_.R_given ? without_orientations(std::move(data)) : data;
}

CampaignOutcome<void> ToolCampaign::evaluate() {
  session_.progress().enter(CampaignPhase::Compute);
  ToolResult result{.order = order_, .data = readings()};
  const bool needs_spread = order_.poses >= kFewestOrientations && !is_turned(result.data);
  const std::string why =
      needs_spread ? why_not_identifiable(result.data, session_.config().robot.model) : std::string{};
  if (!why.empty()) co_return std::unexpected(CampaignError{CampaignFault::Calibration, why});
  const Eigen::Matrix3d flange = Eigen::Matrix3d::Identity();
  auto job = [&result, &flange, this] {
    return tool_frame(result.data, order_.by, order_.R_given.value_or(flange));
  };
  auto frame = co_await session_.compute(job);
  if (!frame) co_return std::unexpected(CampaignError{CampaignFault::Calibration, frame.error()});
  result.frame = *std::move(frame);
  session_.result().findings = std::move(result);
  co_return Done{};
}

std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, ToolOrder order) {
  return std::make_unique<ToolCampaign>(session, std::move(order));
}

}  // namespace truepose::daemon
