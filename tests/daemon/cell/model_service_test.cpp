#include "daemon/cell/model_service.hpp"

#include "config/model_file.hpp"
#include "core/arm/forward.hpp"
#include "core/math/units.hpp"
#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

struct ModelServiceTest : CellTest {};

TEST_F(ModelServiceTest, WorksWithTheModelThatItsStoreSaysIsActive) {
  load();
  EXPECT_EQ(status().at_pointer("/model/id"), "m1");
  EXPECT_THAT(fault(), IsEmpty());
  ASSERT_TRUE(call("model.activate", {{"id", "m2"}}));
  EXPECT_EQ(status().at_pointer("/model/id"), "m2");
  const auto changes = event_data(control::Topic::Model);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].at("change"), "activated");
  EXPECT_EQ(changes[0].at_pointer("/model/id"), "m2");
}

TEST_F(ModelServiceTest, WarnsOfTheVerdictOfAModelThatAnOperatorActivates) {
  load();
  EXPECT_FALSE(call("model.activate", {{"id", "m1"}})->as_object().contains("warning"));
  execute(
      "UPDATE model SET yaml=replace(replace(yaml, 'color: green', 'color: red'), 'findings: []', "
      "'findings: [{severity: error, code: \"V_NOT_CONVERGED\", sentence: \"it did not converge\", "
      "what_to_do: \"measure again\"}]') WHERE id='m2'");
  seal_again();
  const char* const warning = "judged red when it was made: it did not converge";
  EXPECT_EQ(call("model.activate", {{"id", "m2"}})->at("warning"), warning);
  EXPECT_EQ(status().at_pointer("/model/warning"), warning);
}

TEST_F(ModelServiceTest, GoesBackToTheModelThatWasActiveBefore) {
  load();
  ASSERT_TRUE(call("model.activate", {{"id", "m2"}}));
  EXPECT_EQ(call("model.rollback")->at("id"), "m1");
  EXPECT_EQ(status().at_pointer("/model/id"), "m1");
  EXPECT_EQ(event_data(control::Topic::Model).back().at("by"), kOperator);
  EXPECT_EQ(call("model.rollback")->at("id"), "m2") << "and forth";
  ASSERT_TRUE(call("model.deactivate"));
  EXPECT_EQ(call("model.rollback")->at("id"), "m2");
  execute("UPDATE model SET validation_before_mm=validation_after_mm WHERE id='m1'");
  EXPECT_THAT(refused("model.rollback"), HasSubstr("no better than the nominal arm"));
  EXPECT_EQ(status().at_pointer("/model/id"), "m2");
}

TEST_F(ModelServiceTest, SaysThatThereIsNoModelToGoBackTo) {
  execute("DELETE FROM activation WHERE model_id<>'m1'");
  EXPECT_EQ(refused("model.rollback"), "no other model was active before");
}

TEST_F(ModelServiceTest, DoesNotWorkWithAModelOfWhichADigitHasBecomeAnother) {
  alter_m1();
  load();
  EXPECT_TRUE(status().at("model").is_null()) << control::json_text(status().at("model"));
  EXPECT_THAT(fault(), AllOf(HasSubstr("model m1 is refused"), HasSubstr("activate another model")));
  EXPECT_THAT(refused("stream.start"), HasSubstr("model m1 is refused"));
  EXPECT_THAT(refused("drift.check"), HasSubstr("model m1 is refused"));
  EXPECT_THAT(refused("targets.compensate", {{"joints", {{0, -90, 90, 0, 30, 0}}}}), HasSubstr("is refused"));
  EXPECT_EQ(call("model.list")->at_pointer("/models/0/active"), false) << "it is not in effect";

  ASSERT_TRUE(call("model.activate", {{"id", "m2"}}));
  EXPECT_EQ(status().at_pointer("/model/id"), "m2");
  EXPECT_THAT(fault(), IsEmpty()) << "another model is in use";
}

TEST_F(ModelServiceTest, ShowsNoModelOfWhichTheTextIsNotTheOneThatWasStored) {
  alter_m1();
  EXPECT_THAT(refused("model.get", {{"id", "m1"}}), testing::StartsWith("model m1 is refused: "));
  execute("UPDATE model SET yaml=substr(yaml, 1, 500) WHERE id='m1'");
  seal_again();
  EXPECT_THAT(refused("model.get", {{"id", "m1"}}), testing::StartsWith("model m1 is refused: its text"));
}

