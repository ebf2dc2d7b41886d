// A tool measured by a campaign, judged by what the simulated cell really is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <random>

#include "config/frame_file.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "config/text_file.hpp"
#include "core/simulate/published_arm.hpp"
#include "proto/control/json_text.hpp"
#include "tests/await.hpp"
#include "tests/core/plain_kinematics.hpp"
#include "tests/daemon/jogging_hand.hpp"
#include "tests/integration/live_cell.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::HasSubstr;

const std::string kRobot = TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml";
// Of config/scenarios/demo.yaml.
const Eigen::Matrix4d kX_WB = plain::kuka_frame({3387.4, 452.8, -1251.6}, {164.82, 0.37, -0.24});

class AToolCampaignOverTheRealProtocols : public testing::Test {
 protected:
  AToolCampaignOverTheRealProtocols()
      : AToolCampaignOverTheRealProtocols(LiveCell::Options{.speedup = 1000}) {}
  explicit AToolCampaignOverTheRealProtocols(const LiveCell::Options& options) : cell_{options} {
    cell_.start_daemon();
  }

  Finished run(std::vector<std::string> words) const { return cell_.truepose(std::move(words)); }
  std::string path(const char* name) const { return cell_.folder() / name; }
  /// A hand puts the reflector to a point of the tool.
  void put_reflector_at(const Eigen::Vector3d& p_T_mm) const {
    const Eigen::Vector3d p_F_mm = plain::moved(X_FT_, p_T_mm);
    cell_.steer({{"put_reflector", {{"x", p_F_mm.x()}, {"y", p_F_mm.y()}, {"z", p_F_mm.z()}}}});
  }
  void calibrate(const char* poses) const {
    const Finished campaign =
        run({"campaign", "start", "--identify", poses, "--validate", "6", "--no-remeasure", "--watch"});
    ASSERT_EQ(campaign.exit_code, 0) << campaign.err << campaign.out;
  }
  /// Distance of the real TCP from where model and tool have it, the mean of ten orientations.
  double off_mm(const Eigen::Vector3d& p_FT_mm) const {
    const RobotModel truth = with_published_errors(config::load_robot(kRobot));
    const config::ModelFile model = config::load_model(path("model.yaml"));
    const Eigen::Vector3d p_F_mm = X_FT_.topRightCorner<3, 1>();
    std::mt19937_64 random{11};
    const auto between = [&](double least, double most) {
      return std::uniform_real_distribution{least, most}(random);
    };
    double sum_mm = 0;
    for (int i = 0; i < 10; ++i) {
      JointVector q(6);
      for (Eigen::Index k = 0; k < 6; ++k) {
        constexpr std::array kMiddle{0.0, -1.45, 1.6, 0.0, 0.85, 0.0}, kHalf{0.8, 0.35, 0.3, 1.5, 0.35, 1.5};
        const auto n = static_cast<std::size_t>(k);
        q[k] = between(kMiddle[n] - kHalf[n], kMiddle[n] + kHalf[n]);
      }
      const Eigen::Vector3d truly = plain::moved(kX_WB * plain::flange(truth, q), p_F_mm);
      const Eigen::Vector3d in_base =
          plain::moved(plain::flange(model.cell.robot, q), model.cell.robot.X_flange * p_FT_mm);
      sum_mm += (truly - model.cell.base.isometry() * in_base).norm();
    }
    return sum_mm / 10;
  }
  void wait_until(const std::string& text) const {
    const auto status = [this] { return json::serialize(called("cell.status")); };
    await(
        "cell.status says " + text, [&] { return status().find(text) != std::string::npos; }, status);
  }
  /// That campaign and command say the same of the same readings.
  void expect_same_offline(const std::string& command, const std::string& number,
                           const std::vector<std::string>& more = {}) const {
    ASSERT_EQ(run({"model", "export", "--out", path("model.yaml")}).exit_code, 0);
    const Finished exported = run({"campaign", "export", "--data", path("readings.csv"), "--frame",
                                   path("online.yaml"), "--document", path("online.json")});
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    std::vector<std::string> words{command,
                                   "--robot",
                                   kRobot,
                                   "--model",
                                   path("model.yaml"),
                                   "--data",
                                   path("readings.csv"),
                                   "--number",
                                   number,
                                   "--out",
                                   path("offline.yaml"),
                                   "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished offline = run_program("truepose", words);
    ASSERT_EQ(offline.exit_code, 0) << offline.err;
    json::object online = control::parse_json(config::read_text_file(path("online.json")))->as_object();
    EXPECT_EQ(online.at("yaml").as_string(), config::read_text_file(path("offline.yaml")));
    EXPECT_EQ(config::read_text_file(path("online.yaml")), config::read_text_file(path("offline.yaml")));
    online.erase("yaml");
    EXPECT_EQ(control::json_text(online), control::json_text(*control::parse_json(offline.out)));
  }
  json::value called(const std::string& method, const json::object& params = {}) const {
    auto client = cell_.client();
    return truepose::called(client, method, params);
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

  expect_same_offline("tool", "3");
  const config::ToolFile tool = config::load_tool(path("online.yaml"), config::load_robot(kRobot));
  const double off = off_mm(tool.X_controller.translation());
  RecordProperty("tcp_off_mm", std::to_string(off));
  EXPECT_LE(off, 0.045);
  EXPECT_GT(off_mm(Eigen::Vector3d(35, -70, 266)), 0.2) << "a tool as drawn is judged by the same";

  const std::string id = std::string{called("campaign.get").at_pointer("/campaign/id").as_string()};
  EXPECT_THAT(run({"tools", "activate", id}).out, HasSubstr("tool 3 is in use as campaign " + id));
  const json::object target{{"joints", json::array(1, json::array{0, -90, 90, 0, 35, 0})}, {"tool", 3}};
  EXPECT_EQ(called("targets.compensate", target).at("joints").as_array().size(), 1U);
  EXPECT_THAT(run({"tools", "list"}).out, HasSubstr("campaign " + id));
}

/// A fixture near the arm, with a reflector at each of three points.
class AFixtureOverTheRealProtocols : public AToolCampaignOverTheRealProtocols {
 protected:
  AFixtureOverTheRealProtocols()
      : AToolCampaignOverTheRealProtocols(LiveCell::Options{
            .speedup = 1000,
            .scenario = {
                {"  noise: {range_mm: 0.010, ",
                 "  nests_mm: [{x: 1900, y: 300, z: -700}, {x: 2200, y: 300, z: -700}, {x: 1900, y: 700, "
                 "z: -690}]\n  noise: {range_mm: 0.010, "}}}) {}
};

TEST_F(AFixtureOverTheRealProtocols, IsReadPointByPointAndSaidAsTheCommandSaysIt) {
  calibrate("14");
  std::string points = "point,x,y,z\n";
  const std::vector<std::pair<const char*, Eigen::Vector3d>> places{
      {"origin", {1900, 300, -700}}, {"x", {2200, 300, -700}}, {"xy", {1900, 700, -690}}};
  for (const auto& [name, p_W_mm] : places) {
    points += name;
    for (const double mm : plain::moved(kX_WB.inverse(), p_W_mm)) points += ',' + std::to_string(mm);
    points += '\n';
  }
  const Finished started =
      run({"campaign", "start", "--base", "5", "--points-file", cell_.write("points.csv", points)});
  ASSERT_EQ(started.exit_code, 0) << started.err;
  for (const auto& [name, p_W_mm] : places) {
    wait_until("put the reflector at point \\\"" + std::string{name} + "\\\" of base 5");
    ASSERT_EQ(run({"campaign", "resume"}).exit_code, 0);
  }
  wait_until("\"state\":\"ready\"");
  expect_same_offline("base", "5");
  const std::string targets = cell_.write("targets.csv", "x,y,z,a,b,c\n0,0,400,0,180,0\n");
  const Finished compensated =
      run_program("truepose", {"compensate", "--robot", kRobot, "--model", path("model.yaml"), "--poses",
                               targets, "--base", path("online.yaml"), "--json"});
  EXPECT_EQ(compensated.exit_code, 0) << compensated.err;
}

/// Joints in deg, turned otherwise each time, at which a point of the flange truly stands there in the base.
json::array joints_touching(const Eigen::Vector3d& p_B_mm, const Eigen::Vector3d& p_F_mm,
                            test::JoggingHand& hand) {
  json::array q_deg;
  for (const double rad : hand.touching(p_B_mm, p_F_mm)) q_deg.emplace_back(rad * 180 / std::acos(-1.0));
  return q_deg;
}

TEST_F(AToolCampaignOverTheRealProtocols, TouchesAFixtureThatIsJoggedToInT1AndSaysWhatTheCommandSays) {
  calibrate("30");
  put_reflector_at({0, 0, 0});
  ASSERT_EQ(run({"campaign", "start", "--tool", "3", "--watch"}).exit_code, 0);
  ASSERT_EQ(run({"campaign", "export", "--frame", path("gun.yaml")}).exit_code, 0);
  EXPECT_THAT(run({"campaign", "start", "--base", "5", "--touch", "3", "--points", "origin,x,xy"}).err,
              HasSubstr("no tool 3 is in use: measure it"));
  ASSERT_EQ(
      run({"tools", "activate", std::string{called("campaign.get").at_pointer("/campaign/id").as_string()}})
          .exit_code,
      0);

  const Eigen::Matrix4d X_BU = plain::kuka_frame({1450, -250, 600}, {25, 3, -2});
  const std::vector<std::pair<std::string, Eigen::Vector3d>> places{
      {"origin", {0, 0, 0}}, {"x", {450, 0, 0}}, {"xy", {-30, 380, 0}}};
  test::JoggingHand hand{with_published_errors(config::load_robot(kRobot)), 0.01, 5};
  const Finished started =
      run({"campaign", "start", "--base", "5", "--touch", "3", "--points", "origin,x,xy", "--readings", "2"});
  ASSERT_EQ(started.exit_code, 0) << started.err;
  wait_until("\"state\":\"paused\"");
  cell_.steer({{"kind", "operating-mode"}, {"mode", "T1"}});
  for (const auto& [name, p_U_mm] : places)
    for (const char* which : {"1 of 2", "2 of 2"}) {
      wait_until("touch point \\\"" + name + "\\\" of base 5 with the TCP of tool 3 (" + which);
      const json::value jogged = cell_.steer(
          {{"jog", joints_touching(plain::moved(X_BU, p_U_mm), X_FT_.topRightCorner<3, 1>(), hand)}});
      ASSERT_TRUE(jogged.as_object().contains("ok")) << jogged;
      ASSERT_EQ(run({"campaign", "resume"}).exit_code, 0);
    }
  wait_until("\"campaign\":null");
  const json::value found = called("campaign.get");
  ASSERT_EQ(found.at_pointer("/campaign/state"), "done") << found.at_pointer("/campaign/reason");
  EXPECT_EQ(found.at_pointer("/frame/touched_by"), 3);
  expect_same_offline("base", "5", {"--tool", path("gun.yaml")});

  // What the model makes of it, seen by the tracker, is where the fixture truly stands.
  const config::ModelFile model = config::load_model(path("model.yaml"));
  const Eigen::Isometry3d X = config::load_base(path("online.yaml"), model).X;
  for (const auto& [name, p_U_mm] : places) {
    const Eigen::Vector3d by_model = model.cell.base.isometry() * (X * p_U_mm);
    const double off_mm = (by_model - plain::moved(kX_WB * X_BU, p_U_mm)).norm();
    RecordProperty(name + "_off_mm", std::to_string(off_mm));
    EXPECT_LT(off_mm, 0.15) << name;
  }
}

}  // namespace
}  // namespace truepose
