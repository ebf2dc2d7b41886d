#include "daemon/campaign/stored_model.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <functional>

#include "core/compensate/largest_correction.hpp"
#include "core/formatted.hpp"
#include "core/math/units.hpp"
#include "daemon/store/store.hpp"
#include "proto/text/digest.hpp"
#include "tests/daemon/example_calibration.hpp"
#include "tests/daemon/example_cell.hpp"

namespace truepose::daemon {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

/// A model as a sound campaign stores it, and what may become of it.
struct StoredModelTest : testing::Test {
  StoredModelTest() {
    made.id = "m1";
    made.robot_serial = file.serial = "S1";
    file.name = config.robot.model.name;
    file.cell = result.as<CalibrationResult>().calibration.cell;
    file.validation_mean_mm = made.validation_after_mm =
        result.as<CalibrationResult>().calibration.validate->after.mean;
    made.validation_before_mm = result.as<CalibrationResult>().calibration.validate->before.mean;
    made.largest_correction_deg =
        largest_correction(config.robot.model, file.cell, poses_of_task(result.points)) * kDegPerRad;
    made.yaml = config::model_yaml(file);
    made.sha256 = text::sha256_hex(made.yaml);
  }
  std::string refusal(const ModelRecord& record) {
    const auto checked = checked_model(record, result.points, config);
    return checked ? "" : checked.error();
  }
  /// The same model with something changed in it, and its row as it was.
  ModelRecord altered(const std::function<void(CalibratedCell&)>& change) {
    config::ModelFile other = file;
    change(other.cell);
    ModelRecord record = made;
    record.yaml = config::model_yaml(other);
    return record;
  }

