#include "config/model_file.hpp"

#include <gtest/gtest.h>

#include "config/model_update.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "tests/config/error_of.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/members.hpp"
#include "tests/model_members.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {

template <>
inline constexpr int kMembers<config::ModelFile> = 18;
template <>
inline constexpr int kMembers<ThermalResponse> = 3;
template <>
inline constexpr int kMembers<config::ValidationPoint> = 5;
template <>
inline constexpr int kMembers<CalibratedCell> = 4;

}  // namespace truepose

namespace truepose::config {
namespace {

/// A model of numbers that use all their bits.
ModelFile model_of(std::uint64_t seed) {
  Random random(seed);
  const auto mm = [&] { return random.uniform(-3000, 3000); };
  const auto rad = [&] { return random.uniform(-3, 3); };
  ModelFile model;
  model.name = "KUKA: \"KR 210\" # \\ \t R2700-2";
  model.serial = "007";
  model.created = "2026-01-02T03:04:05Z";
  model.validation_mean_mm = random.uniform(0, 1);
  model.cell.robot.name = "no";
  for (int i = 0; i < 7; ++i) {
    Joint joint{.a_mm = mm(), .alpha_rad = rad(), .d_mm = mm(), .theta_rad = rad(), .beta_rad = rad() * 1e-9};
    joint.type = i == 3 ? JointType::Prismatic : JointType::Revolute;
    joint.sign = i % 2 ? 1 : -1;
    joint.min = rad();
    joint.max = rad();
    joint.speed = random.uniform(0, 3);
    model.cell.robot.joints.push_back(joint);
  }
  model.cell.robot.X_flange = pose_from_kuka({mm(), mm(), mm()}, {rad(), rad(), rad()});
  model.cell.base = {.p_mm = {mm(), mm(), mm()}, .rxyz_rad = {rad(), -0.0, rad()}};
  model.cell.reflectors = {{.name = "1", .p_FS_mm = {mm(), mm(), mm()}},
                           {.name = "left, up", .p_FS_mm = {0, 1e-300, mm()}}};
  model.parameters = {{.name = "smr.left, up.x",
                       .nominal = 0,
                       .value = mm(),
                       .sigma = 1e-17,
                       .identified = true,
                       .data_share = 1.0 / 3},
                      {.name = "link2.a", .nominal = mm(), .value = mm(), .sigma = 0, .identified = false}};
  return model;
}

TEST(ModelFile, ReadsBackEveryMemberThatIsWritten) {
  ModelFile model;
  Filler{}(model);
  model.cell.further_bases.clear();  // a model has one base
  RobotModel& robot = model.cell.robot;
  robot.gravity_B.normalize();
  for (DeviationTerm& term : robot.deviation) term.joint = 1;
  for (Joint& joint : robot.joints) joint.type = JointType::Revolute;
  robot.coupling = {{.joint = 1, .to = 0, .factor = -1.0 / 3}};
  const int size = ParameterLayout::of(model.cell).size();
  model.covariance = Eigen::MatrixXd::Identity(size, size);
  const int warm = robot.joint_count() + 1;
  model.thermal = {.reference_c = std::vector<double>(robot.joints.size(), 31.5),
                   .per_kelvin = Eigen::VectorXd::LinSpaced(warm, 1e-6, 2e-5),
                   .covariance = Eigen::MatrixXd::Random(warm, size + warm)};
  model.covariance(2, 1) = model.covariance(1, 2) = 0.3;
  for (ValidationPoint& point : model.validation) point.smr = 1;
  const ModelFile read = parse_model(model_yaml(model), "model.yaml");
  EXPECT_EQ(read.sha256.size(), 64U);
  model.sha256 = read.sha256;
  EXPECT_TRUE(same(read, model)) << model_yaml(model);
}

TEST(ModelFile, KeepsItsVerdictUnderItsHash) {
  ModelFile model = model_of(3);
  EXPECT_FALSE(parse_model(model_yaml(model), "m.yaml").verdict);
  model.verdict = CalibrationVerdict{};
  const ModelFile green = parse_model(model_yaml(model), "m.yaml");
  ASSERT_TRUE(green.verdict);
  EXPECT_EQ(green.verdict->color(), VerdictColor::Green);

  model.verdict->findings = {finding(FindingKind::Tolerance, "it is \"off\": 3 mm"),
                             finding(FindingKind::Outliers, "one point left out")};
  std::string text = model_yaml(model);
  const ModelFile red = parse_model(text, "m.yaml");
  EXPECT_EQ(red.verdict->color(), VerdictColor::Red);
  ASSERT_EQ(red.verdict->findings.size(), 2U);
  EXPECT_EQ(red.verdict->findings[0].sentence, "it is \"off\": 3 mm");
  EXPECT_EQ(red.verdict->findings[1].severity, Severity::Note);

  const std::string severity = "severity: error";
  const std::size_t error = text.find(severity);
  ASSERT_NE(error, std::string::npos);
  text.replace(error, severity.size(), "severity: advice");
  EXPECT_NE(error_of([&] { parse_model(text, "m.yaml"); }, "").find("another SHA-256"), std::string::npos);
}

TEST(ModelFile, ComesBackToTheLastBit) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    const ModelFile model = model_of(seed);
    const ModelFile read = parse_model(model_yaml(model), "model.yaml");
    EXPECT_EQ(read.name, model.name);
    EXPECT_EQ(read.serial, model.serial);
    EXPECT_EQ(read.created, model.created);
    EXPECT_EQ(read.validation_mean_mm, model.validation_mean_mm);
    EXPECT_EQ(read.cell.robot.name, model.cell.robot.name);
    EXPECT_EQ(read.cell.robot.X_flange.matrix(), model.cell.robot.X_flange.matrix());
    ASSERT_EQ(read.cell.robot.joints.size(), model.cell.robot.joints.size());
    for (std::size_t i = 0; i < model.cell.robot.joints.size(); ++i) {
      const Joint &a = read.cell.robot.joints[i], &b = model.cell.robot.joints[i];
      EXPECT_EQ(a.type, b.type);
      EXPECT_EQ(a.a_mm, b.a_mm);
      EXPECT_EQ(a.alpha_rad, b.alpha_rad);
      EXPECT_EQ(a.d_mm, b.d_mm);
      EXPECT_EQ(a.theta_rad, b.theta_rad);
      EXPECT_EQ(a.beta_rad, b.beta_rad);
      EXPECT_EQ(a.sign, b.sign);
      EXPECT_EQ(a.min, b.min);
      EXPECT_EQ(a.max, b.max);
      EXPECT_EQ(a.speed, b.speed);
    }
    EXPECT_EQ(read.cell.base.p_mm, model.cell.base.p_mm);
    EXPECT_EQ(read.cell.base.rxyz_rad, model.cell.base.rxyz_rad);
    ASSERT_EQ(read.cell.reflectors.size(), 2U);
    EXPECT_EQ(read.cell.reflectors[1].name, "left, up");
    EXPECT_EQ(read.cell.reflectors[1].p_FS_mm, model.cell.reflectors[1].p_FS_mm);
    ASSERT_EQ(read.parameters.size(), 2U);
    EXPECT_EQ(read.parameters[0].name, "smr.left, up.x");
    EXPECT_EQ(read.parameters[0].value, model.parameters[0].value);
    EXPECT_EQ(read.parameters[0].sigma, model.parameters[0].sigma);
    EXPECT_EQ(read.parameters[0].data_share, model.parameters[0].data_share);
    EXPECT_TRUE(read.parameters[0].identified);
    EXPECT_EQ(read.parameters[1].nominal, model.parameters[1].nominal);
    EXPECT_FALSE(read.parameters[1].identified);
    EXPECT_EQ(model_yaml(read), model_yaml(model));
  }
}

