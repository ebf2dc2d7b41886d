#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "daemon/campaign/corrected_points.hpp"
#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

/// Campaigns with further measurements of a tracker: nests, both faces, longer readings where it scatters.
struct TrackerCampaignTest : CampaignTest {
  TrackerCampaignTest() {
    config.campaign.identify_poses = 24;
    config.campaign.reference_every = config::CampaignConfig{}.reference_every;
    config.campaign.remeasure = false;
    truth.instrument.nests_mm = {
        {1500, -1400, -800}, {1800, 1500, -700}, {3200, -300, -1200}, {2500, 900, 600}};
    for (const Eigen::Vector3d& p_mm : truth.instrument.nests_mm)
      config.tracker.nests_mm.push_back(p_mm + Eigen::Vector3d{40, -30, 20});
    config.tracker.noise = {.range_mm = 0.01, .transverse_mm = 0.01};
  }

  const CampaignResult& run() {
    start();
    EXPECT_TRUE(go_on());
    if (!*outcome) throw std::runtime_error{outcome->error().detail};
    return ***outcome;
  }
  /// The tracker is moved once the arm's n-th point is measured.
  void bump_after(int n, const Eigen::Vector3d& by_mm) {
    observer.at_point = [this, n, by_mm, seen = 0](const StoredPoint&) mutable {
      if (++seen == n) cell->bump_tracker(by_mm);
    };
  }
  std::vector<StoredPoint> points_for(const CampaignResult& result, PointPurpose purpose) {
    std::vector<StoredPoint> points;
    for (const StoredPoint& point : result.points)
      if (point.purpose == purpose) points.push_back(point);
    return points;
  }
  static double validated_rms_mm(const CampaignResult& result) {
    return result.as<CalibrationResult>().calibration.validate->after.rms;
  }
  /// The same over some cells, each put into its state by `prepare`: of one alone chance says as much.
  double over_cells_mm(const std::function<void()>& prepare = [] {}) {
    constexpr int kCells = 8;
    double squares = 0;
    for (int n = 0; n < kCells; ++n) {
      truth.seed = 100 + static_cast<std::uint64_t>(n);
      prepare();
      squares += std::pow(validated_rms_mm(run()), 2) / kCells;
    }
    return std::sqrt(squares);
  }
  static std::vector<std::string> sentences(const CampaignResult& result) {
    std::vector<std::string> all;
    for (const Finding& finding : result.as<CalibrationResult>().verdict.findings)
      all.push_back(finding.sentence);
    return all;
  }
};

TEST_F(TrackerCampaignTest, TheNestsAreMeasuredFirstEverySoManyPosesAndLast) {
  const CampaignResult& result = run();
  ASSERT_FALSE(result.points.empty());
  EXPECT_EQ(result.points.front().purpose, PointPurpose::Nest);
  EXPECT_EQ(result.points.back().purpose, PointPurpose::Nest);
  std::vector<int> checks;
  for (const StoredPoint& nest : points_for(result, PointPurpose::Nest))
    if (checks.empty() || checks.back() != nest.pose) checks.push_back(nest.pose);
  // 24 + 12 poses and 5 references.
  EXPECT_THAT(checks, SizeIs(6));
  EXPECT_THAT(points_for(result, PointPurpose::Nest), SizeIs(24));
  EXPECT_EQ(result.points[2].smr, "nest 3");
  EXPECT_THAT(journal.points, SizeIs(result.points.size())) << "each is kept before the arm moves on";
  EXPECT_FALSE(result.as<CalibrationResult>().verdict.failed());
  EXPECT_THAT(sentences(result), Not(Contains(HasSubstr("the tracker moved"))));
}

TEST_F(TrackerCampaignTest, WithoutNestsOnlyPosesAreMeasured) {
  config.tracker.nests_mm.clear();
  EXPECT_THAT(points_for(run(), PointPurpose::Nest), IsEmpty());
}

