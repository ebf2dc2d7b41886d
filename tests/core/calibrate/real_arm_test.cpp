// What is identified in a part of a real arm's reach, judged outside of it.
#include "tests/core/real_arm.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/calibrate/calibrate.hpp"

namespace truepose {
namespace {

constexpr int kQuarters = 4;

/// The points of reflector 1: those with a joint in one quarter of what it goes through identify, all others
/// validate.
MeasurementData identified_in(const RealArm& arm, Eigen::Index joint, int quarter) {
  MeasurementData data = arm.data;
  std::erase_if(data.points, [](const Measurement& point) { return point.smr != 0; });
  data.smr_names.resize(1);
  double first = std::numeric_limits<double>::max(), last = -first;
  for (const Measurement& point : data.points) {
    first = std::min(first, point.q[joint]);
    last = std::max(last, point.q[joint]);
  }
  const double width = (last - first) / kQuarters;
  for (Measurement& point : data.points) {
    const int of_point = std::min(static_cast<int>((point.q[joint] - first) / width), kQuarters - 1);
    point.set = of_point == quarter ? PoseSet::Identify : PoseSet::Validate;
  }
  return data;
}

StageErrors validated(const RealArm& arm, const MeasurementData& data, const CalibrateOptions& options) {
  const auto calibration = calibrate(arm.robot, data, options);
  if (!calibration) throw std::runtime_error{calibration.error().detail};
  return *calibration->validate;
}

TEST(ARealArm, IsPredictedOutsideTheQuarterThatItWasMeasuredInAndNotWorseForItsLayers) {
  const auto arm = real_arm();
  if (!arm) GTEST_SKIP() << "no measurements of a real arm";
  for (int joint = 0; joint < 6; ++joint) {
    for (int quarter = 0; quarter < kQuarters; ++quarter) {
      const std::string place =
          "joint " + std::to_string(joint + 1) + ", quarter " + std::to_string(quarter + 1);
      SCOPED_TRACE(place);
      const MeasurementData data = identified_in(*arm, joint, quarter);
      const StageErrors without = validated(*arm, data, {});
      const StageErrors with = validated(*arm, data, {.non_geometric = true, .field = FieldUse::Auto});
      std::printf("%s: nominal %.3f, geometry %.3f, both layers %.3f mm\n", place.c_str(),
                  without.before.mean, without.after.mean, with.after.mean);
      EXPECT_LE(without.after.mean, without.before.mean);
      EXPECT_LE(with.after.mean, 1.05 * without.after.mean);
    }
  }
}

}  // namespace
}  // namespace truepose