TEST(ModelFile, IsOfAnotherTrackerAsThatSeesIt) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  X.translation() = Eigen::Vector3d(120, -40, 5);
  ModelFile model;
  model.cell = {example::with_paper_errors(example::kr210()),
                BasePose::of(pose_from_kuka({4000, 0, -1400}, {180, 3, 2})),
                {{"1", {80, 40, 60}}}};
  const JointVector q = JointVector::LinSpaced(6, -1.5, 1);
  model.validation.push_back({.q = q, .p_WS_mm = model.cell.predict(q, 0) + Eigen::Vector3d(0.3, 0.2, -0.1)});
  const int size = ParameterLayout::of(model.cell).size();
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(size, size);
  model.covariance = 1e-4 * A * A.transpose();
  model.parameters = {{.name = "base.x", .value = 4000, .sigma = 1, .identified = true}};

  const ModelFile seen = seen_from(model, X);
  const Eigen::Vector3d there_mm = model.cell.predict(q, 0);
  EXPECT_LT((seen.cell.predict(q, 0) - X * there_mm).norm(), 1e-9);
  EXPECT_LT((seen.validation[0].p_WS_mm - X * model.validation[0].p_WS_mm).norm(), 1e-9);
  EXPECT_EQ(seen.parameters[0].value, seen.cell.base.p_mm.x());
  EXPECT_EQ(seen.parameters[0].sigma, std::sqrt(seen.covariance(0, 0)));
  const Eigen::Matrix3d before = position_covariance(model.cell, model.covariance, q, 0),
                        after = position_covariance(seen.cell, seen.covariance, q, 0);
  EXPECT_LT((after - X.linear() * before * X.linear().transpose()).norm(), 1e-9 * before.norm());
  EXPECT_EQ(model_yaml(seen_from(model, Eigen::Isometry3d::Identity())), model_yaml(model));
}

