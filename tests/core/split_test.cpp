#include <gtest/gtest.h>

#include <map>

#include "core/identify/measurement.hpp"

namespace truepose {
namespace {

/// `poses` poses of two reflectors, all points of one reflector before those of the other.
MeasurementData two_reflectors(int poses) {
  MeasurementData data{.smr_names = {"1", "2"}, .points = {}};
  for (int smr = 0; smr < 2; ++smr) {
    for (int i = 0; i < poses; ++i) {
      Measurement point;
      point.q = JointVector::Constant(3, i);
      point.smr = smr;
      data.points.push_back(point);
    }
  }
  return data;
}

TEST(SplitPoses, KeepsThePointsOfAPoseTogether) {
  MeasurementData data = two_reflectors(10);
  split_poses(data, 0.7, 5);
  int identify = 0;
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(data.points[i].set, data.points[i + 10].set);
    identify += data.points[i].set == PoseSet::Identify;
  }
  EXPECT_EQ(identify, 7);
}

TEST(SplitPoses, DependsOnTheSeedAlone) {
  const auto split = [](std::uint64_t seed) {
    MeasurementData data = two_reflectors(20);
    split_poses(data, 0.5, seed);
    std::vector<PoseSet> sets;
    for (const Measurement& point : data.points) sets.push_back(point.set);
    return sets;
  };
  EXPECT_EQ(split(1), split(1));
  EXPECT_NE(split(1), split(2));
}

TEST(SplitPoses, GivesEveryPoseTheSameChance) {
  std::map<std::size_t, int> identified;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    MeasurementData data = two_reflectors(5);
    split_poses(data, 0.4, seed);
    for (std::size_t i = 0; i < 5; ++i) identified[i] += data.points[i].set == PoseSet::Identify;
  }
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(identified[i], 800, 100) << i;
}

TEST(SplitPoses, OverwritesEarlierMarks) {
  MeasurementData data = two_reflectors(4);
  for (Measurement& point : data.points) point.set = PoseSet::Validate;
  split_poses(data, 1, 0);
  for (const Measurement& point : data.points) EXPECT_EQ(point.set, PoseSet::Identify);
}

TEST(HoldOutFold, LetsEveryPoseValidateOnceWithAllItsReflectors) {
  MeasurementData data = two_reflectors(11);
  std::vector<int> validated(11);
  for (int fold = 0; fold < 4; ++fold) {
    hold_out_fold(data, 4, fold, 7);
    int held_out = 0;
    for (std::size_t i = 0; i < 11; ++i) {
      EXPECT_EQ(data.points[i].set, data.points[i + 11].set);
      held_out += data.points[i].set == PoseSet::Validate;
      validated[i] += data.points[i].set == PoseSet::Validate;
    }
    EXPECT_TRUE(held_out == 2 || held_out == 3) << held_out;
  }
  EXPECT_EQ(validated, std::vector<int>(11, 1));
}

TEST(HoldOutFold, DependsOnTheSeed) {
  const auto first_fold = [](std::uint64_t seed) {
    MeasurementData data = two_reflectors(20);
    hold_out_fold(data, 4, 0, seed);
    std::vector<PoseSet> sets;
    for (const Measurement& point : data.points) sets.push_back(point.set);
    return sets;
  };
  EXPECT_EQ(first_fold(1), first_fold(1));
  EXPECT_NE(first_fold(1), first_fold(2));
}

}  // namespace
}  // namespace truepose
