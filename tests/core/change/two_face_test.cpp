#include "core/change/two_face.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/math/random.hpp"
#include "core/simulate/tracker_instrument.hpp"
#include "core/simulate/true_arm.hpp"

namespace truepose {
namespace {

constexpr TrackerNoiseModel kTrackerNoise{.range_mm = 0.005, .transverse_mm_per_m = 0.003};
constexpr AimingErrors kErrors{.collimation = 24e-6, .tilt = -35e-6, .index = 18e-6};

/// Points before a tracker that are seen in both faces.
class TwoFaces : public testing::Test {
 protected:
  std::vector<FacePair> seen(const AimingErrors& errors, int points = 12) {
    std::vector<FacePair> pairs;
    for (int i = 0; i < points; ++i) {
      const Eigen::Vector3d p_mm(random.uniform(1500, 4500), random.uniform(-1500, 1500),
                                 random.uniform(-1400, 1200));
      const Eigen::Vector3d face1_mm = noisy_reading(errors.seen(p_mm, 1), kTrackerNoise, random);
      const Eigen::Vector3d face2_mm = noisy_reading(errors.seen(p_mm, 2), kTrackerNoise, random);
      true_mm.push_back(p_mm);
      pairs.push_back({face1_mm, (face1_mm + face2_mm) / 2});
    }
    return pairs;
  }
  Random random{3};
  std::vector<Eigen::Vector3d> true_mm;
};

TEST_F(TwoFaces, TellTheConstantsOfTheInstrumentWithinThreeSigma) {
  int beyond = 0;
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    random = Random{trial};
    const auto found = aiming_constants(seen(kErrors), kTrackerNoise);
    const Eigen::Vector3d off =
        found->value - Eigen::Vector3d(kErrors.collimation, kErrors.tilt, kErrors.index);
    for (int i = 0; i < 3; ++i) beyond += std::abs(off[i]) > 3 * std::sqrt(found->covariance(i, i));
    EXPECT_TRUE(found->significant()) << trial;
  }
  EXPECT_LE(beyond, 6) << "of 600";
}

TEST_F(TwoFaces, PutRightWhatWasReadInOneAlone) {
  const auto pairs = seen(kErrors, 30);
  const auto found = aiming_constants(pairs, kTrackerNoise);
  double before = 0, after = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p_mm(random.uniform(1500, 4500), random.uniform(-1500, 1500),
                               random.uniform(-1400, 1200));
    const Eigen::Vector3d read_mm = kErrors.seen(p_mm, 1);
    before = std::max(before, (read_mm - p_mm).norm());
    after = std::max(after, (found->corrected(read_mm) - p_mm).norm());
  }
  EXPECT_GT(before, 0.1);
  EXPECT_LT(after, 0.02);
}

TEST_F(TwoFaces, SeldomAccuseATrackerThatNeedsNoCompensation) {
  int reported = 0;
  for (std::uint64_t trial = 0; trial < 1000; ++trial) {
    random = Random{trial};
    reported += aiming_constants(seen({}), kTrackerNoise)->significant();
  }
  EXPECT_LE(reported, 15);
}

TEST_F(TwoFaces, NoticeWhatTheConstantsDoNotExplain) {
  auto pairs = seen(kErrors);
  EXPECT_GT(aiming_constants(pairs, kTrackerNoise)->fit, 0.005);
  pairs[3].face1_mm.y() += 0.3;
  EXPECT_LT(aiming_constants(pairs, kTrackerNoise)->fit, 1e-6);
}

TEST_F(TwoFaces, OfTooFewPointsSayNothing) {
  EXPECT_FALSE(aiming_constants(seen(kErrors, 2), kTrackerNoise));
}

TEST_F(TwoFaces, AreDescribedWithTheirUncertainty) {
  const auto found = aiming_constants(seen(kErrors), kTrackerNoise);
  EXPECT_THAT(described(*found),
              testing::MatchesRegex("in one face the tracker errs by up to 0\\.[0-9]+ mm "
                                    "\\(collimation .*, tilt -.*, index .* urad; sigma .*\\)"));
}

}  // namespace
}  // namespace truepose