TEST(ModelFile, BringsBackHowWellItIsKnownAndMayBeWithoutThat) {
  ModelFile model = model_of(3);
  const std::string before = model_yaml(model);
  EXPECT_FALSE(parse_model(before, "model.yaml").noise);
  EXPECT_EQ(parse_model(before, "model.yaml").covariance.size(), 0);

  const int size = ParameterLayout::of(model.cell).size();
  Random random(4);
  const Eigen::MatrixXd half =
      Eigen::MatrixXd::NullaryExpr(size, size, [&] { return random.uniform(-1e-3, 1e-3); });
  model.covariance = half + half.transpose();
  model.noise = MeasurementNoise{.tracker = {1.0 / 3, 1e-9, 0.1, 0.006}, .repeatability_mm = 0.0166};
  const std::string text = model_yaml(model);
  const ModelFile read = parse_model(text, "model.yaml");
  EXPECT_EQ(read.covariance, model.covariance);
  ASSERT_TRUE(read.noise);
  EXPECT_EQ(read.noise->tracker.range_mm, 1.0 / 3);
  EXPECT_EQ(read.noise->tracker.transverse_mm_per_m, 0.006);
  EXPECT_EQ(read.noise->repeatability_mm, 0.0166);

  const std::string cut = text.substr(0, text.rfind("  - ["));
  EXPECT_NE(error_of([&] { parse_model(cut, "m.yaml"); }, "")
                .find("covariance: expected a row for each of " + std::to_string(size) + " parameters"),
            std::string::npos);
}

TEST(ModelFile, AnEmptyModelsListsComeBack) {
  ModelFile model;
  model.name = model.cell.robot.name = "r";
  model.cell.robot.joints.resize(1);
  const ModelFile read = parse_model(model_yaml(model), "model.yaml");
  EXPECT_EQ(read.serial, "");
  EXPECT_TRUE(read.cell.reflectors.empty());
  EXPECT_TRUE(read.parameters.empty());
}

/// A model whose one validation point it misses by 0.2 mm, as it says.
ModelFile validated_model() {
  ModelFile model = model_of(5);
  const JointVector q = JointVector::Constant(model.cell.robot.joint_count(), 0.3);
  model.validation = {{.q = q, .smr = 1, .p_WS_mm = model.cell.predict(q, 1) + Eigen::Vector3d(0, 0.2, 0)}};
  model.validation_mean_mm = 0.2;
  return model;
}

TEST(ModelFile, IsRefusedWhereItDoesNotReproduceItsOwnValidationError) {
  const TempFolder folder;
  const auto error_of_file = [&](const ModelFile& model) {
    return error_of([&] { load_model(folder.write("m.yaml", model_yaml(model))); }, "");
  };
  ModelFile model = validated_model();
  EXPECT_EQ(load_model(folder.write("m.yaml", model_yaml(model))).validation.size(), 1U);
  model.cell.robot.joints[1].a_mm += 300;
  EXPECT_NE(error_of_file(model).find("the model is refused: it misses its own validation points by 299.86"),
            std::string::npos)
      << error_of_file(model);
  for (auto spoil : {+[](ValidationPoint& point) { point.smr = 2; },
                     +[](ValidationPoint& point) { point.q.conservativeResize(6); }}) {
    model = validated_model();
    spoil(model.validation.front());
    EXPECT_NE(error_of_file(model).find("has other joints, or a reflector that it does not know"),
              std::string::npos)
        << error_of_file(model);
  }
}

TEST(ModelFile, RefusesAValidationPointWithMoreJointsThanAnArmMayHave) {
  std::string text = model_yaml(validated_model());
  const std::size_t joints = text.find("q: [", text.find("validation:")) + 4;
  text.replace(joints, text.find(']', joints) - joints, "0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0");
  const std::string error = error_of([&] { parse_model(text, "m.yaml"); }, "");
  EXPECT_NE(error.find("validation[1].q: expected at most 16 numbers, found 17"), std::string::npos) << error;
}

TEST(ModelFile, IsRefusedWhereItsTextIsNotTheOneThatWasWritten) {
  std::string text = model_yaml(validated_model());
  text.replace(text.find("0.2"), 3, "0.3");
  EXPECT_EQ(error_of([&] { parse_model(text, "m.yaml"); }, ""),
            "m.yaml: its content is not what was written (another SHA-256): take the file as it was made, or "
            "identify again");
  text.erase(text.rfind("sha256: "));
  EXPECT_EQ(
      error_of([&] { parse_model(text, "m.yaml"); }, ""),
      "m.yaml: its last line is no 'sha256: ...', which shows that the others are unchanged; identify again");
}

