// One arm measured by a tracker from several stations, through the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "tests/process.hpp"
#include "tests/report_schema.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int kFresh = 12;  // poses that validate, behind those that identify

class StationsCommand : public testing::Test {
 protected:
  StationsCommand() {
    truth_.robot.joints[1].a_mm += 0.8;
    truth_.robot.joints[4].theta_rad += 1e-3;
    truth_.reflectors = {{"1", {62, -48, 187}}};
    write(hall_, truth_.base, 30);
    write(door_, door_base_, 15);
  }

  /// @param scale  of the tracker's readings
  /// @param change  of what was measured
  void write(const std::string& file, const BasePose& base, int poses, double scale = 1,
             const std::function<void(std::vector<Measurement>&)>& change = {}) {
    MeasurementData data{.smr_names = {"1"}};
    CalibratedCell cell = truth_;
    cell.base = base;
    for (const JointVector& q : random_poses(truth_.robot, poses + kFresh, random_)) {
      const Eigen::Vector3d noise_mm(random_.normal(), random_.normal(), random_.normal());
      const bool identifies = static_cast<int>(data.points.size()) < poses;
      data.points.push_back({.q = q,
                             .p_WS_mm = scale * (cell.predict(q, 0) + 0.02 * noise_mm),
                             .set = identifies ? PoseSet::Identify : PoseSet::Validate});
    }
    if (change) change(data.points);
    std::ofstream out(file);
    config::write_measurements(out, data, truth_.robot);
  }

  Finished calibrate(std::vector<std::string> options) {
    options.insert(options.begin(), {"calibrate", "--robot", kRobot, "--data", hall_, "--data", door_});
    return run_program("truepose", options);
  }

  TempFolder folder_;
  std::string hall_ = folder_.path() / "hall.csv", door_ = folder_.path() / "door, day 2.csv";
  CalibratedCell truth_{.robot = config::load_robot(kRobot),
                        .base = {{3200, -1450, 780}, {0.01, -0.02, 2.4}},
                        .reflectors = {}};
  BasePose door_base_{{-900, 2700, 500}, {-0.02, 0.01, -0.7}};
  Random random_{20260601};
};

TEST_F(StationsCommand, IdentifiesOneArmFromAllAndTellsTheErrorsOfEach) {
  const Finished run = calibrate({"--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value document = printed_document(run.out);
  EXPECT_EQ(document.at("identify").at("poses"), 45);
  EXPECT_EQ(document.at("rank"), 33);
  const json::array& stations = document.at("stations").as_array();
  ASSERT_EQ(stations.size(), 2U);
  EXPECT_EQ(stations[0].at("name"), json::string(hall_));
  EXPECT_EQ(stations[0].at("base"), document.at("base"));
  EXPECT_EQ(stations[1].at("identify").at("poses"), 15);
  for (const json::value& station : stations) {
    EXPECT_EQ(station.at("validate").at("poses"), kFresh);
    EXPECT_LT(station.at("validate").at("after").at("mean").to_number<double>(), 0.08);
  }
  EXPECT_NEAR(stations[1].at("base").at("x").to_number<double>(), door_base_.p_mm.x(), 2);
  EXPECT_EQ(document.at("points").at(50).at("station"), json::string(door_));
  EXPECT_EQ(report_schema_errors({folder_.write("report.json", run.out)}), "");
}

TEST_F(StationsCommand, TheModelIsThatOfTheFirstAndSaysSo) {
  const std::string file = folder_.path() / "model.yaml";
  const Finished run = calibrate({"--out", file});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const config::ModelFile model = config::load_model(file);
  EXPECT_EQ(model.station, hall_);
  EXPECT_EQ(model.cell.station_count(), 1);
  EXPECT_EQ(model.covariance.rows(), 39);
  EXPECT_EQ(model.parameters.size(), 39U);
  for (const JointVector& q : random_poses(truth_.robot, 20, random_))
    EXPECT_LT((model.cell.predict(q, 0) - truth_.predict(q, 0)).norm(), 0.15);
}

TEST_F(StationsCommand, AMistakeIsReportedForTheFileThatHasIt) {
  write(door_, door_base_, 30, 1 / 25.4);
  const Finished run = calibrate({});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, StartsWith("truepose: " + door_ + ": "));
}

TEST_F(StationsCommand, ARowIsReportedWithItsFile) {
  constexpr double kEvery_s = 60;
  const auto measured_at = [](double start_s) {
    return [=](std::vector<Measurement>& points) {
      for (std::size_t i = 0; i < points.size(); ++i)
        points[i].time = std::to_string(start_s + kEvery_s * static_cast<double>(i));
    };
  };
  write(hall_, truth_.base, 30, 1, measured_at(1e6));
  write(door_, door_base_, 15, 1, [&](std::vector<Measurement>& points) {
    measured_at(2e6)(points);
    points[3].p_WS_mm.x() += 30;
    points[20].p_WS_mm.x() += 30;
    for (std::size_t i = 8; i < points.size(); ++i)
      points[i].time = std::to_string(2e6 - 3600 + kEvery_s * static_cast<double>(i));
  });
  const Finished run = calibrate({});
  EXPECT_THAT(run.out, HasSubstr("contradict the others and were left out: row 4 of '" + door_ + "' ("));
  EXPECT_THAT(run.out, HasSubstr("mm: row 21 of '" + door_ + "' ("));
  EXPECT_THAT(run.out, HasSubstr("between row 8 of '" + door_ + "' and row 9 of '" + door_ + "'"));
}

TEST_F(StationsCommand, FewPosesOfOneAreNotAllDrawnToValidate) {
  const auto without_marks = [](std::vector<Measurement>& points) {
    for (Measurement& point : points) point.set = PoseSet::Identify;
  };
  write(hall_, truth_.base, 30, 1, without_marks);
  write(door_, door_base_, 5 - kFresh, 1, without_marks);  // five in all
  for (int seed = 0; seed < 20; ++seed) {
    const Finished run = calibrate({"--split", "0.7", "--seed", std::to_string(seed)});
    EXPECT_NE(run.exit_code, 2) << "seed " << seed << ": " << run.err;
    EXPECT_THAT(run.out, HasSubstr(door_ + ": 4 poses, mean error ")) << "seed " << seed;
  }
  EXPECT_NE(calibrate({"--folds", "5"}).exit_code, 2);
  const Finished run = calibrate({"--folds", "2"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err,
            "truepose: --folds: station '" + door_ +
                "': 2 of its 5 poses are left to identify, and 3 place it: use --split, which leaves "
                "it so many\n");
}

TEST_F(StationsCommand, APointToValidateNeedsItsStation) {
  const Finished run = calibrate({"--validate", hall_});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err,
              HasSubstr("--validate: does not say its station. Mark points of each --data set=validate"));
}

}  // namespace
}  // namespace truepose
