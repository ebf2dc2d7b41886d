// A flat arm of two links, drawn and lagged by the test itself, whose path file is judged.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

#include "config/path_file.hpp"
#include "tests/core/lagging_drives.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

constexpr double kUpper_mm = 1000, kFore_mm = 800, kCurvePeriod_s = 0.02;
constexpr int kCurveSamples = 400;
constexpr double kDegOfRad = 180 / 3.14159265358979323846;

struct FlatAxes {
  double q1 = 0, q2 = 0;
};
FlatAxes curve_axes(double t) { return {0.3 * std::sin(2 * t), 1.2 + 0.3 * std::cos(3 * t)}; }
Eigen::Vector3d flat_flange(FlatAxes q) {
  return {kUpper_mm * std::cos(q.q1) + kFore_mm * std::cos(q.q1 + q.q2),
          kUpper_mm * std::sin(q.q1) + kFore_mm * std::sin(q.q1 + q.q2), 0};
}

RobotModel flat_arm() {
  RobotModel arm;
  arm.joints.resize(2);
  arm.joints[1].a_mm = kUpper_mm;
  arm.X_flange.translation() = Eigen::Vector3d{kFore_mm, 0, 0};
  return arm;
}

/// The arm's true first joint differs by `error_rad` from its encoder, which the correction removes. Its
/// reflector is `off_plane_mm` off the plane.
ProductionPath curve_path(double dead_time_s, double lag1_s, double lag2_s, double error_rad,
                          double off_plane_mm) {
  const auto q1 = lagging_axis([&](double t) { return curve_axes(t).q1 - error_rad; }, dead_time_s, lag1_s,
                               kCurvePeriod_s, kCurveSamples),
             q2 = lagging_axis([](double t) { return curve_axes(t).q2; }, dead_time_s, lag2_s, kCurvePeriod_s,
                               kCurveSamples);
  std::string file =
      "time_s,program,point,gain_percent,flange_x_mm,flange_y_mm,flange_z_mm,flange_a_deg,flange_b_deg,"
      "flange_c_deg,with_x_mm,with_y_mm,with_z_mm,without_x_mm,without_y_mm,without_z_mm,set_a1_deg,set_a2_deg,"
      "correction_a1_deg,correction_a2_deg,actual_a1_deg,actual_a2_deg\n";
  const auto add = [&file](std::initializer_list<double> numbers) {
    for (const double number : numbers) {
      char text[32];
      std::snprintf(text, sizeof text, ",%.7f", number);
      file += text;
    }
  };
  for (int i = 0; i < kCurveSamples; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double t = i * kCurvePeriod_s;
    const FlatAxes set = curve_axes(t);
    const Eigen::Vector3d wanted = flat_flange(set), with = flat_flange({q1[k] + error_rad, q2[k]}),
                          without = flat_flange({set.q1 + error_rad, set.q2});
    file += std::to_string(t) + ",CURVE,0,100";
    add({wanted.x(), wanted.y(), wanted.z(), 0, 0, 0, with.x(), with.y(), off_plane_mm});
    add({without.x(), without.y(), off_plane_mm, set.q1 * kDegOfRad, set.q2 * kDegOfRad,
         -error_rad * kDegOfRad, 0});
    add({q1[k] * kDegOfRad, q2[k] * kDegOfRad});
    file += "\n";
  }
  const TempFolder folder;
  return load_production_path(folder.write("path.csv", file),
                              {Eigen::Isometry3d::Identity(), Eigen::Vector3d::Zero(), flat_arm()});
}

TEST(PathLag, AloneIsNoErrorFromTheWantedPathWithTheSameLag) {
  const PathAccuracy accuracy = path_accuracy(curve_path(0.012, 0.05, 0.03, 0, 0).samples);
  ASSERT_TRUE(accuracy.path && accuracy.path_lagged);
  EXPECT_GT(accuracy.path->with.max, 1) << "what the drives cut off the curve";
  EXPECT_LT(accuracy.path_lagged->max, 0.01);
}

TEST(PathLag, LeavesAGeometricErrorInBothFigures) {
  const PathAccuracy accuracy = path_accuracy(curve_path(0.012, 0.05, 0.03, 0, 0.5).samples);
  EXPECT_GT(accuracy.path->with.max, 1);
  EXPECT_NEAR(accuracy.path_lagged->mean, 0.5, 0.001);
  EXPECT_NEAR(accuracy.path_lagged->max, 0.5, 0.001);
}

TEST(PathLag, OfACorrectedArmIsThatOfWhatItsDrivesWereGiven) {
  const ProductionPath path = curve_path(0.012, 0.05, 0.03, 0.002, 0);
  ASSERT_TRUE(path.lag);
  EXPECT_NEAR(path.lag->axes[0].delay_s(), 0.062, 0.0005);
  EXPECT_NEAR(path.lag->axes[1].delay_s(), 0.042, 0.0005);
  const PathAccuracy accuracy = path_accuracy(path.samples);
  EXPECT_GT(accuracy.path->without.mean, 1);
  EXPECT_LT(accuracy.path_lagged->max, 0.01);
}

}  // namespace
}  // namespace truepose::config