TEST_F(ModelServiceTest, DoesNotActivateAnAlteredModelAndKeepsTheOneInForce) {
  load();
  execute("UPDATE model SET yaml=replace(yaml, 'theta: 0.00', 'theta: 0.04') WHERE id='m2'");
  seal_again();
  EXPECT_THAT(refused("model.activate", {{"id", "m2"}}), HasSubstr("misses its own validation points"));
  EXPECT_EQ(status().at_pointer("/model/id"), "m1");
  EXPECT_EQ(store->active_model().value()->id, "m1");
  EXPECT_THAT(fault(), IsEmpty());
}

TEST_F(ModelServiceTest, DoesNotActivateAModelThatIsNoBetterThanTheNominalArm) {
  execute("UPDATE model SET validation_before_mm=validation_after_mm WHERE id='m2'");
  EXPECT_THAT(refused("model.activate", {{"id", "m2"}}), HasSubstr("no better than the nominal arm"));
}

TEST_F(ModelServiceTest, NeitherActivatesNorWorksWithAModelOfAnotherArm) {
  execute("UPDATE model SET robot_serial='S2', yaml=replace(yaml, 'MOCK-0001', 'S2')");
  seal_again();
  load();
  play([this]() -> Wait { co_await connected(); });
  EXPECT_EQ(refused("model.activate", {{"id", "m2"}}), "the model belongs to arm S2, not to MOCK-0001");
  for (const char* needs_one : {"stream.start", "drift.check"})
    EXPECT_EQ(
        refused(needs_one),
        "the active model belongs to arm S2, not to MOCK-0001; allowed: model.activate, campaign.start");
  EXPECT_THAT(refused("campaign.start", {{"kind", "targets"}}), HasSubstr("belongs to arm S2"));
}

TEST_F(ModelServiceTest, DoesNotWorkWithAModelWhereTheArmThatConnectsIsAnother) {
  execute("UPDATE model SET robot_serial='S2', yaml=replace(yaml, 'MOCK-0001', 'S2')");
  seal_again();
  load();
  const std::array<json::object, 4> campaigns{
      json::object{}, {{"kind", "targets"}}, {{"kind", "iso9283"}}, {{"kind", "tool"}, {"number", 1}}};
  for (const json::object& asked : campaigns) {
    ASSERT_TRUE(call(asked.empty() ? "drift.check" : "campaign.start", asked)) << control::json_text(asked);
    play([this]() -> Wait { co_await campaign_ended(); });
    EXPECT_THAT(fault(), AllOf(HasSubstr("the active model belongs to arm S2, not to MOCK-0001"),
                               HasSubstr("activate this arm's model, or calibrate it")));
    call("cell.acknowledge");
    call("cell.disconnect");
  }
}

TEST_F(ModelServiceTest, ForgetsTheFaultOfAModelThatIsDeactivated) {
  alter_m1();
  load();
  EXPECT_THAT(fault(), HasSubstr("m1"));
  EXPECT_EQ(call("model.deactivate")->at("deactivated"), "m1");
  EXPECT_EQ(event_data(control::Topic::Model).back().at("change"), "deactivated");
  EXPECT_THAT(fault(), IsEmpty());
}

TEST_F(ModelServiceTest, CorrectsByNoModelOnceItIsDeactivated) {
  load();
  EXPECT_EQ(call("model.deactivate")->at("deactivated"), "m1");
  EXPECT_TRUE(status().at("model").is_null());
  EXPECT_TRUE(call("model.deactivate")->at("deactivated").is_null());
  EXPECT_EQ(refused("stream.start"), "no model is active; allowed: model.activate, campaign.start");
  EXPECT_EQ(refused("model.get"), "no model is active");
}

TEST_F(ModelServiceTest, ListsAndHandsOutWhatItHas) {
  const json::value page = call("model.list", {{"limit", 1}}).value();
  EXPECT_EQ(page.at("total"), 2);
  EXPECT_EQ(page.at("models").as_array().size(), 1U);
  EXPECT_EQ(page.at_pointer("/models/0/id"), "m1") << "the last made first";
  EXPECT_EQ(call("model.get", {{"id", "m2"}})->at("parameters").as_array().size(), 39U);
  EXPECT_THAT(std::string{call("model.export")->at("yaml").as_string()}, HasSubstr("MOCK-0001"));
  for (const char* method : {"model.get", "model.export", "model.activate"})
    EXPECT_EQ(refused(method, {{"id", "m3"}}), "no such model");
  EXPECT_EQ(call("model.activate").error().code, control::ErrorCode::InvalidParams);
}

