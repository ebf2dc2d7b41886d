#include "tools/sim/simulated_cell.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/arm/forward.hpp"
#include "drivers/clock.hpp"
#include "drivers/kuka/eki_robot.hpp"
#include "drivers/leica/emscon_tracker.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "tests/simulator_process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/sim/kr210.hpp"

namespace truepose::sim {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;

constexpr std::uint64_t kCellSeed = 20261121;

config::Scenario demo() { return config::load_scenario(TRUEPOSE_SOURCE_DIR "/config/scenarios/demo.yaml"); }

rsi::EthernetConfig shipped_ethernet() {
  return rsi::parse_ethernet_config(text_of(TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml"))
      .value();
}

/// What a cell runs on, in real time or in virtual time.
template <class Time>
struct World {
  Time clock;
  asio::io_context io{1};
  const Machine machine{.io = io.get_executor(), .clock = clock};
};
using RealWorld = World<drivers::SteadyClock>;

/// A scenario, moved and measured by the real drivers over loopback, faster than life.
class Cell {
 public:
  explicit Cell(std::uint64_t seed, config::Scenario what = demo())
      : scenario{std::move(what)}, cell_{world_.machine, scenario, shipped_ethernet(), options(seed)} {}

  template <class T>
  T run(asio::awaitable<T> call) {
    std::optional<T> result;
    std::exception_ptr thrown;
    asio::co_spawn(world_.io, std::move(call), [&](std::exception_ptr error, T value) {
      thrown = error;
      result = std::move(value);
    });
    while (!result) world_.io.run_one();
    if (thrown) std::rethrow_exception(thrown);
    return *std::move(result);
  }

  static drivers::TimePoint soon() { return std::chrono::steady_clock::now() + 60s; }

  void connect() {
    EXPECT_EQ(run(robot.connect(soon())).value().serial, std::to_string(scenario.robot_serial));
    EXPECT_TRUE(run(tracker.connect(soon())));
  }

  void move(const JointVector& q) {
    const auto reached = run(robot.move({.q = q, .speed_percent = 100}, soon()));
    ASSERT_TRUE(reached) << reached.error().detail;
    EXPECT_TRUE(reached->isApprox(q, 1e-6));
  }

  /// Where the reflector truly is, but for repeatability.
  Eigen::Vector3d truth(const JointVector& q, const RobotModel& robot_model) const {
    return scenario.X_WB * (forward_kinematics(robot_model, q) * scenario.p_FS_mm);
  }

  auto aim(const JointVector& q) { return run(tracker.aim(truth(q, scenario.nominal), 30, soon())); }

  Eigen::Vector3d measured(const JointVector& q) {
    move(q);
    EXPECT_TRUE(aim(q));
    return run(tracker.measure(soon())).value().p_WS_mm;
  }

  CellStatistics statistics() const { return cell_.statistics(); }
  void begin(const config::ScenarioFault& fault) { cell_.begin(fault); }

  const config::Scenario scenario;

 private:
  static CellOptions options(std::uint64_t seed) {
    CellOptions options;
    options.rsi_host = "127.0.0.1";
    options.rsi_port = 9;  // nobody listens
    options.seed = seed;
    options.speedup = 500;
    return options;
  }

  RealWorld world_;
  SimulatedCell cell_;

 public:
  drivers::KukaEkiRobot robot{
      world_.machine.io,
      world_.clock,
      {.host = "127.0.0.1", .motion_port = cell_.ports().eki, .state_port = cell_.ports().eki_state}};
  drivers::EmsconTracker tracker{
      world_.machine.io, world_.clock, {.host = "127.0.0.1", .port = cell_.ports().tracker}};
};

/// Poses that the tracker sees, or that it does not.
std::vector<JointVector> poses(std::size_t count, bool seen) {
  const config::Scenario scenario = demo();
  const TrueArm arm{{.robot = scenario.truth,
                     .X_WB = scenario.X_WB,
                     .p_FS_mm = scenario.p_FS_mm,
                     .facing_F = scenario.facing_F,
                     .acceptance_rad = (seen ? 0.9 : 1.1) * scenario.acceptance_deg * kRadPerDeg},
                    0};
  std::vector<JointVector> poses;
  Random random{kCellSeed};
  while (poses.size() < count) {
    JointVector q(6);
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Joint& joint = scenario.nominal.joints[static_cast<std::size_t>(i)];
      q[i] = joint.min + random.uniform() * (joint.max - joint.min);
    }
    if (arm.visible(q) == seen) poses.push_back(q);
  }
  return poses;
}

TEST(SimulatedCell, LeavesAJointWithPlayBehindWhereItCameFrom) {
  RecordProperty("seed", static_cast<int>(kCellSeed));
  constexpr double kPlay_rad = 0.02 * kRadPerDeg;
  config::Scenario loose = demo();
  loose.drives.drives.resize(6, {.backlash_rad = kPlay_rad});
  Cell cell{kCellSeed, loose};
  cell.connect();
  const JointVector q = poses(1, true).front(), ones = JointVector::Ones(6);
  const auto come_from = [&](double side_rad) {
    cell.move(q + side_rad * ones);
    return cell.measured(q);
  };
  come_from(0.05);  // the first motion knows no direction
  const Eigen::Vector3d difference_mm = come_from(-0.05) - come_from(0.05);
  const Eigen::Vector3d expected_mm = cell.truth(q - kPlay_rad / 2 * ones, cell.scenario.truth) -
                                      cell.truth(q + kPlay_rad / 2 * ones, cell.scenario.truth);
  EXPECT_GT(expected_mm.norm(), 0.5);
  EXPECT_LT((difference_mm - expected_mm).norm(), 0.12) << "noise and repeatability";
}

TEST(SimulatedCell, MeasuresTheArmAsItIsAndNotAsItsDataSheetSays) {
  RecordProperty("seed", static_cast<int>(kCellSeed));
  Cell cell{kCellSeed};
  cell.connect();
  const std::vector<JointVector> visited = poses(5, true);
  for (const JointVector& q : visited) {
    const Eigen::Vector3d p_mm = cell.measured(q);
    // Six standard deviations of repeatability and tracker noise together, per axis.
    EXPECT_LT((p_mm - cell.truth(q, cell.scenario.truth)).cwiseAbs().maxCoeff(), 6 * 0.0194);
    EXPECT_GT((p_mm - cell.truth(q, cell.scenario.nominal)).norm(), 0.5);
  }
  EXPECT_EQ(cell.statistics().moves, visited.size());
  EXPECT_EQ(cell.statistics().measurements, visited.size());
}

TEST(SimulatedCell, IsMeasuredByATrackerThatIsPushedLooseOrWrongAtItsPoints) {
  RecordProperty("seed", static_cast<int>(kCellSeed));
  using Fault = config::ScenarioFault;
  config::Scenario spoilt = demo();
  const auto at_point = [](Fault::Kind kind, std::int64_t at, std::int64_t lasts) {
    return Fault{.kind = kind, .unit = Fault::Unit::Points, .at = at, .lasts = lasts};
  };
  Fault push = at_point(Fault::Kind::TrackerBump, 2, 0);
  push.by_mm = {3, 0, 4};
  Fault bias = at_point(Fault::Kind::TrackerBias, 3, 1);
  bias.by_mm = {0, 2, 0};
  Fault loose = at_point(Fault::Kind::TrackerNoise, 4, 1);
  loose.sigma_mm = 3;
  Fault odd = at_point(Fault::Kind::TrackerStd, 5, 1);
  odd.std_mm = -1;
  Fault cold = at_point(Fault::Kind::TrackerAir, 5, 1);
  cold.temperature_c = -273;
  spoilt.faults = {push, bias, loose, odd, cold};
  Cell cell{kCellSeed, spoilt};
  cell.connect();
  const JointVector q = poses(1, true).front();
  cell.move(q);
  const Eigen::Vector3d truth = cell.truth(q, cell.scenario.truth);
  std::vector<drivers::SmrPoint> points;
  for (int i = 0; i < 6; ++i) {
    ASSERT_TRUE(cell.aim(q));
    const auto measured = cell.run(cell.tracker.measure(Cell::soon()));
    EXPECT_EQ(measured.has_value(), i != 4) << "what cannot be is refused";
    points.push_back(measured.value_or(drivers::SmrPoint{}));
  }
  const Eigen::Vector3d pushed{3, 0, 4}, biased{0, 2, 0};
  EXPECT_LT((points[0].p_WS_mm - truth).norm(), 0.2);
  EXPECT_LT((points[1].p_WS_mm - truth - pushed).norm(), 0.2);
  EXPECT_LT((points[2].p_WS_mm - truth - pushed - biased).norm(), 0.2);
  EXPECT_GT(points[3].std_mm.norm(), 1) << "its own scatter shows it";
  EXPECT_LT((points[5].p_WS_mm - truth - pushed).norm(), 0.2) << "who was pushed stays where he is";
  EXPECT_LT(points[5].std_mm.norm(), 0.1);
}

TEST(SimulatedCell, PushesItsTrackerOnRequest) {
  RecordProperty("seed", static_cast<int>(kCellSeed));
  Cell cell{kCellSeed};
  cell.connect();
  const JointVector q = poses(1, true).front();
  const Eigen::Vector3d before_mm = cell.measured(q);
  cell.begin(config::parse_fault("{kind: tracker-bump, by_mm: {x: 3, y: 0, z: 4}}"));
  EXPECT_LT((cell.measured(q) - before_mm - Eigen::Vector3d(3, 0, 4)).norm(), 0.2);
}

TEST(SimulatedCell, SetsItsOverrideBackAfterTheTimeThatAFaultLasts) {
  Cell cell{kCellSeed};
  cell.connect();
  const auto override_percent = [&] {
    return cell.run(cell.robot.state(Cell::soon())).value().override_percent;
  };
  const double before = override_percent();
  cell.begin(config::parse_fault("{kind: override, percent: 30, lasts_ms: 100000}"));
  EXPECT_EQ(override_percent(), 30);
  int asked = 0;
  while (override_percent() == 30 && asked < 5000) ++asked;
  EXPECT_EQ(override_percent(), before);
}

TEST(SimulatedCell, RefusesASendListThatItCannotServe) {
  rsi::EthernetConfig ethernet = shipped_ethernet();
  ethernet.send.push_back({"DEF_Nonsense", rsi::ElementType::Double, std::nullopt});
  RealWorld world;
  const CellOptions options{.rsi_host = "127.0.0.1", .rsi_port = 9};
  EXPECT_THROW((SimulatedCell{world.machine, demo(), ethernet, options}), std::invalid_argument);
}

/// A controller with a channel and a program of its own, and without the files that truepose ships.
config::Scenario cell_of_its_own(const TempFolder& folder, const std::string& program) {
  std::filesystem::create_directories(folder.path() / "files/eki");
  std::filesystem::create_directories(folder.path() / "files/krl");
  folder.write("files/eki/Sensor.xml",
               "<ETHERNETKRL><CONFIGURATION><EXTERNAL><TYPE>Client</TYPE></EXTERNAL><INTERNAL>"
               "<PORT>0</PORT></INTERNAL></CONFIGURATION></ETHERNETKRL>");
  folder.write("files/krl/part.src", "DEF PART()\nDECL EKI_STATUS RET\n" + program + "END\n");
  config::Scenario scenario = demo();
  scenario.controller_files = folder.path() / "files";
  scenario.programs.clear();
  scenario.selected = "PART";
  return scenario;
}

TEST(SimulatedCell, OpensTheChannelsThatItsProgramsNameWithoutTrueposesOwn) {
  const TempFolder folder;
  RealWorld world;
  const CellOptions options{.rsi_host = "127.0.0.1", .rsi_port = 9};
  SimulatedCell cell{world.machine,
                     cell_of_its_own(folder, "RET=EKI_Init(\"Sensor\")\nRET=EKI_Open(\"Sensor\")\nHALT\n"),
                     shipped_ethernet(), options};
  EXPECT_EQ(cell.ports().eki, 0);
  EXPECT_EQ(cell.ports().eki_state, 0);
  ASSERT_EQ(cell.ports().others.size(), 1U);
  EXPECT_EQ(cell.ports().others[0].channel, "Sensor");
  asio::ip::tcp::socket client{world.io};
  client.connect({asio::ip::address_v4::loopback(), cell.ports().others[0].port});
  EXPECT_TRUE(client.is_open());
}

TEST(SimulatedCell, RefusesAProgramThatNamesAChannelOfTrueposeWithoutItsFile) {
  const TempFolder folder;
  RealWorld world;
  const CellOptions options{.rsi_host = "127.0.0.1", .rsi_port = 9};
  EXPECT_THROW((SimulatedCell{world.machine, cell_of_its_own(folder, "RET=EKI_Init(\"CellLink\")\n"),
                              shipped_ethernet(), options}),
               std::invalid_argument);
}

TEST(SimulatedCell, RunsTheContextThatItsProgramNames) {
  for (const std::string name : {"Sensor", "Sensor.rsi", "Other"}) {
    const TempFolder folder;
    RealWorld world;
    const CellOptions options{.rsi_host = "127.0.0.1", .rsi_port = 9, .speedup = 500};
    config::Scenario scenario = cell_of_its_own(
        folder, "DECL INT ID\nIF RSI_CREATE(\"" + name +
                    "\",ID,TRUE)<>RSIOK THEN\nHALT\nENDIF\n"
                    "IF RSI_ON(#ABSOLUTE,#IPO_FAST)<>RSIOK THEN\nHALT\nENDIF\nRSI_MOVECORR()\n");
    scenario.operator_s = 1e6;
    std::filesystem::create_directories(folder.path() / "files/rsi");
    folder.write("files/rsi/Sensor.rsi.xml",
                 rsi::context_xml(rsi::truepose_context({}), rsi::ContextFormat::RsiXml));
    SimulatedCell cell{world.machine, std::move(scenario), shipped_ethernet(), options};
    const bool is_there = name != "Other";
    EXPECT_EQ(cell.statistics().rsi.sessions, is_there ? 1U : 0U) << name;
    EXPECT_EQ(cell.program().state, is_there ? eki::ProgramState::Active : eki::ProgramState::Stopped)
        << name;
  }
}

TEST(SimulatedCell, ReplaysItsPointsFromTheSeed) {
  Cell one{kCellSeed}, again{kCellSeed}, other{kCellSeed + 1};
  std::vector<std::vector<Eigen::Vector3d>> points;
  for (Cell* cell : {&one, &again, &other}) {
    cell->connect();
    points.emplace_back();
    for (const JointVector& q : poses(3, true)) points.back().push_back(cell->measured(q));
  }
  EXPECT_EQ(points[0], points[1]);
  EXPECT_NE(points[0], points[2]);
}

TEST(SimulatedCell, HidesAReflectorThatIsTurnedAway) {
  Cell cell{kCellSeed};
  cell.connect();
  const JointVector away = poses(1, false).front();
  cell.move(away);
  const auto found = cell.aim(away);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().fault, drivers::TrackerFault::NoTarget);
}

TEST(SimulatedCell, StopsWithATimeoutWhenNobodyAnswersItsRsiDatagrams) {
  Cell cell{kCellSeed};
  cell.connect();
  ASSERT_TRUE(cell.run(cell.robot.start_stream_program(Cell::soon())));
  while (cell.statistics().rsi.timeouts == 0) {
    EXPECT_TRUE(cell.run(cell.robot.state(Cell::soon())));
  }
  const RsiCounters counters = cell.statistics().rsi.counters;
  EXPECT_EQ(counters.cycles, 100u);
  EXPECT_EQ(counters.lost, 100u);
  EXPECT_EQ(counters.max_step_rad, 0);
  cell.measured(poses(1, true).front());  // and the arm can be moved again
}

/// A cell whose loop runs in virtual time. Its servers listen, and have no clients.
class SimulatedCellInVirtualTime : public testing::Test {
 protected:
  SimulatedCell& start(config::Scenario scenario) {
    const CellOptions options{.rsi_host = "127.0.0.1", .rsi_port = 9};
    return cell_.emplace(world_.machine, std::move(scenario), shipped_ethernet(), options);
  }
  /// @return when its program came to be in this state, since the start; nothing: never
  std::optional<drivers::Duration> time_of(eki::ProgramState state) {
    const bool came = world_.clock.run(world_.io, [&] {
      return cell_->program().state == state || world_.clock.now() > drivers::TimePoint{2h};
    });
    if (!came || cell_->program().state != state) return std::nullopt;
    return world_.clock.now().time_since_epoch();
  }

