#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// The shipped robot file, and what is measured of an arm with the paper's errors.
class RobotFixCommand : public testing::Test {
 protected:
  RobotFixCommand() {
    const CalibratedCell truth{
        published_arm(), {{2500, -300, 400}, {0.1, -0.2, 0.7}}, {{"1", {90, 60, 120}}}};
    Random random{1};
    data_.smr_names = {"1"};
    for (int row = 1; row <= 40; ++row) {
      JointVector q(6);
      for (Eigen::Index i = 0; i < 6; ++i) {
        const Joint& joint = nominal_.joints[static_cast<std::size_t>(i)];
        q[i] = random.uniform(joint.min, joint.max);
      }
      data_.points.push_back({.q = q, .p_WS_mm = truth.predict(q, 0), .row = row});
    }
  }
  std::string data_file() {
    std::ostringstream text;
    config::write_measurements(text, data_, nominal_);
    return folder_.write("points.csv", text.str());
  }
  std::string path(const std::string& name) { return folder_.path() / name; }

  TempFolder folder_;
  RobotModel nominal_ = config::load_robot(kRobot);
  MeasurementData data_;
};

TEST_F(RobotFixCommand, FixesMeasurementsWhereTheMistakeIsInThem) {
  for (Measurement& point : data_.points) point.p_WS_mm /= 1000;
  const std::string robot = kRobot, data = data_file();
  const Finished refused =
      run_program("truepose", {"robot", "fix", robot, data, "--out", path("fixed.yaml")});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, StartsWith("truepose: " + data +
                                      ": x, y, z: the points are in m, not mm: with them "
                                      "converted the coarse error falls"));
  EXPECT_THAT(refused.err, HasSubstr("where --out-data says"));
  EXPECT_FALSE(std::filesystem::exists(path("fixed.yaml")));
  EXPECT_EQ(run_program("truepose", {"robot", "fix", robot, data, "--out-data", path("mm.csv")}).exit_code,
            0);
  EXPECT_EQ(
      run_program("truepose", {"calibrate", "--robot", robot, "--data", path("mm.csv"), "--split", "0.7"})
          .exit_code,
      0);
}

}  // namespace
}  // namespace truepose
