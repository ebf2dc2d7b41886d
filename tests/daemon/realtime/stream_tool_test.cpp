#include <boost/json/value_to.hpp>

#include "config/model_file.hpp"
#include "core/arm/forward.hpp"
#include "tests/daemon/watched_stream.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using testing::HasSubstr;
using namespace std::chrono_literals;

/// Tool 3 as the tracker saw it, 1 mm off the controller's value.
config::ToolFile displaced_tool(const CalibratedCell& model) {
  config::ToolFile tool{.number = 3, .arm = model.robot.name, .data = {.points = {{kOrigin, {}}}}};
  tool.X_controller.translation() = Eigen::Vector3d(40, -30, 250);
  const Eigen::Vector3d p_F_mm = tool.X_controller.translation() + Eigen::Vector3d(1, 0, 0);
  for (int i = 0; i < 10; ++i) {
    JointVector q(6);
    q << 0.1 * i, -1.4, 1.6, 0.2 * i, 0.8, -0.1 * i;
    const Eigen::Isometry3d X_WF = model.base.isometry() * forward_kinematics(model.robot, q);
    tool.data.readings.push_back({.q = q, .p_WS_mm = X_WF * p_F_mm});
  }
  return tool;
}

struct AToolInTheStream : AWatchedStream {
  AToolInTheStream() { config.tools = {displaced_tool(model)}; }
  Wait activated() {
    json::object params;
    params["id"] = "m1";
    auto answer = co_await ask("model.activate", params);
    EXPECT_TRUE(answer) << answer.error().message;
  }
  /// As the submit program names it by RSI; 0: none.
  void use_by_rsi(std::int64_t tool) {
    constexpr std::int64_t kTool = 4, kTools = 256;
    std::int64_t& word = *rig.program.cell;
    word = word / (kTool * kTools) * kTool * kTools + kTool * tool;
  }
  /// What the stream has the controller apply, deg.
  Eigen::VectorXd applied_deg() const { return rig.applied * kDegPerRad; }
  /// The same by targets.compensate.
  asio::awaitable<Eigen::VectorXd> wanted_deg(std::optional<int> tool = {}) {
    json::object params;
    if (tool) params["tool"] = *tool;
    json::array q_deg;
    for (const double rad : rig.q) q_deg.emplace_back(rad * kDegPerRad);
    json::array& joints = params["joints"].emplace_array();
    joints.push_back(q_deg);
    const Answer answer = co_await ask("targets.compensate", params);
    const auto deg = json::value_to<std::vector<double>>(answer->at_pointer("/joints/0"));
    co_return Eigen::Map<const Eigen::VectorXd>(deg.data(), 6) - Eigen::VectorXd(rig.q * kDegPerRad);
  }
  CalibratedCell model = config::parse_model((*store->model("m1"))->yaml, "m1").cell;
};

TEST_F(AToolInTheStream, IsWhatIsCorrectedWhileTheControllerHasItInForce) {
  play([this]() -> Wait {
    co_await streaming();
    auto now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/tool/number"), nullptr);
    EXPECT_FALSE(now->at_pointer("/tool/measured").as_bool());
    auto without = co_await wanted_deg();
    EXPECT_LT((applied_deg() - without).norm(), 1e-3);

    mock.use_tool(3);
    co_await pass(5s);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/tool/number"), 3);
    EXPECT_TRUE(now->at_pointer("/tool/measured").as_bool());
    auto with = co_await wanted_deg(3);
    EXPECT_LT((applied_deg() - with).norm(), 1e-3);
    EXPECT_GT((with - without).norm(), 0.01) << "1 mm of the tool is a turn of the arm";

    mock.use_tool(4);
    co_await pass(5s);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/tool/number"), 4);
    EXPECT_FALSE(now->at_pointer("/tool/measured").as_bool());
    EXPECT_LT((applied_deg() - without).norm(), 1e-3);
  });
}

