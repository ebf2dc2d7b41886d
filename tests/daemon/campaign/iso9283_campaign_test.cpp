#include <gmock/gmock.h>

#include <algorithm>

#include "core/math/angles.hpp"
#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Lt;
using testing::SizeIs;

/// Cycles of the example cell, whose model knows it well.
struct Iso9283CampaignTest : CampaignTest {
  const Iso9283Test& run(Iso9283Order order) {
    start(std::move(order));
    EXPECT_TRUE(go_on());
    EXPECT_TRUE(*outcome) << outcome->error().detail;
    return (***outcome).as<Iso9283Test>();
  }
  std::vector<double> accuracies_mm(const Iso9283Test& test) const {
    std::vector<double> ap_mm;
    for (const CycleSet& set : test.result.sets) ap_mm.push_back(set.characteristics.accuracy.p_mm);
    return ap_mm;
  }

  CalibratedCell model{truth.truth.robot,
                       BasePose::of(truth.truth.X_WB),
                       {Reflector{config.reflector.name, truth.truth.p_FS_mm}}};
};

TEST_F(Iso9283CampaignTest, MeasuresFivePosesAsOftenAsConfigured) {
  const Iso9283Test& test = run({.cell = model, .cycles = 4});
  EXPECT_THAT(journal.points, SizeIs(20));
  ASSERT_THAT(test.result.sets, SizeIs(5));
  for (const CycleSet& set : test.result.sets) EXPECT_EQ(set.cycles, 4);
  EXPECT_EQ(test.result.fewest_cycles, 4);
  EXPECT_EQ(campaign->progress().done, 20);
  EXPECT_EQ(campaign->progress().total, 20);
}

TEST_F(Iso9283CampaignTest, IsAccurateWithTheModelAndMillimetresOffWithout) {
  const std::vector<double> with = accuracies_mm(run({.cell = model, .cycles = 5}));
  EXPECT_THAT(with, Each(Lt(0.06)));
  const std::vector<double> without = accuracies_mm(run({.cell = model, .compensate = false, .cycles = 5}));
  EXPECT_GT(*std::ranges::max_element(without), 1.0);
}

TEST_F(Iso9283CampaignTest, FitsTheFrameWhereNoModelKnowsIt) {
  const Iso9283Test& test = run({.compensate = false, .cycles = 3});
  EXPECT_EQ(test.frame, record::Iso9283Frame::Fitted);
  EXPECT_THAT(accuracies_mm(test), Each(Lt(5)));
  for (const CycleSet& set : test.result.sets)
    EXPECT_LT(set.characteristics.repeatability.l_mm, 0.2) << "which does not depend on the frame";
}

TEST_F(Iso9283CampaignTest, ComesToEachPoseFromTheOneBefore) {
  run({.cell = model, .cycles = 3});
  for (std::size_t i = 5; i < journal.points.size(); ++i) {
    EXPECT_EQ(journal.points[i].q_target, journal.points[i - 5].q_target);
    EXPECT_EQ(journal.points[i].direction, journal.points[i - 5].direction);
  }
}

TEST_F(Iso9283CampaignTest, ComesToThreePointsAlongTheAxesWhereThatIsOrdered) {
  const Iso9283Test& test = run({.cell = model, .cycles = 3, .variation = true});
  EXPECT_THAT(journal.points, SizeIs(3 * 14));
  EXPECT_EQ(campaign->progress().total, 3 * 14);
  EXPECT_THAT(test.result.sets, SizeIs(14)) << "each its own direction of a point";
  std::vector<std::string> visited;
  for (const Iso9283Stop& stop : test.stops)
    visited.push_back("P" + std::to_string(stop.point + 1) +
                      stop.direction.substr(stop.direction.size() / 2));
  EXPECT_THAT(visited, ElementsAre("P5", "P4", "P3", "P2", "P1", "P4x", "P4y", "P4z", "P2x", "P2y", "P2z",
                                   "P1x", "P1y", "P1z"));
  for (std::size_t i = 14; i < 28; ++i)
    EXPECT_EQ(journal.points[i + 14].direction, journal.points[i].direction) << i;
}

TEST_F(Iso9283CampaignTest, TellsBacklashByTheVariationUnlessTheModelKnowsIt) {
  const auto variation_mm = [&](const CalibratedCell& by) {
    const Iso9283Test& test = run({.cell = by, .cycles = 8, .variation = true});
    EXPECT_THAT(test.result.variations, SizeIs(3));
    double largest_mm = 0;
    for (const PointVariation& of : test.result.variations) {
      EXPECT_THAT(of.directions, SizeIs(3));
      largest_mm = std::max(largest_mm, of.variation.p_mm);
    }
    return largest_mm;
  };
  const double tight_mm = variation_mm(model);
  EXPECT_LT(tight_mm, 0.06) << "what the repeatability leaves of the means";

  constexpr double kPlay_rad = 0.01 * kRadPerDeg;
  truth.truth.non_geometric.drives.resize(6, {.backlash_rad = kPlay_rad});
  const double loose_mm = variation_mm(model);
  EXPECT_GT(loose_mm, 3 * tight_mm);

  CalibratedCell knowing = model;
  for (int joint = 0; joint < 6; ++joint)
    knowing.robot.deviation.push_back({joint, DeviationBasis::Approach, 1, -kPlay_rad / 2});
  EXPECT_LT(variation_mm(knowing), 1.2 * tight_mm);
}

TEST_F(Iso9283CampaignTest, TakesTheCubeThatTheCellNames) {
  const TestCube found = run({.cell = model, .cycles = 2}).cube;
  config.iso9283.cube.centre_mm = found.X_BC.translation();
  config.iso9283.cube.edge_mm = 300;
  const Iso9283Test& test = run({.cell = model, .cycles = 2});
  EXPECT_EQ(test.cube.edge_mm, 300);
  EXPECT_EQ(test.points[0].commanded.p_mm, found.X_BC.translation()) << "P1 is the centre";
  EXPECT_NEAR((test.points[1].commanded.p_mm - found.X_BC.translation()).norm(), 0.4 * std::sqrt(3) * 300,
              1e-9);
}

TEST_F(Iso9283CampaignTest, SaysWhereNoCubeFits) {
  config.iso9283.cube.centre_mm = Eigen::Vector3d{0, 0, 5000};
  start(Iso9283Order{.cell = model});
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_EQ(outcome->error().fault, CampaignFault::Planning);
  EXPECT_THAT(outcome->error().detail, HasSubstr("at this centre"));
}

TEST_F(Iso9283CampaignTest, EvaluatesTheCyclesThatWereMeasured) {
  truth.faults.tracker_busy = 0.05;
  config.campaign.pause_after_lost = 0;
  config.campaign.retries = 0;
  const Iso9283Test& test = run({.cell = model, .cycles = 10});
  EXPECT_FALSE(journal.skipped.empty());
  EXPECT_EQ(journal.points.size() + journal.skipped.size(), 50U);
  EXPECT_LT(test.result.fewest_cycles, 10);
}

}  // namespace
}  // namespace truepose::daemon
