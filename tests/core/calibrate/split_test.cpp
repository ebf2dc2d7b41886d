#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/calibrate/station_split.hpp"
#include "core/data/measurement.hpp"

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

/// Poses of stations one after the other, a reflector's index for each.
MeasurementData stations(const std::vector<std::pair<int, int>>& poses_and_smr) {
  MeasurementData data;
  for (const auto& [poses, smr] : poses_and_smr) {
    const int station = static_cast<int>(data.stations.size());
    data.stations.push_back("s" + std::to_string(station));
    for (int i = 0; i < poses; ++i) {
      Measurement point;
      point.q = JointVector::Constant(3, 100 * station + i);
      point.smr = smr;
      point.station = station;
      data.points.push_back(point);
    }
  }
  return data;
}

int count(const MeasurementData& data, int station, PoseSet set) {
  return static_cast<int>(std::ranges::count_if(
      data.points, [&](const Measurement& point) { return point.station == station && point.set == set; }));
}

TEST(SplitEachStation, DrawsWithinEveryStationAndLeavesItWhatPlacesIt) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    MeasurementData data = stations({{40, 0}, {5, 0}, {3, 0}, {6, 1}});
    split_each_station(data, 0.7, seed);
    EXPECT_EQ(count(data, 0, PoseSet::Identify), 28) << seed;
    EXPECT_EQ(count(data, 1, PoseSet::Identify), 4) << seed;
    EXPECT_EQ(count(data, 2, PoseSet::Identify), 3) << seed;  // fewer place it nowhere
    EXPECT_EQ(count(data, 3, PoseSet::Identify), 5) << seed;  // a reflector that no other station sees
    EXPECT_FALSE(unplaced_station(data)) << seed;
  }
}

TEST(SplitEachStation, OfOneStationIsTheSplitOfItsPoses) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    MeasurementData data = two_reflectors(17), same = data;
    split_each_station(data, 0.7, seed);
    split_poses(same, 0.7, seed);
    for (std::size_t i = 0; i < data.points.size(); ++i) EXPECT_EQ(data.points[i].set, same.points[i].set);
    hold_out_fold_of_each_station(data, 5, 3, seed);
    hold_out_fold(same, 5, 3, seed);
    for (std::size_t i = 0; i < data.points.size(); ++i) EXPECT_EQ(data.points[i].set, same.points[i].set);
  }
}

TEST(SplitEachStation, KeepsAPoseTogetherThatSeveralSaw) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    MeasurementData data = stations({{20, 0}, {5, 0}});
    for (std::size_t k = 0; k < 5; ++k) data.points[20 + k].q = data.points[3 * k].q;
    split_each_station(data, 0.5, seed);
    for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(data.points[20 + k].set, data.points[3 * k].set);
    EXPECT_EQ(count(data, 1, PoseSet::Identify), 3) << seed;
  }
}

TEST(HoldOutFoldOfEachStation, LetsEveryPoseValidateOnceAndSpreadsEachStationOverTheFolds) {
  constexpr int kFolds = 4;
  const MeasurementData measured = stations({{9, 0}, {6, 0}, {7, 0}});
  std::vector<int> validated(measured.points.size());
  for (int fold = 0; fold < kFolds; ++fold) {
    MeasurementData data = measured;
    hold_out_fold_of_each_station(data, kFolds, fold, 3);
    int all = 0;
    for (int station = 0; station < 3; ++station) {
      const int held_out = count(data, station, PoseSet::Validate);
      const int poses = held_out + count(data, station, PoseSet::Identify);
      EXPECT_TRUE(held_out == poses / kFolds || held_out == poses / kFolds + 1) << held_out;
      all += held_out;
    }
    EXPECT_TRUE(all == 5 || all == 6) << all;
    for (std::size_t i = 0; i < validated.size(); ++i)
      validated[i] += data.points[i].set == PoseSet::Validate;
  }
  EXPECT_EQ(validated, std::vector<int>(measured.points.size(), 1));
}

TEST(UnplacedStation, IsReportedByItsNameAndWhatItLacks) {
  MeasurementData data = stations({{40, 0}, {3, 0}});
  EXPECT_FALSE(unplaced_station(data));
  data.points.back().set = PoseSet::Validate;
  EXPECT_EQ(unplaced_station(data), "station 's1': 2 of its 3 poses are left to identify, and 3 place it");
  EXPECT_FALSE(unplaced_station(two_reflectors(1)));
}

}  // namespace
}  // namespace truepose