TEST_F(AToolInTheStream, IsCorrectedAsTheControllerHasItAndWhereThatIsAnotherFrameThatIsAFinding) {
  play([this]() -> Wait {
    mock.use_tool(3, std::array{40.0, -30.0, 250.0, 0.0, 0.0, 0.0});
    co_await streaming();
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "") << "the line was typed";
    mock.use_tool(3, std::array{40.0, -30.0, 258.0, 0.0, 0.0, 0.0});
    co_await pass(5s);
    auto now = co_await ask("cell.status");
    EXPECT_THAT(fault_of(*now), HasSubstr("the controller's frame of tool 3 is 8.000 mm from the "
                                          "measured one"));
    EXPECT_EQ(now->at_pointer("/stream/robot/tool_frame/2").to_number<double>(), 258);
    const Eigen::Vector3d wanted =
        forward_kinematics(config.robot.model, rig.q) * Eigen::Vector3d(40, -30, 258);
    const Eigen::Vector3d made =
        forward_kinematics(model.robot, rig.q + rig.applied) * Eigen::Vector3d(41, -30, 250);
    EXPECT_LT((made - wanted).norm(), 0.05) << "where the program's own frame has the TCP";
    mock.use_tool(3, std::array{40.0, -30.0, 250.0, 0.0, 0.0, 0.0});
    co_await pass(5s);
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
    mock.use_tool({});
    co_await pass(5s);
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
  });
}

TEST_F(AToolInTheStream, IsComparedWithTheControllersFrameAsSoonAsRsiNamesIt) {
  play([this]() -> Wait {
    rig.program = {.state = 3, .mode = 4, .override_percent = 100, .cell = 1024};
    counts = true;
    co_await streaming();
    // Without a question at once the state server is asked once in a second.
    for (int change = 0; change < 5; ++change) {
      use_by_rsi(3);
      mock.use_tool(3, std::array{40.0, -30.0, 258.0, 0.0, 0.0, 0.0});
      co_await pass(110ms);
      EXPECT_THAT(fault_of(*co_await ask("cell.status")), HasSubstr("is 8.000 mm from the"));
      use_by_rsi(0);
      mock.use_tool({});
      co_await pass(110ms);
      EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
    }
  });
}

TEST_F(AToolInTheStream, HasTheControllersOrientationWhereItsTcpAloneWasMeasured) {
  play([this]() -> Wait {
    mock.use_tool(3, std::array{40.0, -30.0, 250.0, 30.0, -20.0, 75.0});
    co_await streaming();
    co_await pass(5s);
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
    auto with = co_await wanted_deg(3);
    EXPECT_LT((applied_deg() - with).norm(), 1e-3) << "the orientation of a frame on the tool moves nothing";
  });
}

TEST_F(AToolInTheStream, IsNamedAsTheCauseWhereTheControllersFrameIsOutOfReachOfAnyCorrection) {
  play([this]() -> Wait {
    mock.use_tool(3, std::array{0.0, 0.0, 0.0, 0.0, 0.0, 0.0});
    EXPECT_TRUE(co_await ask("stream.start"));
    co_await pass(5s);
    const auto now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "fault");
    EXPECT_THAT(fault_of(*now),
                HasSubstr("the correction is out of reach: the controller's frame of tool 3 is "));
  });
}

TEST_F(AToolInTheStream, HasTheFrameThatItHadLastUntilTheControllerNamesOneWithoutAFinding) {
  play([this]() -> Wait {
    mock.use_tool(3, std::array{40.0, -30.0, 258.0, 0.0, 0.0, 0.0});
    co_await streaming();
    const Eigen::VectorXd with_frame_deg = applied_deg();
    mock.use_tool({});
    co_await pass(5s);
    mock.use_tool(3);
    co_await pass(5s);
    EXPECT_LT((applied_deg() - with_frame_deg).norm(), 1e-3);
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "") << "the frame may have been typed since";
  });
}

TEST_F(AToolInTheStream, IsTheCellFilesWhereThatNamesOne) {
  config.stream.tool = 3;
  play([this]() -> Wait {
    mock.use_tool(4);
    co_await activated();
    co_await streaming();
    const auto now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/tool/number"), 3);
    auto with = co_await wanted_deg(3);
    EXPECT_LT((applied_deg() - with).norm(), 1e-3);
  });
}

TEST_F(AToolInTheStream, WhoseReadingsTheModelDoesNotBearOutIsAWarningAndNotCorrected) {
  *config.tools[0].data.readings[4].p_WS_mm += Eigen::Vector3d(3, 0, 0);
  play([this]() -> Wait {
    mock.use_tool(3);
    co_await streaming();
    const auto now = co_await ask("cell.status");
    EXPECT_FALSE(now->at_pointer("/stream/tool/measured").as_bool());
    EXPECT_THAT(fault_of(*now), HasSubstr("tool 3: its readings contradict each other under this model"));
  });
}

TEST_F(AToolInTheStream, ThatWasNotMeasuredIsNoTargetsTool) {
  EXPECT_THAT(refused("targets.compensate", {{"poses", {{1500, 0, 1200, 0, 90, 0}}}, {"tool", 4}}),
              HasSubstr("params.tool: no tool of this number was measured and taken into use"));
}

}  // namespace
}  // namespace truepose::daemon
