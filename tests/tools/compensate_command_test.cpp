// `truepose compensate` on joints and poses in files and pipes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <boost/json.hpp>
#include <cmath>
#include <fstream>
#include <sstream>

#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/arm/forward.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/fit/uncertainty.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/daemon/page.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kJoints = "q1,q2,q3,q4,q5,q6\n";
constexpr const char* kSingularRow = "20,-80,100,30,1.5,-40\n";
constexpr const char* kRegularRow = "20,-80,100,30,45,-40\n";

class Compensate : public testing::Test {
 protected:
  /// A model whose parameters are known to 0.01 mm and 0.01 mrad each.
  static config::ModelFile known_model(const RobotModel& nominal) {
    config::ModelFile model{.name = nominal.name, .cell = {.robot = with_published_errors(nominal)}};
    model.cell.reflectors = {{"1", {62, -48, 187}}};
    const int size = ParameterLayout::of(model.cell).size();
    model.covariance = Eigen::VectorXd::Constant(size, 1e-10).asDiagonal();
    model.noise =
        MeasurementNoise{.tracker = {.range_mm = 0.005, .transverse_mm = 0.005}, .repeatability_mm = 0.02};
    model.misfit_mm = 0.015;
    return model;
  }

  Finished compensate(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"compensate", "--robot", kRobot, "--model", model_file_});
    return run_program("truepose", arguments);
  }
  /// With all the orientation that rows may give up.
  json::object document(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--max-orientation-residual", "5", "--json"});
    const Finished run = compensate(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    return printed_document(run.out).as_object();
  }
  std::string file(const std::string& text) const { return folder_.write("targets.csv", text); }

  static JointVector joints(const json::object& document, std::size_t row) {
    const auto deg = json::value_to<std::vector<double>>(document.at("joints").at(row));
    return kRadPerDeg * Eigen::Map<const Eigen::VectorXd>(deg.data(), 6);
  }
  JointVector nominal_joints(const std::string& row) const {
    return config::load_joints(folder_.write("row.csv", kJoints + row), nominal_).at(0);
  }
  static double number(const json::object& document, const char* name, std::size_t row = 0) {
    return document.at(name).at(row).to_number<double>();
  }

  TempFolder folder_;
  RobotModel nominal_ = config::load_robot(kRobot);
  config::ModelFile model_ = known_model(nominal_);
  std::string model_file_ = folder_.write("model.yaml", config::model_yaml(model_));
};

std::string line_through_the_singularity() {
  std::ostringstream text;
  text << kJoints;
  for (int i = 0; i <= 400; ++i) text << "20,-80,100,30," << -10 + 0.05 * i << ",-40\n";
  return text.str();
}

TEST_F(Compensate, ALineThroughTheSingularityStaysWithinTheBoundAndIsDrawn) {
  const std::string report = folder_.path() / "line.html";
  const json::object line = document({"--joints", file(line_through_the_singularity()), "--report", report});
  const auto nominal = config::load_joints(folder_.path() / "targets.csv", nominal_);
  JointVector last;
  for (std::size_t i = 0; i < nominal.size(); ++i) {
    const JointVector correction = (joints(line, i) - nominal[i]) * kDegPerRad;
    EXPECT_LT(correction.cwiseAbs().maxCoeff(), 0.5);
    if (i == 0) last = correction;
    EXPECT_LT((correction - last).cwiseAbs().maxCoeff(), 0.01);  // of 0.05 deg
    last = correction;
    EXPECT_LT(number(line, "residual_mm", i), 1e-6);
    EXPECT_LT(number(line, "residual_deg", i), 0.9);
    EXPECT_TRUE(line.at("damped").at(i).as_bool());
  }
  const pugi::xml_document page = report::parsed(text_of(report));
  const std::string text = report::text_of(page);
  EXPECT_THAT(text, HasSubstr("Targets"));
  EXPECT_THAT(text, HasSubstr("401"));
  EXPECT_EQ(page.select_nodes("//*[local-name()='svg']").size(), 4U);
}

TEST_F(Compensate, KeepsTheReflectorOfTheModelExactNextToTheSingularity) {
  const json::object made = document({"--joints", file(std::string{kJoints} + kSingularRow)});
  ASSERT_GT(number(made, "residual_deg"), 0.1);
  const Eigen::Vector3d& p_F_mm = model_.cell.reflectors.front().p_FS_mm;
  const Eigen::Vector3d wanted_mm = forward_kinematics(nominal_, nominal_joints(kSingularRow)) * p_F_mm;
  const Eigen::Vector3d stands_mm = forward_kinematics(model_.cell.robot, joints(made, 0)) * p_F_mm;
  EXPECT_LT((stands_mm - wanted_mm).norm(), 1e-6);
}