TEST_F(ModelServiceTest, SaysOfAStoreThatCannotBeReadWhatIsWrongWithIt) {
  execute("DROP TABLE model");
  for (const auto& [method, params] :
       std::map<std::string, json::object>{{"model.list", {}},
                                           {"model.get", {}},
                                           {"model.export", {}},
                                           {"model.activate", {{"id", "m2"}}},
                                           {"targets.compensate", {{"joints", {{0, -90, 90, 0, 30, 0}}}}}}) {
    const Answer answer = call(method, params);
    ASSERT_FALSE(answer) << method;
    EXPECT_EQ(answer.error().code, control::ErrorCode::Store) << method;
    EXPECT_THAT(answer.error().message, HasSubstr("no such table")) << method;
  }
}

struct TargetServiceTest : CellTest {
  TargetServiceTest() { load(); }
  json::value compensated(json::object params) {
    return call("targets.compensate", std::move(params)).value();
  }
};

TEST_F(TargetServiceTest, GivesJointsForJointsAndForPosesOfTheFlange) {
  const json::value of_joints =
      compensated({{"joints", {{0, -90, 90, 0, 30, 0}, {10, -80, 90, 20, 45, -30}}}});
  EXPECT_EQ(of_joints.at("joints").as_array().size(), 2U);
  EXPECT_NE(of_joints.at_pointer("/joints/0/1"), -90);
  EXPECT_EQ(of_joints.at_pointer("/damped/1"), false);
  EXPECT_LT(of_joints.at_pointer("/residual_mm/1").to_number<double>(), 1e-6);
  EXPECT_LT(of_joints.at_pointer("/residual_deg/1").to_number<double>(), 1e-6);
  const json::value of_pose = compensated({{"poses", {{1700, 0, 1500, 0, 60, 0}}}, {"model_id", "m2"}});
  EXPECT_GT(of_pose.at_pointer("/iterations/0").as_int64(), 0);
}

TEST_F(TargetServiceTest, KeepsTheTcpOfAStretchedWristWithinTheThresholdOfTheCell) {
  config.stream.singularity_threshold_deg = 5;
  config.stream.p_FT_mm = {{0, 0, 300}};
  const json::value found = compensated({{"joints", {{0, -90, 90, 0, 0, 0}, {0, -90, 90, 0, 10, 0}}}});
  EXPECT_EQ(control::json_text(found.at("damped")), "[true,false]");
  JointVector asked(6), q(6);
  for (Eigen::Index i = 0; i < 6; ++i) {
    asked[i] = std::array{0, -90, 90, 0, 0, 0}[static_cast<std::size_t>(i)] * kRadPerDeg;
    q[i] = found.at_pointer("/joints/0/" + std::to_string(i)).to_number<double>() * kRadPerDeg;
  }
  const std::string yaml = call("model.export")->at("yaml").as_string().c_str();
  const RobotModel real = config::parse_model(yaml, "exported").cell.robot;
  const auto tcp_mm = [this](const RobotModel& arm, const JointVector& at) -> Eigen::Vector3d {
    return forward_kinematics(arm, at) * *config.stream.p_FT_mm;
  };
  EXPECT_LT((tcp_mm(real, q) - tcp_mm(config.robot.model, asked)).norm(), 1e-5);
}

TEST_F(TargetServiceTest, NamesTheRowThatCannotBeReached) {
  EXPECT_THAT(refused("targets.compensate", {{"poses", {{1700, 0, 1500, 0, 60, 0}, {9000, 0, 0, 0, 0, 0}}}}),
              testing::StartsWith("params.poses[1]: "));
  EXPECT_THAT(refused("targets.compensate", {{"joints", {{0, -90, 90, 0, 35, 360}}}}),
              testing::StartsWith("params.joints[0]: joint 6 would have to go to"));
}

TEST_F(TargetServiceTest, WantsEitherJointsOrPosesAndAModel) {
  EXPECT_THAT(refused("targets.compensate"), HasSubstr("exactly one of joints and poses"));
  const json::array rows(1, {0, -90, 90, 0, 30, 0});
  EXPECT_EQ(refused("targets.compensate", {{"joints", rows}, {"model_id", "m3"}}), "no such model");
  ASSERT_TRUE(call("model.deactivate"));
  EXPECT_EQ(refused("targets.compensate", {{"joints", rows}}), "no model is active");
}

}  // namespace
}  // namespace truepose::daemon