TEST_F(TrackerCampaignTest, ATripodThatSlipsByATwentiethOfAMillimetreIsFoundNamedAndCorrected) {
  const double undisturbed_mm = over_cells_mm();
  const double slipped_mm = over_cells_mm([this] { bump_after(20, {0.03, 0.04, 0}); });
  EXPECT_LT(slipped_mm, 1.1 * undisturbed_mm);
  bump_after(20, {0.03, 0.04, 0});
  const CampaignResult& result = run();
  EXPECT_THAT(sentences(result), Contains(HasSubstr("of the nests the tracker moved: it stands 0.0")));
  EXPECT_FALSE(result.as<CalibrationResult>().verdict.failed());
}

TEST_F(TrackerCampaignTest, ATripodThatSlipsFarIsCorrectedButForThePosesAboutThatMoment) {
  config.campaign.identify_poses = 30;
  const double undisturbed_mm = over_cells_mm();
  const double slipped_mm = over_cells_mm([this] { bump_after(20, {3, 4, 0}); });
  EXPECT_LT(slipped_mm, 1.3 * undisturbed_mm) << "from 10 poses fewer";
  bump_after(20, {3, 4, 0});
  const CampaignResult& result = run();
  EXPECT_THAT(sentences(result), Contains(HasSubstr("the tracker moved: it stands ")));
  EXPECT_THAT(sentences(result), Contains(HasSubstr("10 poses that were measured while the tracker moved")));
  EXPECT_THAT(result.as<CalibrationResult>().calibration.rejected, IsEmpty());
  EXPECT_FALSE(result.as<CalibrationResult>().verdict.failed());
}

TEST_F(TrackerCampaignTest, APoseIsLeftOutOnceHoweverManyReflectorsItWasMeasuredBy) {
  config.campaign.identify_poses = 30;
  bump_after(20, {3, 4, 0});
  std::vector<StoredPoint> points;
  for (const StoredPoint& point : run().points) {
    points.push_back(point);
    if (point.purpose != PointPurpose::Identify) continue;
    points.push_back(point);
    points.back().smr = "another";
  }
  EXPECT_THAT(corrected_points(points, config).findings,
              Contains(testing::Field(&truepose::Finding::sentence,
                                      HasSubstr("10 poses that were measured while the tracker moved"))));
}

TEST_F(TrackerCampaignTest, WhatTheNestsShowIsDoubtWhereItIsNotToBeCorrected) {
  config.campaign.correct_by_nests = false;
  bump_after(20, {0.3, 0.4, 0});
  const CampaignResult& result = run();
  EXPECT_TRUE(result.as<CalibrationResult>().verdict.failed());
  EXPECT_THAT(sentences(result), Contains(HasSubstr("of the nests the tracker moved")));
  const auto& raw = result.points;
  const auto corrected = corrected_points(raw, config).points;
  EXPECT_EQ(corrected.back().p_WS_mm, raw[raw.size() - config.tracker.nests_mm.size() - 1].p_WS_mm);
}

TEST_F(TrackerCampaignTest, ANestThatIsNeverSeenStopsNothing) {
  config.tracker.nests_mm[1] += Eigen::Vector3d{0, 900, 0};
  const CampaignResult& result = run();
  EXPECT_THAT(observer.troubles, Contains(HasSubstr("nest 2: tracker: no reflector found")));
  EXPECT_THAT(points_for(result, PointPurpose::Nest), SizeIs(18));
  EXPECT_FALSE(result.as<CalibrationResult>().verdict.failed());
}