TEST_F(Compensate, CountsTheRowsThatGiveUpOrientationAndEndsWith1) {
  const std::filesystem::path out = folder_.path() / "joints.csv";
  const Finished line = compensate({"--joints", file(line_through_the_singularity()), "--out", out});
  EXPECT_EQ(line.exit_code, 1);
  EXPECT_THAT(line.err,
              testing::ContainsRegex("[0-9]+ of 401 rows give up more than 0.1 deg of orientation next to a "
                                     "singularity, row [0-9]+ the most"));
  EXPECT_TRUE(std::filesystem::exists(out)) << "the rows are there all the same";
  EXPECT_EQ(compensate({"--joints", file(std::string(kJoints) + kRegularRow)}).exit_code, 0);
}

TEST_F(Compensate, CountsTheRowsWhosePositionGivesWayAndHoldsItInSigma) {
  std::string rows = kJoints;
  Random random(5);
  for (int i = 0; i < 1500; ++i) {
    const double from_to[][2] = {{-180, 180}, {-90, -30}, {60, 110}, {-300, 300}, {-20, 20}, {-300, 300}};
    std::string row;
    for (const auto& [from, to] : from_to) row += ',' + std::to_string(random.uniform(from, to));
    rows += row.substr(1) + '\n';
  }
  const Finished run = compensate({"--joints", file(rows), "--max-orientation-residual", "180", "--json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, testing::ContainsRegex(
                           "^truepose: [0-9]+ of 1500 rows give up more than 0.01 mm of position next to a "
                           "singularity, row [0-9]+ the most \\([0-9.]+ mm\\): the orientation"));
  const json::object made = printed_document(run.out).as_object();
  int gives_way = 0;
  for (std::size_t i = 0; i < 1500; ++i) {
    const double residual_mm = number(made, "residual_mm", i);
    EXPECT_GE(number(made, "sigma_mm", i), residual_mm);
    gives_way += residual_mm > 0.01;
  }
  EXPECT_TRUE(run.err.starts_with("truepose: " + std::to_string(gives_way) + ' ')) << run.err;
  EXPECT_EQ(compensate({"--joints", file(rows), "--max-orientation-residual", "180",
                        "--max-position-residual", "1000"})
                .exit_code,
            0);
}

TEST_F(Compensate, TakesNoRadiansForDegreesAndNoMetresForMillimetres) {
  const std::string rad =
      std::string(kJoints) + "0.349,-1.396,1.745,0.524,0.785,-0.698\n0.4,-1.3,1.7,0.5,0.8,-0.7\n";
  const std::filesystem::path out = folder_.path() / "joints.csv";
  const Finished refused = compensate({"--joints", file(rad), "--out", out});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err,
              HasSubstr("these look like radians; say which it is by --units rad,mm or --units deg,mm"));
  EXPECT_FALSE(std::filesystem::exists(out));
  const Finished converted = compensate({"--joints", file(rad), "--units", "rad,mm", "--json"});
  EXPECT_THAT(converted.err, HasSubstr("read as: units converted to deg and mm"));
  const json::object of_rad = printed_document(converted.out).as_object();
  const json::object of_deg = document(
      {"--joints", file(std::string(kJoints) + "19.9962,-79.9849,99.9811,30.0230,44.9772,-39.9925\n")});
  EXPECT_LT((joints(of_rad, 0) - joints(of_deg, 0)).cwiseAbs().maxCoeff(), 1e-5);
  const Finished metres = compensate({"--poses", file("x,y,z,a,b,c\n1.6,0.2,1.4,0,90,0\n")});
  EXPECT_EQ(metres.exit_code, 2);
  EXPECT_THAT(metres.err, HasSubstr("row 1: the position is within 10 mm of the middle of the arm's foot"));
}

TEST_F(Compensate, TheBoundAndItsZoneCanBeSet) {
  const std::string targets = file(std::string(kJoints) + kSingularRow);
  const JointVector q = nominal_joints(kSingularRow);
  const auto largest = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"--joints", targets};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return (joints(document(arguments), 0) - q).cwiseAbs().maxCoeff() * kDegPerRad;
  };
  EXPECT_LT(largest({}), 0.5);
  EXPECT_GT(largest({"--singularity-limit", "3"}), 0.5);
  EXPECT_LT(largest({"--singularity-limit", "3"}), 3);
  EXPECT_GT(largest({"--singularity-threshold", "0", "--max-correction", "90"}), 10);
  EXPECT_EQ(compensate({"--joints", targets, "--singularity-limit", "0"}).exit_code, 2);
}