  config::CellConfig config = test::example_cell();
  CampaignResult result = test::example_calibration();
  config::ModelFile file;
  ModelRecord made;
};

TEST_F(StoredModelTest, IsTakenAsItWasMade) {
  const auto checked = checked_model(made, result.points, config);
  ASSERT_TRUE(checked) << checked.error();
  EXPECT_THAT(checked->unchecked, IsEmpty());
  EXPECT_EQ(checked->file.cell.robot.joints[1].theta_rad, file.cell.robot.joints[1].theta_rad);
  EXPECT_GT(made.largest_correction_deg, 0.1);
  EXPECT_LT(made.largest_correction_deg, 10) << "every pose can be corrected";
}

TEST_F(StoredModelTest, IsTakenWherePointsOfAReflectorWereLeftOutThatWasNotIdentified) {
  const auto validates = std::ranges::find(result.points, PointPurpose::Validate, &StoredPoint::purpose);
  ASSERT_NE(validates, result.points.end());
  StoredPoint other = *validates;
  other.smr = "another";
  other.p_WS_mm->x() += 100;
  result.points.push_back(other);
  EXPECT_EQ(refusal(made), "");
}

TEST_F(StoredModelTest, IsRefusedWhicheverOfItsDigitsIsAnother) {
  int digits = 0;
  for (std::size_t i = 0; i < made.yaml.size(); ++i) {
    if (std::isdigit(static_cast<unsigned char>(made.yaml[i])) == 0) continue;
    ModelRecord flipped = made;
    flipped.yaml[i] = made.yaml[i] == '9' ? '0' : static_cast<char>(made.yaml[i] + 1);
    EXPECT_THAT(refusal(flipped),
                AllOf(HasSubstr("model m1 is refused"), HasSubstr("SHA-256"), HasSubstr("identify again")))
        << "byte " << i;
    ++digits;
  }
  EXPECT_GT(digits, 500);
}

/// What the review altered in a model, and what an altered row says of it.
struct Alteration {
  const char* name;
  std::function<void(CalibratedCell&)> change;
};
const Alteration kAlterations[] = {
    {"a zero of axis 1 that is 0.04 rad off",
     [](CalibratedCell& cell) { cell.robot.joints[0].theta_rad += 0.04; }},
    {"d4 that is 30 mm too long", [](CalibratedCell& cell) { cell.robot.joints[3].d_mm += 30; }},
    {"an arm of 1950 in place of 1150 mm", [](CalibratedCell& cell) { cell.robot.joints[2].a_mm += 800; }},
    {"a sign that is turned round", [](CalibratedCell& cell) { cell.robot.joints[4].alpha_rad *= -1; }},
};

TEST_F(StoredModelTest, IsRefusedWhereOnlyTheHashOfItsRowIsThatOfAChangedText) {
  made.yaml.at(made.yaml.find("theta: 0.") + 9) = '7';
  made.sha256 = text::sha256_hex(made.yaml);
  EXPECT_EQ(refusal(made),
            "model m1 is refused: its text is not the one that was made (its last line has another SHA-256); "
            "activate another model, or identify again");
}

TEST_F(StoredModelTest, IsRefusedWhereItIsWrongEvenWithItsHash) {
  for (const Alteration& alteration : kAlterations) {
    ModelRecord record = altered(alteration.change);
    EXPECT_THAT(refusal(record), HasSubstr("SHA-256")) << alteration.name;
    record.sha256 = text::sha256_hex(record.yaml);
    EXPECT_THAT(refusal(record),
                AllOf(HasSubstr("misses its own validation points by"), HasSubstr("when it was made")))
        << alteration.name;
  }
}

TEST_F(StoredModelTest, IsRefusedWhereItCorrectsMoreThanItSaidWhenItWasMade) {
  // A base that turns with the arm: the points are hit as before, and the correction is another.
  ModelRecord record = altered([](CalibratedCell& cell) {
    cell.robot.joints[0].theta_rad += 0.04;
    const Eigen::Isometry3d X_WB = cell.base.isometry() * Eigen::AngleAxisd(-0.04, Eigen::Vector3d::UnitZ());
    cell.base = BasePose::of(X_WB);
  });
  record.sha256 = text::sha256_hex(record.yaml);
  EXPECT_THAT(refusal(record),
              AllOf(HasSubstr("it corrects a joint by up to"), HasSubstr("when it was made")));
}

TEST_F(StoredModelTest, IsRefusedForThePoseThatLiesOutsideLimitsThatWereNarrowed) {
  const auto& farthest = *std::ranges::max_element(
      result.points, {}, [](const StoredPoint& point) { return point.q_target[0]; });
  const double q_deg = farthest.q_target[0] * kDegPerRad;
  config.robot.model.joints[0].max = (q_deg - 1) * kRadPerDeg;
  EXPECT_EQ(
      refusal(made),
      formatted("model m1 is refused: pose %d, which it was made from, lies outside the limits of the robot "
                "file: joint 1 at %.3f deg, its limits are -185..%g deg; widen them, activate another model, "
                "or measure again",
                farthest.pose, q_deg, q_deg - 1));
}

TEST_F(StoredModelTest, IsRefusedWithAnotherRobotFileThanItWasIdentifiedFrom) {
  file.parameters = result.as<CalibrationResult>().calibration.parameters;
  made.yaml = config::model_yaml(file);
  made.sha256 = text::sha256_hex(made.yaml);
  EXPECT_EQ(refusal(made), "");
  config.robot.model.joints[2].a_mm += 10;
  EXPECT_THAT(refusal(made), HasSubstr("link3.a: 1150 mm in the model, 1160 mm in the robot file"));
}

TEST_F(StoredModelTest, SaysWhatCouldNotBeCheckedWithoutItsPoints) {
  const auto checked = checked_model(made, {}, config);
  ASSERT_TRUE(checked) << checked.error();
  EXPECT_THAT(checked->unchecked, HasSubstr("the points of its campaign are not in this store"));
}

TEST_F(StoredModelTest, IsRefusedWithoutAWordOfParsersWhereItsTextOrItsRowIsOfAnother) {
  ModelRecord broken = made;
  broken.yaml.resize(broken.yaml.size() / 2);
  broken.sha256 = text::sha256_hex(broken.yaml);
  EXPECT_THAT(refusal(broken),
              AllOf(HasSubstr("model m1 is refused: its text"), HasSubstr("identify again")));
  ModelRecord of_another = made;
  of_another.robot_serial = "S2";
  EXPECT_THAT(refusal(of_another), HasSubstr("its text is of arm S1, its row of arm S2"));
  for (StoredPoint& point : result.points) point.q_target.conservativeResize(5);
  EXPECT_THAT(refusal(made), HasSubstr("other joints"));
}

}  // namespace
}  // namespace truepose::daemon
