// A tool measured by a campaign, judged by what the simulated cell really is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json/value.hpp>
#include <thread>

#include "config/frame_file.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "config/scenario.hpp"
#include "config/text_file.hpp"
#include "core/math/random.hpp"
#include "proto/control/json_text.hpp"
#include "tests/core/plain_kinematics.hpp"
#include "tests/integration/live_cell.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::HasSubstr;
using namespace std::chrono_literals;

const std::string kRobot = TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml";

class AToolCampaignOverTheRealProtocols : public testing::Test {
 protected:
  AToolCampaignOverTheRealProtocols() { cell_.start_daemon(); }

  Finished run(std::vector<std::string> words) const { return cell_.truepose(std::move(words)); }
  std::string path(const char* name) const { return cell_.folder() / name; }
  /// A hand puts the reflector to a point of the tool.
  void put_reflector_at(const Eigen::Vector3d& p_T_mm) const {
    const Eigen::Vector3d p_F_mm = plain::moved(X_FT_, p_T_mm);
    cell_.steer({{"put_reflector", {{"x", p_F_mm.x()}, {"y", p_F_mm.y()}, {"z", p_F_mm.z()}}}});
  }
  void calibrate(const char* poses) const {
    const Finished campaign =
        run({"campaign", "start", "--identify", poses, "--validate", "4", "--no-remeasure", "--watch"});
    ASSERT_EQ(campaign.exit_code, 0) << campaign.err << campaign.out;
  }
  /// Distance of the real TCP from where model and tool have it, the mean of ten orientations.
  double off_mm(const Eigen::Vector3d& p_FT_mm) const {
    const config::Scenario truth = config::load_scenario(TRUEPOSE_SOURCE_DIR "/config/scenarios/demo.yaml");
    const config::ModelFile model = config::load_model(path("model.yaml"));
    const Eigen::Vector3d p_F_mm = X_FT_.topRightCorner<3, 1>();
    Random random(11);
    double sum_mm = 0;
    for (int i = 0; i < 10; ++i) {
      JointVector q(6);
      q << random.uniform(-0.8, 0.8), random.uniform(-1.8, -1.1), random.uniform(1.3, 1.9),
          random.uniform(-1.5, 1.5), random.uniform(0.5, 1.2), random.uniform(-1.5, 1.5);
      const Eigen::Vector3d truly = truth.X_WB * plain::moved(plain::flange(truth.truth, q), p_F_mm);
      const Eigen::Vector3d said =
          model.cell.base.isometry() *
          plain::moved(plain::flange(model.cell.robot, q), model.cell.robot.X_flange * p_FT_mm);
      sum_mm += (truly - said).norm();
    }
    return sum_mm / 10;
  }
  json::value called(const std::string& method, const json::object& params = {}) const {
    auto client = cell_.client();
    auto result = client.call(method, params);
    if (!result) throw std::runtime_error{result.error().message};
    return *std::move(result);
  }

  LiveCell cell_;
  const Eigen::Matrix4d X_FT_ = plain::kuka_frame({35, -70, 265}, {15, -20, 40});
};

TEST_F(AToolCampaignOverTheRealProtocols, FindsTheTcpAndSaysOfItWhatTheCommandSaysOfItsFile) {
  calibrate("30");
  put_reflector_at({0, 0, 0});
  const Finished measured = run({"campaign", "start", "--tool", "3", "--watch"});
  ASSERT_EQ(measured.exit_code, 0) << measured.err << measured.out << cell_.daemon().errors();
  EXPECT_THAT(measured.out,
              AllOf(HasSubstr("measuring"), HasSubstr("10/10 poses"), HasSubstr("TOOL_DATA[3]={X ")));

  ASSERT_EQ(run({"model", "export", "--out", path("model.yaml")}).exit_code, 0);
  const Finished exported = run({"campaign", "export", "--data", path("tool.csv"), "--frame",
                                 path("gun.yaml"), "--document", path("tool.json")});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const Finished offline =
      run_program("truepose", {"tool", "--robot", kRobot, "--model", path("model.yaml"), "--data",
                               path("tool.csv"), "--number", "3", "--out", path("offline.yaml"), "--json"});
  ASSERT_EQ(offline.exit_code, 0) << offline.err;
  json::object online = control::parse_json(config::read_text_file(path("tool.json")))->as_object();
  EXPECT_EQ(online.at("yaml").as_string(), config::read_text_file(path("offline.yaml")));
  EXPECT_EQ(config::read_text_file(path("gun.yaml")), config::read_text_file(path("offline.yaml")));
  online.erase("yaml");
  EXPECT_EQ(control::json_text(online), control::json_text(*control::parse_json(offline.out)));

  const config::ToolFile tool = config::load_tool(path("gun.yaml"), config::load_robot(kRobot));
  const double off = off_mm(tool.X_told.translation());
  RecordProperty("tcp_off_mm", std::to_string(off));
  EXPECT_LE(off, 0.045);
  EXPECT_GT(off_mm(Eigen::Vector3d(35, -70, 266)), 0.5) << "a tool as drawn is judged by the same";

  const std::string id = std::string{called("campaign.get").at_pointer("/campaign/id").as_string()};
  EXPECT_THAT(run({"tools", "activate", id}).out, HasSubstr("tool 3 is in use as campaign " + id));
  const json::object target{{"joints", json::array(1, json::array{0, -90, 90, 0, 35, 0})}, {"tool", 3}};
  EXPECT_EQ(called("targets.compensate", target).at("joints").as_array().size(), 1U);
  EXPECT_THAT(run({"tools", "list"}).out, HasSubstr("campaign " + id));
}

TEST_F(AToolCampaignOverTheRealProtocols, AsksForTheReflectorAtEachPointOfTheTool) {
  calibrate("14");
  put_reflector_at({0, 0, 0});
  const Finished started =
      run({"campaign", "start", "--tool", "5", "--points", "origin,x,xy", "--tool-poses", "4"});
  ASSERT_EQ(started.exit_code, 0) << started.err;
  const auto wait_until = [this](const std::string& text) {
    for (int n = 0; n < 3000; ++n, std::this_thread::sleep_for(100ms))
      if (const json::value status = called("cell.status");
          json::serialize(status).find(text) != std::string::npos)
        return;
    FAIL() << json::serialize(called("cell.status"));
  };
  wait_until("put the reflector at point \\\"x\\\" of tool 5");
  put_reflector_at({110, 0, 0});
  ASSERT_EQ(run({"campaign", "resume"}).exit_code, 0);
  wait_until("put the reflector at point \\\"xy\\\" of tool 5");
  put_reflector_at({-15, 90, 0});
  ASSERT_EQ(run({"campaign", "resume"}).exit_code, 0);
  wait_until("\"state\":\"ready\"");
  ASSERT_EQ(run({"campaign", "export", "--frame", path("gun.yaml")}).exit_code, 0);
  const config::ToolFile tool = config::load_tool(path("gun.yaml"), config::load_robot(kRobot));
  EXPECT_LT(plain::mm_between(tool.X_told.matrix(), X_FT_), 1) << "as turned as the model has its flange";
  EXPECT_LT(plain::rad_between(tool.X_told.matrix(), X_FT_), 0.01);
}

}  // namespace
}  // namespace truepose