TEST_F(Compensate, ATargetThatOnlyASingularityMakesDifficultIsRefusedWithItsRow) {
  const auto error = [&](const std::string& row, const std::vector<std::string>& options = {}) {
    std::vector<std::string> arguments{"--joints", file(std::string(kJoints) + kRegularRow + row)};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Finished run = compensate(arguments);
    EXPECT_EQ(run.exit_code, 1) << row;
    return run.err;
  };
  EXPECT_THAT(error("20,-130,64.8,30,45,-40\n"),  // the wrist's centre near axis 1
              HasSubstr("row 2: joint 4 would have to be corrected by -18.0 deg"));
  EXPECT_THAT(error("20,-130,65,30,45,-40\n"), HasSubstr("row 2: the calibrated arm cannot reach it"));
  EXPECT_THAT(error(kSingularRow, {"--singularity-threshold", "0"}), HasSubstr("too near to a singularity"));
}

TEST_F(Compensate, TheArmBendsUnderTheGivenPayload) {
  const std::string targets = file(std::string(kJoints) + kRegularRow);
  EXPECT_THAT(compensate({"--joints", targets, "--payload", "60,0,0,200"}).err,
              HasSubstr("--payload: the model has no gravity compliance for a payload"));
  model_.cell.robot.deviation = {{1, DeviationBasis::Gravity, 1, 1e-4}};
  model_.covariance = Eigen::VectorXd::Constant(ParameterLayout::of(model_.cell).size(), 1e-10).asDiagonal();
  folder_.write("model.yaml", config::model_yaml(model_));
  EXPECT_EQ(compensate({"--joints", targets, "--payload", "-1,0,0,200"}).exit_code, 2);
  RobotModel loaded = model_.cell.robot;
  loaded.payload = LinkMass{60, {0, 0, 200}};
  const JointVector q = joints(document({"--joints", targets, "--payload", "60,0,0,200"}), 0);
  const Eigen::Vector3d wanted = forward_kinematics(nominal_, nominal_joints(kRegularRow)).translation();
  EXPECT_LT((forward_kinematics(loaded, q).translation() - wanted).norm(), 1e-5);
  EXPECT_GT((forward_kinematics(model_.cell.robot, q).translation() - wanted).norm(), 0.01);
}

TEST_F(Compensate, AWordIsSaidWhereTheModelKnowsSeveralPayloadsAndNobodySaysWhichIsCarried) {
  const std::string targets = file(std::string(kJoints) + kRegularRow);
  model_.cell.robot.deviation = {{1, DeviationBasis::Gravity, 1, 1e-4}};
  model_.covariance.resize(0, 0);
  model_.several_payloads = true;
  folder_.write("model.yaml", config::model_yaml(model_));
  const std::string said = model_file_ +
                           ": measured under several payloads, and the arm's load is not given: it is "
                           "taken to carry nothing; ";
  EXPECT_THAT(compensate({"--joints", targets}).err, StartsWith(said + "--payload says it\n"));
  EXPECT_THAT(compensate({"--joints", targets, "--payload", "60,0,0,200"}).err,
              testing::Not(HasSubstr("several payloads")));
  EXPECT_EQ(
      run_program("truepose", {"fk", "--robot", kRobot, "--model", model_file_, "--joints", targets}).err,
      said + "give the robot file its payload, and calibrate again\n");
}

TEST_F(Compensate, EveryTargetHasTheStandardDeviationOfItsPosition) {
  const std::string targets = file(std::string(kJoints) + kRegularRow + kSingularRow);
  const json::object found = document({"--joints", targets});
  for (std::size_t i = 0; i < 2; ++i) {
    const double variance = position_covariance(model_.cell, model_.covariance, joints(found, i), 0).trace() +
                            3 * (0.02 * 0.02 + 0.015 * 0.015);
    EXPECT_NEAR(number(found, "sigma_mm", i), std::sqrt(variance), 1e-9);
  }
  EXPECT_FALSE(found.contains("notes"));
  const Finished csv = compensate({"--joints", targets});
  EXPECT_THAT(csv.out, StartsWith("q1,q2,q3,q4,q5,q6,residual_mm,residual_deg,sigma_mm\n"));
  EXPECT_EQ(config::load_joints(folder_.write("again.csv", csv.out), nominal_).size(), 2U);
}

