#include <gmock/gmock.h>

#include "tests/drivers/leica/emscon_fixture.hpp"

namespace truepose::drivers {
namespace {

using namespace emscon;
using enum CommandCode;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// A tracker with two faces, that loses its reflector where it turns over.
class EmsconFaceTest : public EmsconTrackerTest {
 protected:
  EmsconFaceTest() {
    fake.kept[GetFace] = FaceAnswer{1};
    fake.script(ChangeFace, [this] {
      std::get<FaceAnswer>(fake.kept[GetFace]).face = 3 - face();
      lock(false);
      fake.answer(ChangeFace);
    });
    fake.script(FindReflector, [this] {
      lock(true);
      fake.answer(FindReflector);
    });
  }
  auto turn_over() { return run(tracker.turn_over({})); }
  std::int32_t face() { return std::get<FaceAnswer>(fake.kept[GetFace]).face; }
  void lock(bool locked) {
    fake.kept[GetMeasurementStatusInfo] = MeasurementStatusInfo{0, locked ? kReflectorFoundBit : 0};
  }
};

TEST_F(EmsconFaceTest, ComesToTheSameReflectorFromTheOtherFace) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  EXPECT_THAT(fake.commands, Not(Contains(ChangeFace)));
  const auto turned = turn_over();
  ASSERT_TRUE(turned) << turned.error().detail;
  EXPECT_EQ(face(), 2);
  expect_point();
  ASSERT_TRUE(turn_over());
  EXPECT_EQ(face(), 1);
}

TEST_F(EmsconFaceTest, AimsInFaceOneAgainWhateverCameBetween) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  ASSERT_TRUE(turn_over());
  tracker.disconnect();
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  EXPECT_EQ(face(), 1);
  ASSERT_TRUE(aim());
  EXPECT_EQ(count(ChangeFace), 2);
}

TEST_F(EmsconFaceTest, SaysSoWhereTheTrackerDoesNotTurnOver) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  fake.unscript(ChangeFace);
  const auto stays = turn_over();
  expect_fault(stays, TrackerFault::Refused);
  EXPECT_THAT(stays.error().detail, HasSubstr("does not come into face 2"));
}

TEST_F(EmsconFaceTest, FindsNoReflectorFromTheOtherFaceWhereNoneIsSeenFromThere) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  fake.script(FindReflector, [this] { fake.answer(FindReflector, 20002); });
  expect_fault(turn_over(), TrackerFault::NoTarget);
}

TEST_F(EmsconFaceTest, TurnsOverNothingThatIsNotLocked) {
  ASSERT_TRUE(connect());
  lock(false);
  expect_fault(turn_over(), TrackerFault::NoTarget);
  EXPECT_THAT(fake.commands, Not(Contains(ChangeFace)));
}

TEST_F(EmsconFaceTest, AveragesOverTheConfiguredTimeFromTheNextMeasurementOn) {
  ASSERT_TRUE(connect());
  tracker.average_over(std::chrono::seconds{6});
  EXPECT_EQ(fake.kept[GetStationaryModeParams], (Body{StationaryModeParams{1500, true}}));
  expect_point();
  EXPECT_EQ(fake.kept[GetStationaryModeParams], (Body{StationaryModeParams{6000, true}}));
  ASSERT_TRUE(connect());
  EXPECT_EQ(fake.kept[GetStationaryModeParams], (Body{StationaryModeParams{6000, true}}));
}

}  // namespace
}  // namespace truepose::drivers
