#include "tools/experiment/reference_methods.hpp"

#include <gtest/gtest.h>

#include "core/calibrate/calibrate.hpp"
#include "core/fit/placement.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tools/experiment/particle_swarm.hpp"

namespace truepose {
namespace {

TEST(ReferenceMethods, EndAtTheArmOfTheProductFromASaneStart) {
  const SimulatedCampaign c = example::campaign(example::true_arm(), 30, 30, {.seed = 1});
  const double two_stage = example::mean_miss(calibrate(example::kr210(), c.data), c);
  EXPECT_LT(two_stage, 0.03);
  const MeasurementData data{c.data.smr_names, points_of(c.data, PoseSet::Identify)};
  const CalibratedCell start = placement(example::kr210(), data.smr_names, data.points);
  const CalibratedCell swarm = particle_swarm_start(example::kr210(), data.smr_names, data.points);
  using enum ReferenceMethod;
  for (const auto& [method, from] : {std::pair{LeastSquares, start},
                                     {LeastSquares, swarm},
                                     {GaussNewton, start},
                                     {LevenbergMarquardt, start}}) {
    const ReferenceFit fit = fit_by(method, from, data);
    EXPECT_TRUE(fit.coarse.converged && fit.fine.converged) << static_cast<int>(method);
    EXPECT_NEAR(example::mean_miss(fit.fine.cell, c), two_stage, 1e-4) << static_cast<int>(method);
  }
  EXPECT_LT(example::mean_miss(fit_by(Ridge, start, data).fine.cell, c), 1.2 * two_stage);
}

}  // namespace
}  // namespace truepose