TEST_F(TrackerCampaignTest, BothFacesTakeTheTrackersErrorsOfAimOutOfTheModel) {
  config.tracker.nests_mm.clear();
  const double undisturbed_mm = validated_rms_mm(run());
  truth.instrument.aiming = {.collimation = 60e-6, .tilt = -90e-6, .index = 45e-6};
  const double disturbed_mm = validated_rms_mm(run());
  config.campaign.two_face_every = 1;
  const CampaignResult& result = run();
  EXPECT_THAT(sentences(result), Contains(HasSubstr("in one face the tracker errs by up to 0.")));
  EXPECT_EQ(points_for(result, PointPurpose::Face1).size() * 2, result.points.size());
  EXPECT_LT(validated_rms_mm(result), 1.1 * undisturbed_mm);
  EXPECT_GT(disturbed_mm, 1.1 * undisturbed_mm);
}

TEST_F(TrackerCampaignTest, APointInBothFacesScattersAsTheirMeanDoesAndFace1AsItDid) {
  config.tracker.nests_mm.clear();
  config.campaign.two_face_every = 2;
  const double one_mm = truth.noise.range_mm;  // what the tracker says of each reading
  const CampaignResult& result = run();
  for (const StoredPoint& point : result.points) {
    const bool is_mean = point.purpose != PointPurpose::Face1 && point.pose % 2 == 0;
    EXPECT_NEAR(point.std_mm.x(), is_mean ? one_mm * std::sqrt(0.5) : one_mm, 1e-9) << "pose " << point.pose;
  }
  EXPECT_THAT(points_for(result, PointPurpose::Face1), testing::Not(testing::IsEmpty()));
}

TEST_F(TrackerCampaignTest, OneFaceIsPutRightByTheOtherOfEveryFifthPose) {
  config.tracker.nests_mm.clear();
  const double undisturbed_mm = over_cells_mm();
  truth.instrument.aiming = {.collimation = 60e-6, .tilt = -90e-6, .index = 45e-6};
  config.campaign.two_face_every = 5;
  EXPECT_LT(points_for(run(), PointPurpose::Face1).size(), 10U);
  EXPECT_LT(over_cells_mm(), 1.1 * undisturbed_mm);
}

TEST_F(TrackerCampaignTest, APointThatScattersIsMeasuredLongerBeforeItIsGivenUp) {
  truth.faults.scattering = 0.3;
  const CampaignResult& result = run();
  EXPECT_THAT(observer.troubles, Contains(HasSubstr("scatter by 3.000 mm, allowed are 5 times")));
  EXPECT_THAT(observer.troubles, Contains(HasSubstr("measuring it 4 times as long")));
  for (const StoredPoint& point : result.points) EXPECT_LT(point.std_mm.maxCoeff(), 0.1);
}

TEST_F(TrackerCampaignTest, APointThatScattersMoreThanOthersCountsForLess) {
  std::vector<StoredPoint> points = run().points;
  const auto of_pose = [](const MeasurementData& data, int pose) {
    return std::ranges::find(data.points, pose, &Measurement::pose)->excess_mm;
  };
  for (const Measurement& point : campaign_data(points, config).points) EXPECT_EQ(point.excess_mm, 0);
  const auto loose = std::ranges::find(points, PointPurpose::Identify, &StoredPoint::purpose);
  loose->std_mm *= 1.9;
  EXPECT_EQ(of_pose(campaign_data(points, config), loose->pose), 0) << "that comes by chance";
  loose->std_mm *= 4 / 1.9;
  // Four times the 0.01 mm of the tracker, which are in the noise model already.
  EXPECT_NEAR(of_pose(campaign_data(points, config), loose->pose), 0.01 * std::sqrt(15), 1e-6);
}

TEST_F(TrackerCampaignTest, TheGreatestSpreadMayBeStated) {
  config.tracker.max_std_mm = 0.001;
  config.campaign.pause_after_lost = 0;
  start();
  ASSERT_TRUE(go_on());
  EXPECT_FALSE(*outcome);
  EXPECT_THAT(observer.troubles, Contains(HasSubstr("allowed are 0.001 mm (tracker.max_std_mm)")));
}

}  // namespace
}  // namespace truepose::daemon
