#include "tests/daemon/example_cell.hpp"

#include <array>
#include <utility>

#include "core/math/angles.hpp"

namespace truepose::test {

namespace asio = boost::asio;

namespace {

struct Link {
  double a_mm, alpha_deg, d_mm, theta_deg, sign, min_deg, max_deg, speed_deg_s;
};
constexpr std::array<Link, 6> kNominal{{{0, 0, 645, 0, -1, -185, 185, 117},
                                        {330, -90, 0, 0, 1, -140, -5, 112},
                                        {1150, 0, 0, -90, 1, -120, 168, 112},
                                        {115, -90, 1220, 0, -1, -350, 350, 172},
                                        {0, 90, 0, 0, 1, -125, 125, 160},
                                        {0, -90, 215, 180, -1, -350, 350, 219}}};

struct LinkError {
  double a_mm, alpha_rad, d_mm, theta_rad, beta_rad;
};
constexpr std::array<LinkError, 6> kErrors{{{0.45, 0.003, 0.72, 0.0015, 0},
                                            {0.63, 0.002, 0.43, 0.0032, 0},
                                            {0.55, 0.003, 0.21, 0.0026, 0.001},
                                            {0.32, 0.006, 0.32, 0.0018, 0},
                                            {0.72, 0.004, 0.51, 0.0012, 0},
                                            {0.23, 0.005, 0.62, 0.0022, 0}}};

}  // namespace

RobotModel kr210() {
  RobotModel robot;
  robot.name = "KUKA KR 210 R2700-2";
  for (const Link& link : kNominal) {
    Joint joint;
    joint.a_mm = link.a_mm;
    joint.alpha_rad = link.alpha_deg * kRadPerDeg;
    joint.d_mm = link.d_mm;
    joint.theta_rad = link.theta_deg * kRadPerDeg;
    joint.sign = link.sign;
    joint.min = link.min_deg * kRadPerDeg;
    joint.max = link.max_deg * kRadPerDeg;
    joint.speed = link.speed_deg_s * kRadPerDeg;
    robot.joints.push_back(joint);
  }
  return robot;
}

RobotModel kr210_with_errors() {
  RobotModel robot = kr210();
  for (std::size_t i = 0; i < kErrors.size(); ++i) {
    robot.joints[i].a_mm += kErrors[i].a_mm;
    robot.joints[i].alpha_rad += kErrors[i].alpha_rad;
    robot.joints[i].d_mm += kErrors[i].d_mm;
    robot.joints[i].theta_rad += kErrors[i].theta_rad;
    robot.joints[i].beta_rad += kErrors[i].beta_rad;
  }
  return robot;
}

config::CellConfig example_cell() {
  config::CellConfig cell;
  cell.name = "example";
  cell.robot.model = kr210();
  cell.robot.expect_model = "KR210R2700_2";
  // The tracker's head stands 4 m before the arm and 1.4 m above its base, and looks back at it.
  cell.tracker.robot_base = pose_from_kuka({4000, 0, -1400}, {180, 0, 0});
  cell.reflector.p_FS_mm = {80, 40, 60};
  cell.campaign.identify_poses = 16;
  cell.campaign.validate_poses = 12;
  cell.campaign.seed = 7;
  cell.campaign.reference_every = 0;  // so that poses are easily counted; who tests the reference sets it
  cell.campaign.candidates = 120;     // planning is tested elsewhere, and takes the longest under a sanitizer
  return cell;
}

drivers::MockCellOptions example_truth() {
  const config::CellConfig cell = example_cell();
  drivers::MockCellOptions truth;
  truth.nominal = kr210();
  truth.truth.robot = kr210_with_errors();
  truth.truth.X_WB = cell.tracker.robot_base * pose_from_kuka({35, -28, 17}, {0.4, -0.3, 0.5});
  truth.truth.p_FS_mm = cell.reflector.p_FS_mm + Eigen::Vector3d{4, -3, 2};
  truth.truth.facing_F = cell.reflector.facing_F;
  // The cone of a real reflector is wider than the one that is planned with.
  truth.truth.acceptance_rad = (cell.reflector.acceptance_deg + 3) * kRadPerDeg;
  truth.truth.repeatability_mm = 0.0166;
  truth.noise.range_mm = truth.noise.transverse_mm = 0.01;
  truth.q_start = JointVector::Zero(6);
  truth.q_start << 0, -90, 90, 0, 0, 0;
  truth.q_start *= kRadPerDeg;
  return truth;
}

asio::awaitable<daemon::StoreResult<std::string>> MemoryJournal::begin(int total) {
  ++begun;
  plan.total = total;
  co_return std::string{"2026-02-03T08:00:00Z"};
}

asio::awaitable<daemon::StoreResult<void>> MemoryJournal::know(daemon::Identities identities) {
  serial = identities.robot.serial;
  co_return daemon::StoreResult<void>{};
}

asio::awaitable<daemon::StoreResult<void>> MemoryJournal::add_planned(std::vector<daemon::PlannedPose> poses,
                                                                      int total) {
  plan.poses.insert(plan.poses.end(), poses.begin(), poses.end());
  plan.total = total;
  co_return daemon::StoreResult<void>{};
}

asio::awaitable<daemon::StoreResult<void>> MemoryJournal::add_identified(std::string sha256) {
  plan.identified = sha256;
  co_return daemon::StoreResult<void>{};
}

asio::awaitable<daemon::StoreResult<void>> MemoryJournal::add_resumption(daemon::Resumption resumption) {
  resumptions.push_back(resumption);
  co_return daemon::StoreResult<void>{};
}

std::shared_ptr<const daemon::CampaignPast> MemoryJournal::past() const {
  auto past = std::make_shared<daemon::CampaignPast>();
  past->record.robot_serial = serial;
  past->record.ended = "2026-02-03T07:30:00Z";
  past->plan = plan;
  past->points = points;
  past->skipped = skipped;
  past->resumptions = resumptions;
  return past;
}

asio::awaitable<daemon::StoreResult<daemon::StoredPoint>> MemoryJournal::add_point(
    daemon::StoredPoint point) {
  if (at_point) at_point(point);
  points.push_back(point);
  co_return point;
}

asio::awaitable<daemon::StoreResult<void>> MemoryJournal::add_skipped(daemon::SkippedPose pose) {
  skipped.push_back(pose);
  co_return daemon::StoreResult<void>{};
}

asio::awaitable<daemon::StoreResult<void>> MemoryJournal::end(
    std::shared_ptr<const daemon::CampaignResult> campaign_result,
    std::optional<daemon::CampaignError> campaign_error) {
  ++ended;
  result = std::move(campaign_result);
  error = std::move(campaign_error);
  co_return daemon::StoreResult<void>{};
}

void RecordingObserver::on_point(const daemon::StoredPoint& point, double deviation_mm,
                                 const daemon::CampaignProgress& progress) {
  deviations_mm.push_back(deviation_mm);
  last = progress;
  if (at_point) at_point(point);
}

void RecordingObserver::on_skipped(const daemon::StoredPoint& wanted, const std::string&,
                                   const daemon::CampaignProgress& progress) {
  given_up.push_back(wanted);
  last = progress;
}

asio::awaitable<void> compute_here(std::function<void()> job) {
  job();
  co_return;
}

}  // namespace truepose::test