TEST_F(Compensate, AModelWithoutCovarianceGivesNoStandardDeviationAndSaysSoOnce) {
  model_.covariance.resize(0, 0);
  folder_.write("model.yaml", config::model_yaml(model_));
  const std::string targets = file(std::string(kJoints) + kRegularRow + kRegularRow);
  const json::object found = document({"--joints", targets});
  EXPECT_FALSE(found.contains("sigma_mm"));
  EXPECT_EQ(found.at("notes").as_array().size(), 1U);
  const Finished csv = compensate({"--joints", targets});
  EXPECT_EQ(csv.exit_code, 0);
  EXPECT_EQ(csv.err, "truepose: " + model_file_ +
                         ": has no covariance, so no sigma_mm is given; calibrate again to have it\n");
  EXPECT_THAT(csv.out, StartsWith("q1,q2,q3,q4,q5,q6,residual_mm,residual_deg\n"));
}

TEST_F(Compensate, NotesFollowTheRowsWhereBothGoToOneFile) {
  model_.covariance.resize(0, 0);
  folder_.write("model.yaml", config::model_yaml(model_));
  const Finished run = run_into_one_file("truepose", {"compensate", "--robot", kRobot, "--model", model_file_,
                                                      "--joints", file(std::string(kJoints) + kRegularRow)});
  EXPECT_EQ(run.exit_code, 0);
  const std::size_t note = run.out.find("truepose: ");
  ASSERT_NE(note, std::string::npos) << run.out;
  EXPECT_EQ(std::ranges::count(run.out.substr(0, note), '\n'), 2) << run.out;
}

TEST_F(Compensate, PositionsAloneAreReachedFromWhereTheTargetBeforeStood) {
  const json::object found = document(
      {"--poses", file("x,y,z\n1700,0,1500\n1700,5,1500\n1700,10,1500\n"), "--near", "0,-80,100,0,40,0"});
  EXPECT_FALSE(found.contains("residual_deg"));
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d p = forward_kinematics(model_.cell.robot, joints(found, i)).translation();
    EXPECT_LT((p - Eigen::Vector3d(1700, 5.0 * static_cast<double>(i), 1500)).norm(), 1e-8);
    EXPECT_LT((joints(found, i) - joints(found, i > 0 ? i - 1 : 0)).norm(), 0.01);
  }
}

std::string pose_row(const Eigen::Isometry3d& X) {
  const Eigen::Vector3d abc = kuka_abc_deg(X.linear());
  std::ostringstream text;
  text.precision(17);
  text << X(0, 3) << ',' << X(1, 3) << ',' << X(2, 3) << ',' << abc.x() << ',' << abc.y() << ',' << abc.z();
  return text.str();
}

TEST_F(Compensate, StatusAndTurnOrTheNearestJointsSayWhichBranchIsMeant) {
  const JointVector flipped = nominal_joints("20,-80,100,30,-45,-40\n");
  const std::string row = pose_row(forward_kinematics(nominal_, flipped));
  const json::object result = document({"--poses", file("x,y,z,a,b,c,s,t\n" + row + ",6,50\n")});
  EXPECT_LT((joints(result, 0) - flipped).cwiseAbs().maxCoeff(), 3 * kRadPerDeg);
  const std::string plain = file("x,y,z,a,b,c\n" + row + "\n");
  const json::object near = document({"--poses", plain, "--near", "20,-80,100,30,-45,-40"});
  EXPECT_LT((joints(near, 0) - flipped).cwiseAbs().maxCoeff(), 3 * kRadPerDeg);
  const json::object other = document({"--poses", plain, "--near", "20,-80,100,-150,45,140"});
  EXPECT_GT(joints(other, 0)[4], 0);
}