TEST(ModelFile, IsRefusedWhereItCorrectsMoreThanItSaid) {
  const RobotModel nominal = example::kr210();
  CalibratedCell cell{.robot = nominal};
  const std::vector<JointVector> poses = poses_of(
      std::vector<ValidationPoint>{{.q = (JointVector(6) << 0.1, -1.4, 1.5, 0.2, 0.5, -0.3).finished()}});
  EXPECT_FALSE(larger_correction(nominal, cell, poses, 0.01));
  cell.robot.joints[0].theta_rad += 0.1 * kRadPerDeg;
  EXPECT_FALSE(larger_correction(nominal, cell, poses, 0.101));
  EXPECT_TRUE(larger_correction(nominal, cell, poses, 0.09));
  EXPECT_FALSE(larger_correction(nominal, cell, poses, 0)) << "nothing is known";
}

TEST(ModelFile, IsOfTheRobotFileThatItWasIdentifiedFrom) {
  const RobotModel nominal = example::kr210();
  ModelFile model{.cell = {.robot = nominal}};
  const std::vector<std::string> names = parameter_names({.robot = nominal});
  const Eigen::VectorXd values = parameter_values({.robot = nominal});
  for (std::size_t k = 6; k < names.size(); ++k)
    model.parameters.push_back({.name = names[k], .nominal = values[static_cast<Eigen::Index>(k)]});
  model.cell.robot.joints[2].a_mm += 1;  // what was found is no part of it
  EXPECT_EQ(other_nominal(nominal, model), std::nullopt);
  const auto of = [&](auto change) {
    RobotModel other = nominal;
    change(other);
    return other_nominal(other, model).value_or("");
  };
  const std::string says = "it was identified from another robot file, ";
  EXPECT_EQ(of([](RobotModel& r) { r.joints[2].a_mm = 1160; }),
            says + "link3.a: 1150 mm in the model, 1160 mm in the robot file");
  EXPECT_EQ(of([](RobotModel& r) { r.joints[2].theta_rad = 0; }),
            says + "link3.theta: -90 deg in the model, 0 deg in the robot file");
  EXPECT_EQ(of([](RobotModel& r) { r.joints[0].sign = 1; }),
            says + "the sign of joint 1: -1 in the model, 1 in the robot file");
  EXPECT_EQ(of([](RobotModel& r) { r.coupling = {{.joint = 2, .to = 1, .factor = 1}}; }),
            says + "the coupling of joints");
  EXPECT_EQ(of([](RobotModel& r) { r.X_flange.translation().z() += 10; }), says + "the flange");
  EXPECT_EQ(of([](RobotModel& r) { r.joints[0].max = 1; }), "") << "limits are the cell's";
}

TEST(ModelFile, KnowsWhetherThePayloadMattersAndIsOpen) {
  ModelFile model{.cell = {.robot = example::kr210()}};
  model.several_payloads = true;
  EXPECT_FALSE(is_payload_open(model)) << "it does not bend under one";
  model.cell.robot.deviation = {{1, DeviationBasis::Gravity, 1, 1e-4}};
  EXPECT_TRUE(is_payload_open(model));
  model.several_payloads = false;
  EXPECT_TRUE(is_payload_open(model)) << "only several payloads show this without masses";
  model.cell.robot.masses.resize(6);
  EXPECT_FALSE(is_payload_open(model)) << "the masses show it";
  model.several_payloads = true;
  EXPECT_TRUE(is_payload_open(model));
  model.cell.robot.payload = LinkMass{};
  EXPECT_FALSE(is_payload_open(model)) << "reported, though it is none";
}

TEST(ModelFile, RefusesAFlangeThatIsNoRotationAndAMissingPart) {
  std::string text = model_yaml(model_of(1));
  const auto without = [&](const std::string& key) {
    const auto begin = text.find("\n" + key + ":") + 1;
    return text.substr(0, begin) + text.substr(text.find('\n', begin) + 1);
  };
  EXPECT_EQ(error_of([&] { parse_model(without("base"), "m.yaml"); }, ""), "m.yaml:2:1: missing key 'base'");
  EXPECT_EQ(error_of([&] { parse_model(without("serial"), "m.yaml"); }, ""),
            "m.yaml:2:1: missing key 'serial'");
  const auto flange = text.find("  flange: [") + 11;
  text.replace(flange, text.find(',', flange) - flange, "2");
  EXPECT_EQ(error_of([&] { parse_model(text, "m.yaml"); }, ""), "m.yaml:16:11: robot.flange: not a rotation");
}

}  // namespace
}  // namespace truepose::config