 private:
  World<drivers::VirtualClock> world_;
  std::optional<SimulatedCell> cell_;
};

TEST_F(SimulatedCellInVirtualTime, LivesThroughAFaultAfterAnHour) {
  const TempFolder folder;
  config::Scenario scenario = cell_of_its_own(folder, "LOOP\nWAIT SEC 1\nENDLOOP\n");
  scenario.faults = {{.kind = config::ScenarioFault::Kind::ProgramStop, .at = 3'600'000, .lasts = 60'000}};
  EXPECT_EQ(start(std::move(scenario)).program().state, eki::ProgramState::Active);
  EXPECT_EQ(time_of(eki::ProgramState::Stopped), 60min);
  EXPECT_EQ(time_of(eki::ProgramState::Active), 61min);
}

TEST_F(SimulatedCellInVirtualTime, HasItsProgramStartedAgainAfterHalt) {
  const TempFolder folder;
  config::Scenario scenario = cell_of_its_own(folder, "HALT\nHALT\nWAIT SEC 0.1\n");
  scenario.operator_s = 3;
  EXPECT_EQ(start(std::move(scenario)).program().state, eki::ProgramState::Stopped);
  const auto ended = time_of(eki::ProgramState::Ended);
  ASSERT_TRUE(ended) << "past both HALTs";
  EXPECT_GE(*ended, 6100ms);
  EXPECT_LT(*ended, 6200ms);
}

}  // namespace
}  // namespace truepose::sim
