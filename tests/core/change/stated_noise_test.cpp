#include "core/change/stated_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace truepose {
namespace {

constexpr Eigen::Index kGainPoints = 100;

/// Of points whose residuals are `deviation` along each beam and each way across it.
TimeEvidence evidence_of(double deviation) {
  TimeEvidence evidence{.degrees = 3 * kGainPoints, .noise_known = true};
  evidence.U = Eigen::MatrixXd::Zero(3 * kGainPoints, 1);
  evidence.r = Eigen::VectorXd::Constant(3 * kGainPoints, deviation);
  evidence.beams = Eigen::Vector3d::UnitX().replicate<kGainPoints, 1>();
  return evidence;
}

StatedNoise stated_noise_of(const TimeEvidence& evidence) { return stated_noise(evidence, evidence.r, 0); }

TEST(StatedNoise, IsJudgedAlongTheBeamsAndAcrossThem) {
  EXPECT_EQ(stated_noise_of(evidence_of(1)), StatedNoise::Explains);
  EXPECT_EQ(stated_noise_of(evidence_of(1.3)), StatedNoise::NearlyExplains);
  EXPECT_EQ(stated_noise_of(evidence_of(1.6)), StatedNoise::Contradicts);
  TimeEvidence along = evidence_of(1), across = evidence_of(1);
  for (Eigen::Index row = 0; row < along.r.size(); row += 3) {
    along.r[row] = 1.4;
    across.r[row + 1] = 1.4;
  }
  EXPECT_EQ(stated_noise_of(along), StatedNoise::NearlyExplains);
  EXPECT_EQ(stated_noise_of(across), StatedNoise::NearlyExplains);
}

TEST(StatedNoise, ThatNobodyStatedExplainsNothing) {
  TimeEvidence unknown = evidence_of(1);
  unknown.noise_known = false;
  EXPECT_EQ(stated_noise_of(unknown), StatedNoise::Contradicts);
}

TEST(ChanceOfGain, IsAThousandTimesGreaterWhereTheNoiseHadToBeAQuarterMoreThanStated) {
  const TimeEvidence evidence = evidence_of(1.2);
  const auto chance = [&](double squares, StatedNoise noise) {
    const ChangeEvidence change(Eigen::Matrix3d::Identity(),
                                Eigen::Vector3d::Constant(std::sqrt(squares / 3)), evidence.noise());
    return chance_of(change, noise, halves(change.gain(), 3, evidence));
  };
  const double third = evidence.r.squaredNorm() / 3, most = 0.8 * evidence.r.squaredNorm();
  EXPECT_EQ(chance(third, StatedNoise::Contradicts), 1);
  const double rarer = chance(third, StatedNoise::NearlyExplains) / chance(third, StatedNoise::Explains);
  EXPECT_NEAR(std::log10(rarer), 3, 0.3);
  // Columns that halve the deviation need no noise stated.
  EXPECT_EQ(chance(most, StatedNoise::Contradicts), chance(most, StatedNoise::NearlyExplains));
}

}  // namespace
}  // namespace truepose
