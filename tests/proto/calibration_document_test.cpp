#include "proto/record/calibration_document.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "proto/record/calibration_content.hpp"
#include "proto/record/transfer.hpp"

namespace truepose::record {
namespace {

namespace json = boost::json;
using testing::ElementsAre;

std::vector<std::string> keys(const json::value& value) {
  std::vector<std::string> result;
  for (const auto& member : value.as_object()) result.emplace_back(member.key());
  return result;
}

struct Sample {
  Calibration calibration;
  MeasurementData data;
};

/// Two poses to identify, the first seen by both reflectors, and one to validate.
Sample sample() {
  Sample s;
  s.data.smr_names = {"1", "upper \"left\""};
  const Eigen::Vector2d q1{std::numbers::pi / 2, 250}, q2{0, 10}, q3{-1, 10};
  for (const auto& [q, smr, set] : {std::tuple{q1, 0, PoseSet::Identify},
                                    {q2, 0, PoseSet::Identify},
                                    {q1, 1, PoseSet::Identify},
                                    {q3, 0, PoseSet::Validate}}) {
    Measurement m;
    m.q = q;
    m.smr = smr;
    m.set = set;
    s.calibration.points.push_back({{1, 2, 3}, {0.1, 0.2, 0.3}, {0, 0, -0.1}});
    s.data.points.push_back(m);
  }
  Calibration& c = s.calibration;
  c.converged = true;
  c.coarse_iterations = 7;
  c.fine_iterations = 4;
  c.rank = 27;
  c.observability.o2 = 1 / 1024.0;
  c.cell.robot.joints.resize(2);
  c.cell.robot.joints[1].type = JointType::Prismatic;
  c.cell.base = {{1, 2, 3}, {0.1, 0.2, 0.3}};
  c.cell.reflectors = {{"1", {4, 5, 6}}, {"upper \"left\"", {7, 8, 9}}};
  c.parameters = {{"link2.a", 330.0, 330.6, 0.004, true}, {"link2.beta", 0, 0, 0, false}};
  c.identify.poses = 2;
  c.identify.points = 3;
  c.identify.before.mean = 2.862;
  c.validate.emplace().after.mean = 0.571;
  return s;
}

TEST(CalibrationDocument, HasTheMembersOfTheContractAndWhatTheIdentificationLearned) {
  const Sample s = sample();
  const json::object document = calibration_document(s.calibration, s.data, 0.004);
  EXPECT_THAT(keys(document),
              ElementsAre("method", "converged", "iterations", "elapsed_s", "identify", "validate", "rank",
                          "rank_gap", "condition", "sigma0_mm", "observability", "prior", "rejected", "base",
                          "smr", "parameters", "arm", "points"));
  EXPECT_THAT(keys(document.at("iterations")), ElementsAre("coarse", "fine"));
  for (const char* set : {"identify", "validate"}) {
    EXPECT_THAT(keys(document.at(set)), ElementsAre("poses", "points", "before", "geometric", "after"));
    for (const char* stage : {"before", "geometric", "after"}) {
      const json::value& S = document.at(set).at(stage);
      EXPECT_THAT(keys(S), ElementsAre("mean", "rms", "max", "min", "std", "x", "y", "z"));
      for (const char* axis : {"x", "y", "z"})
        EXPECT_THAT(keys(S.at(axis)), ElementsAre("mean_abs", "rms", "max"));
    }
  }
  EXPECT_THAT(keys(document.at("base")), ElementsAre("x", "y", "z", "rx", "ry", "rz"));
  EXPECT_THAT(keys(document.at("smr")), ElementsAre("1", "upper \"left\""));
  EXPECT_THAT(keys(document.at("smr").at("1")), ElementsAre("x", "y", "z"));
  EXPECT_THAT(keys(document.at("parameters").at(0)),
              ElementsAre("name", "nominal", "value", "sigma", "identified", "data_share"));
  EXPECT_THAT(keys(document.at("points").at(0)),
              ElementsAre("pose", "set", "smr", "joints", "position", "before", "geometric", "after"));
}

TEST(CalibrationDocument, CarriesTheCalibrationsFigures) {
  const Sample s = sample();
  const json::object document = calibration_document(s.calibration, s.data, 0.004);
  EXPECT_EQ(document.at("method"), "two-stage");
  EXPECT_EQ(document.at("converged"), true);
  EXPECT_EQ(document.at("iterations"), (json::value{{"coarse", 7}, {"fine", 4}}));
  EXPECT_EQ(document.at("elapsed_s"), 0.004);
  EXPECT_EQ(document.at("identify").at("points"), 3);
  EXPECT_EQ(document.at("identify").at("before").at("mean"), 2.862);
  EXPECT_EQ(document.at("validate").at("after").at("mean"), 0.571);
  EXPECT_EQ(document.at("rank"), 27);
  EXPECT_EQ(document.at("base"),
            (json::value{{"x", 1.0}, {"y", 2.0}, {"z", 3.0}, {"rx", 0.1}, {"ry", 0.2}, {"rz", 0.3}}));
  EXPECT_EQ(document.at("parameters").at(0), (json::value{{"name", "link2.a"},
                                                          {"nominal", 330.0},
                                                          {"value", 330.6},
                                                          {"sigma", 0.004},
                                                          {"identified", true},
                                                          {"data_share", 0.0}}));
}

TEST(CalibrationDocument, SaysWhatWasRejectedWhatThePriorWasAndWhatEachDeviationBought) {
  Sample s = sample();
  s.calibration.rejected = {{.point = 2, .residual_mm = 12.5, .sigmas = 300}};
  s.data.points[2].row = 7;
  s.calibration.prior_used = true;
  s.calibration.prior_scale = {.length_mm = 0.6, .angle_rad = 0.001};
  s.calibration.non_geometric = {.scale = 1e-3,
                                 .geometric_rms_mm = 0.5,
                                 .rms_mm = 0.1,
                                 .gains = {{"joint2.gravity", true, 0.4}, {"joint6.harmonic1", false, 0.11}}};
  const json::object document = calibration_document(s.calibration, s.data, 0);
  EXPECT_EQ(document.at("rejected"), (json::value{{{"point", 3},
                                                   {"row", 7},
                                                   {"pose", 1},
                                                   {"smr", "upper \"left\""},
                                                   {"residual_mm", 12.5},
                                                   {"sigmas", 300.0}}}));
  EXPECT_EQ(document.at("prior"), (json::value{{"used", true}, {"length_mm", 0.6}, {"angle_rad", 0.001}}));
  EXPECT_EQ(document.at("non_geometric").at("groups").at(1),
            (json::value{{"name", "joint6.harmonic1"}, {"chosen", false}, {"rms_mm", 0.11}}));
}

/// The arm of sample() with limits and a covariance: its first reflector is known to 0.3 mm in z alone.
Sample transferred() {
  Sample s = sample();
  Calibration& c = s.calibration;
  c.cell.robot.joints[0].min = -10;
  c.cell.robot.joints[0].max = std::numbers::pi / 2;
  c.cell.robot.joints[1].max = 300;
  c.covariance = Eigen::MatrixXd::Zero(22, 22);
  c.covariance(2, 2) = 0.09;  // the base's z
  c.transfer = {.rms_mm = 0.1, .max_mm = 4.56, .worst = Eigen::Vector2d{-std::numbers::pi / 2, 100}};
  return s;
}

TEST(CalibrationDocument, WarnsOfPosesThatArePredictedWorseThanTheNominalArmErrs) {
  Sample s = transferred();
  EXPECT_EQ(
      transfer_of(s.calibration, s.data).warning,
      "Measure poses towards the joints -90 deg, 100 mm: joint 1 was measured from 0 to 90 deg only, and "
      "there the position is predicted with a standard deviation of 4.56 mm, more than the nominal arm's "
      "mean error of 2.86 mm.");
  s.calibration.transfer.worst = Eigen::Vector2d{0.1, 100};
  EXPECT_THAT(transfer_warning(s.calibration, s.data), testing::HasSubstr("no pose near them was measured"));
  s.calibration.transfer.max_mm = 2.8;
  EXPECT_EQ(transfer_of(s.calibration, s.data).warning, "");
}

TEST(CalibrationDocument, MapsTheUncertaintyOverTheLimitsOfTwoJoints) {
  const Sample s = transferred();
  const json::object document = calibration_document(s.calibration, s.data, 0);
  const json::array& maps = document.at("prediction_uncertainty").at("maps").as_array();
  ASSERT_EQ(maps.size(), 1U);  // of joints 1 and 2; there is no third
  EXPECT_EQ(maps[0].at("x"), (json::value{{"joint", 1}, {"from", -180.0}, {"to", 90.0}, {"count", 17}}));
  EXPECT_EQ(maps[0].at("y"), (json::value{{"joint", 2}, {"from", 0.0}, {"to", 300.0}, {"count", 17}}));
  EXPECT_EQ(maps[0].at("held"), (json::value{90.0, 250.0}));
  const json::array& rows = maps[0].at("sigma_mm").as_array();
  ASSERT_EQ(rows.size(), 17U);
  for (const json::value& row : rows) {
    ASSERT_EQ(row.as_array().size(), 17U);
    for (const json::value& sigma : row.as_array()) EXPECT_DOUBLE_EQ(sigma.as_double(), 0.3);
  }
}

TEST(CalibrationDocument, HasNoRankGapWhereEveryParameterIsDetermined) {
  Sample s = sample();
  s.calibration.rank_gap = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(calibration_document(s.calibration, s.data, 0).contains("rank_gap"));
}

TEST(CalibrationDocument, LeavesOutTheValidationWhereNothingWasValidated) {
  Sample s = sample();
  s.calibration.validate.reset();
  EXPECT_FALSE(calibration_document(s.calibration, s.data, 0).contains("validate"));
}

TEST(CalibrationDocument, NumbersThePosesAndGivesJointsAsAMeasurementFileDoes) {
  const Sample s = sample();
  const json::object document = calibration_document(s.calibration, s.data, 0);
  const json::array& points = document.at("points").as_array();
  ASSERT_EQ(points.size(), 4u);
  std::vector<std::int64_t> poses;
  for (const json::value& point : points) poses.push_back(point.at("pose").as_int64());
  EXPECT_THAT(poses, ElementsAre(1, 2, 1, 3));
  EXPECT_EQ(points[2].at("smr"), "upper \"left\"");
  EXPECT_EQ(points[2].at("joints"), (json::value{90.0, 250.0}));
  EXPECT_EQ(points[0].at("set"), "identify");
  EXPECT_EQ(points[3].at("set"), "validate");
  EXPECT_EQ(points[3].at("before"), (json::value{1.0, 2.0, 3.0}));
  EXPECT_EQ(points[3].at("after"), (json::value{0.0, 0.0, -0.1}));
}

TEST(CalibrationDocument, KeepsTheNumbersThatACampaignGaveItsPoses) {
  Sample s = sample();
  for (std::size_t i = 0; i < 4; ++i) s.data.points[i].pose = std::array{4, 9, 4, 2}[i];
  const json::object document = calibration_document(s.calibration, s.data, 0);
  std::vector<std::int64_t> poses;
  for (const json::value& point : document.at("points").as_array())
    poses.push_back(point.at("pose").as_int64());
  EXPECT_THAT(poses, ElementsAre(4, 9, 4, 2));
}

TEST(CalibrationDocument, IsReadBackFromItsTextUnchanged) {
  const Sample s = sample();
  const json::object document = calibration_document(s.calibration, s.data, 0.1 + 0.2);
  EXPECT_EQ(json::parse(json::serialize(document)), document);
}

#ifndef NDEBUG
TEST(CalibrationDocumentDeathTest, RefusesANumberThatJsonCannotHold) {
  Sample s = sample();
  s.calibration.sigma0_mm = std::numeric_limits<double>::infinity();
  EXPECT_DEATH(calibration_document(s.calibration, s.data, 0), "is_finite");
}
#endif

}  // namespace
}  // namespace truepose::record