TEST_F(Compensate, PosesOfTheTcpAreThoseOfTheFlangeWithTheTool) {
  const JointVector q = nominal_joints(kRegularRow);
  const Eigen::Isometry3d X_FT = pose_from_kuka({100, 20, 250}, {10, 40, -5});
  const json::object found =
      document({"--poses", file("x,y,z,a,b,c\n" + pose_row(forward_kinematics(nominal_, q) * X_FT) + "\n"),
                "--tool", "100,20,250,10,40,-5", "--near", "20,-80,100,30,45,-40"});
  const json::object by_joints = document({"--joints", file(std::string(kJoints) + kRegularRow)});
  EXPECT_LT((joints(found, 0) - joints(by_joints, 0)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_F(Compensate, AMistakeInAFileIsReportedWithItsRow) {
  const auto error = [&](const char* option, const std::string& text) {
    const Finished run = compensate({option, file(text)});
    EXPECT_EQ(run.exit_code, 2) << text;
    return run.err.substr(run.err.find("targets.csv: ") + 13);
  };
  EXPECT_EQ(error("--joints", ""), "the file is empty, expected a header row\n");
  EXPECT_EQ(error("--joints", kJoints), "no rows of data\n");
  EXPECT_EQ(error("--joints", std::string(kJoints) + kRegularRow + "1,2,3,4,five,6\n"),
            "row 2 (line 3): q5: not a number: 'five'\n");
  EXPECT_EQ(error("--joints", std::string(kJoints) + "1,2,3,4,5,nan\n"),
            "row 1 (line 2): q6: not a finite number: 'nan'\n");
  EXPECT_EQ(error("--joints", std::string(kJoints) + "\n\n1,2,3,4,5\n"),
            "row 1 (line 4): q6: missing, the row ends before it\n");
  EXPECT_EQ(error("--joints", std::string(kJoints) + "1,2,3,4,5,\"6\n"), "line 2: a quote is not closed\n");
  EXPECT_EQ(error("--joints", "q1;q2\n1;2\n"), "missing column 'q3'\n");
  EXPECT_EQ(error("--joints", "q1,q2,q3,q4,q5,q6,q7\n1,2,3,4,5,6,7\n"),
            "unknown column 'q7', did you mean 'q1'?\n");
  EXPECT_EQ(error("--poses", "x,y,z,a,b\n1,2,3,4,5\n"), "missing column 'c'\n");
  EXPECT_EQ(error("--poses", "x,y,z,a,b,c,s\n1765,0,1910,0,90,0,2.5\n"),
            "row 1 (line 2): s: expected a whole number from 0 to 255\n");
  EXPECT_THAT(error("--joints", std::string("q1,q2,\0\xff", 9) + "\n"), HasSubstr("missing column 'q3'"));
}

TEST_F(Compensate, QuotedFieldsOverLinesAndLastRowsWithoutAnEndAreReadAsInWholeFiles) {
  const std::string text =
      "\xEF\xBB\xBFq1,q2,q3,q4,q5,\"q6\"\r\n\r\n20,-80,100,30,\"45\",-40\r20,-80,100,30,45,-40";
  const json::object found = document({"--joints", file(text)});
  ASSERT_EQ(found.at("joints").as_array().size(), 2U);
  EXPECT_EQ(joints(found, 0), joints(found, 1));
}

TEST_F(Compensate, AFileIsReplacedByAWholeOneOrNotAtAll) {
  const std::string out = folder_.write("out.csv", "before");
  const Finished failed =
      compensate({"--joints", file(std::string(kJoints) + kRegularRow + "0,-90,90,0,30,-349.5\n"), "--out",
                  out, "--report", folder_.path() / "report.html"});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(failed.err, HasSubstr("row 2: joint 6 would have to go to -35"));
  EXPECT_EQ(text_of(out), "before");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}),
            3);  // model, targets, out
  EXPECT_EQ(compensate({"--joints", file(std::string(kJoints) + kRegularRow), "--out", out}).exit_code, 0);
  EXPECT_THAT(text_of(out), StartsWith("q1,"));
}

TEST_F(Compensate, RowsOfAPipeAreAnsweredOneByOne) {
  const std::string in = folder_.path() / "in", out = folder_.path() / "out";
  for (const std::string& pipe : {in, out}) ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  Process process(folder_.path(), "truepose",
                  {"compensate", "--robot", kRobot, "--model", model_file_, "--joints", in, "--out", out});
  std::ofstream question(in);
  question << kJoints << std::flush;
  std::ifstream answer(out);
  std::string line;
  std::getline(answer, line);
  EXPECT_THAT(line, StartsWith("q1,q2,q3,q4,q5,q6,residual_mm"));
  for (int i = 0; i < 3; ++i) {
    question << kRegularRow << std::flush;
    ASSERT_TRUE(std::getline(answer, line));
    EXPECT_THAT(line, StartsWith("20."));
  }
  question.close();
  EXPECT_FALSE(std::getline(answer, line));
  EXPECT_EQ(process.wait(), 0) << process.errors();
}

}  // namespace
}  // namespace truepose
