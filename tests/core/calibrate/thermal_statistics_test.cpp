// What a campaign on an arm that warms up is worth, with and without the arm's answer to warmth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "core/calibrate/calibrate.hpp"
#include "core/change/drift_check.hpp"
#include "core/fit/thermal_response.hpp"
#include "core/fit/uncertainty.hpp"
#include "core/math/angles.hpp"
#include "core/quality/model_noise.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

constexpr MeasurementNoise kReadingNoise{
    .tracker = {.range_mm = kTrackerNoise_mm, .transverse_mm = kTrackerNoise_mm},
    .repeatability_mm = kRepeatability_mm};
constexpr Seconds kBetweenPoints{60}, kWarmThrough{18'000}, kTimeConstant{1800};
constexpr double kCold_c = 22;

std::string clock_text(Seconds since) {
  const int s = static_cast<int>(since.count());
  char text[40];
  std::snprintf(text, sizeof text, "2026-05-04T%02d:%02d:%02dZ", 6 + s / 3600, s / 60 % 60, s % 60);
  return text;
}

/// An arm that was switched on when its campaign began.
class WarmingCell {
 public:
  explicit WarmingCell(std::uint64_t seed, bool warms = true, TrueArmSetup truth = example::true_arm())
      : random_{seed + 9000}, truth_{std::move(truth)}, arm_{warming(warms), seed} {
    for (double& kelvins : rise_) kelvins = random_.uniform(10, 30);
  }

  MeasurementData measured(int identify, int validate) {
    MeasurementData data{.smr_names = {"1"}, .points = {}, .stations = {}};
    for (int n = 0; n < identify + validate; ++n)
      data.points.push_back(point(n * kBetweenPoints, n < identify ? PoseSet::Identify : PoseSet::Validate));
    return data;
  }
  std::vector<Measurement> warm_points(int count) {
    std::vector<Measurement> points;
    for (int n = 0; n < count; ++n) points.push_back(point(kWarmThrough, PoseSet::Validate));
    return points;
  }

  /// Of a cell at so many poses of the arm warm through: mean error, and share of coordinates within the
  /// 95 % intervals.
  struct Judged {
    double mean_mm = 0, within = 0;
  };
  Judged judged(const CalibratedCell& cell, const Eigen::MatrixXd& covariance, int poses = 60) {
    arm_.warm_up(kWarmThrough);
    Judged judged;
    for (const JointVector& q : random_poses(example::kr210(), poses, random_)) {
      const Eigen::Vector3d off_mm = cell.predict(q, 0) - stands_mm(q);
      const Eigen::Matrix3d C = position_covariance(cell, covariance, q, 0);
      const auto held = (off_mm.array().abs() < 1.96 * C.diagonal().array().sqrt()).count();
      judged.mean_mm += off_mm.norm() / poses;
      judged.within += static_cast<double>(held) / (3 * poses);
    }
    return judged;
  }
  std::vector<double> warm_c() const { return {rise_.begin(), rise_.end()}; }

 private:
  TrueArmSetup warming(bool warms) {
    if (!warms) return truth_;
    truth_.warm_up = {.zero = JointVector(6), .growth = 30e-6, .time_constant = kTimeConstant};
    for (double& zero : truth_.warm_up.zero) zero = 0.006 * kRadPerDeg * random_.normal();
    return truth_;
  }
  /// Without what it scatters by from stop to stop.
  Eigen::Vector3d stands_mm(const JointVector& q) const {
    const RobotModel robot = warmed(truth_.robot, truth_.warm_up, kWarmThrough);
    return CalibratedCell{robot, BasePose::of(truth_.X_WB), {{"1", truth_.p_FS_mm}}, {}}.predict(q, 0);
  }
  Measurement point(Seconds since, PoseSet set) {
    arm_.warm_up(since);
    Measurement point{.q = random_poses(example::kr210(), 1, random_).front(), .set = set};
    arm_.move_to(point.q);
    point.p_WS_mm = noisy_reading(arm_.p_WS_mm(point.q), kReadingNoise.tracker, random_);
    const double share = -std::expm1(-since / kTimeConstant);
    for (const double kelvins : rise_)
      point.temperature_c.push_back(kCold_c + share * kelvins + 0.1 * random_.normal());
    point.time = clock_text(since);
    return point;
  }

  Random random_;
  TrueArmSetup truth_;
  TrueArm arm_;
  std::array<double, 6> rise_{};
};

Calibration calibrated(const MeasurementData& data, ThermalUse thermal) {
  auto made =
      calibrate(example::kr210(), data, {.noise = kReadingNoise, .thermal = thermal, .check_model = false});
  EXPECT_TRUE(made) << made.error().detail;
  return made ? *std::move(made) : Calibration{};
}

/// The cell with its drives so warm.
CalibratedCell warm_cell(const Calibration& made, std::span<const double> temperature_c) {
  CalibratedCell cell = made.cell;
  cell.robot = at_temperatures(cell.robot, *made.thermal->response, temperature_c);
  return cell;
}

TEST(ThermalResponseOverManyArms, MakesAWarmingArmAsGoodAsAColdOne) {
  const int runs = trials(200);
  double cold_mm = 0, without_mm = 0, with_mm = 0, by_time_mm = 0, within = 0;
  int kept = 0, kept_by_time = 0;
  for (int run = 0; run < runs; ++run) {
    const auto seed = static_cast<std::uint64_t>(run);
    WarmingCell still(seed, false);
    const Calibration of_still = calibrated(still.measured(60, 20), ThermalUse::Off);
    cold_mm += still.judged(of_still.cell, of_still.covariance).mean_mm / runs;

    WarmingCell cell(seed);
    const MeasurementData data = cell.measured(60, 20);
    const Calibration without = calibrated(data, ThermalUse::Off);
    without_mm += cell.judged(without.cell, without.covariance).mean_mm / runs;
    const std::vector<double> warm_c = mean_temperatures_c(cell.warm_points(5));

    const Calibration with = calibrated(data, ThermalUse::Temperatures);
    ASSERT_TRUE(with.thermal);
    if (with.thermal->response) {
      ++kept;
      const auto judged = cell.judged(
          warm_cell(with, warm_c),
          covariance_at_temperatures(with.cell, with.covariance, *with.thermal->response, warm_c));
      with_mm += judged.mean_mm;
      within += judged.within;
    }
    const Calibration by_time = calibrated(data, ThermalUse::Time);
    ASSERT_TRUE(by_time.thermal);
    kept_by_time += by_time.thermal->response.has_value();
    by_time_mm += cell.judged(by_time.cell, by_time.covariance).mean_mm / runs;
  }
  with_mm /= std::max(1, kept);
  within /= std::max(1, kept);
  std::cout << "seeds 0.." << runs - 1 << ": a cold arm " << cold_mm << " mm; warm, without the response "
            << without_mm << ", with it " << with_mm << " (kept in " << kept << ", within 95 %: " << within
            << "), by time " << by_time_mm << " (kept in " << kept_by_time << ")\n";
  EXPECT_GE(kept, runs - runs / 100);
  EXPECT_LE(with_mm, widened(1.5, 0.1) * cold_mm);
  // Time tells less of warmth than a sensor: how fast the arm warms up is found too.
  EXPECT_LE(by_time_mm, without_mm / 3);
  EXPECT_GE(within, 0.93);
  EXPECT_LE(within, 0.97);
}

/// Nothing but noise tells the zero of a last joint that turns the reflector about itself.
TEST(ThermalResponseOverManyArms, IsAsPhysicsHasItWhereNoPoseShowsIt) {
  TrueArmSetup truth = example::true_arm();
  truth.p_FS_mm = {1, 0, 80};
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    WarmingCell cell(seed, true, truth);
    const Calibration made = calibrated(cell.measured(60, 20), ThermalUse::Temperatures);
    ASSERT_TRUE(made.thermal && made.thermal->response) << "seed " << seed;
    EXPECT_LT(std::abs(made.thermal->response->per_kelvin[5]), 20e-6) << "seed " << seed << ", rad/K";
  }
}

TEST(ThermalResponseOverManyArms, IsNotKeptWhereTheArmDoesNotChange) {
  const int runs = trials(200);
  int kept = 0;
  for (int run = 0; run < runs; ++run) {
    WarmingCell still(static_cast<std::uint64_t>(run), false);
    const MeasurementData data = still.measured(60, 20);
    for (const ThermalUse use : {ThermalUse::Temperatures, ThermalUse::Time})
      kept += calibrated(data, use).thermal->response.has_value();
  }
  std::cout << "kept of an arm that does not change: " << kept << " of " << 2 * runs << '\n';
  EXPECT_LE(kept, runs / 50 + 1);
}

/// As long as nobody knows the arm's answer to warmth, it hides them.
TEST(ThermalResponseOverManyArms, ShowsGrossErrorsThatHidBehindWarmth) {
  constexpr double kOff_mm = 0.22;
  const int runs = trials(50);
  int hidden = 0, shown = 0, others = 0;
  for (int run = 0; run < runs; ++run) {
    WarmingCell cell(static_cast<std::uint64_t>(run));
    const MeasurementData good = cell.measured(60, 0);
    for (const std::size_t point : {2u, 7u, 12u, 22u, 32u, 42u}) {
      MeasurementData data = good;
      data.points[point].p_WS_mm.z() += kOff_mm;
      const auto is_left_out = [&](ThermalUse use) {
        const std::vector<RejectedPoint> rejected = calibrated(data, use).rejected;
        const auto found = std::ranges::count(rejected, point, &RejectedPoint::point);
        if (use != ThermalUse::Off) others += static_cast<int>(std::ssize(rejected) - found);
        return found > 0;
      };
      if (is_left_out(ThermalUse::Off)) continue;
      ++hidden;
      shown += is_left_out(ThermalUse::Temperatures);
    }
  }
  std::cout << "seeds 0.." << runs - 1 << ": gross errors hidden by warmth: " << hidden << ", then shown "
            << shown << ", good points taken for such " << others << '\n';
  EXPECT_GE(hidden, runs / 2);
  EXPECT_GE(shown, hidden - hidden / 5);
  EXPECT_LE(others, runs / 10);
}

TEST(ThermalResponseOverManyArms, IsTheSameToTheLastBitWithAnyNumberOfThreads) {
  WarmingCell cell(3);
  MeasurementData data = cell.measured(180, 20);
  for (const std::size_t i : {20u, 90u}) data.points[i].p_WS_mm.x() += 2;
  CalibrateOptions options{.noise = kReadingNoise,
                           .non_geometric = true,
                           .field = FieldUse::Auto,
                           .thermal = ThermalUse::Temperatures};
  const auto alone = calibrate(example::kr210(), data, options);
  ASSERT_TRUE(alone) << alone.error().detail;
  ASSERT_TRUE(alone->thermal && alone->thermal->response);
  EXPECT_EQ(alone->rejected.size(), 2u);
  for (const int jobs : {2, 5}) {
    options.jobs = jobs;
    const auto with = calibrate(example::kr210(), data, options);
    ASSERT_TRUE(with) << with.error().detail;
    EXPECT_EQ(parameter_values(with->cell), parameter_values(alone->cell)) << jobs << " threads";
    EXPECT_EQ(with->covariance, alone->covariance) << jobs << " threads";
    EXPECT_EQ(with->transfer.rms_mm, alone->transfer.rms_mm) << jobs << " threads";
    EXPECT_EQ(with->thermal->response->per_kelvin, alone->thermal->response->per_kelvin)
        << jobs << " threads";
    EXPECT_EQ(with->rejected.size(), alone->rejected.size()) << jobs << " threads";
    EXPECT_EQ(with->field->tried.predicted, alone->field->tried.predicted) << jobs << " threads";
  }
}

/// The same with neither temperatures nor times.
MeasurementData in_order_alone(MeasurementData data) {
  for (Measurement& point : data.points) {
    point.temperature_c.clear();
    point.time.clear();
  }
  return data;
}

TEST(WarmthByTheOrderOfTheRows, IsFoundWhereNothingElseTellsIt) {
  const int runs = trials(200);
  double without_mm = 0, with_mm = 0;
  int kept = 0;
  for (int run = 0; run < runs; ++run) {
    WarmingCell cell(static_cast<std::uint64_t>(run));
    const MeasurementData data = in_order_alone(cell.measured(120, 20));
    const Calibration without = calibrated(data, ThermalUse::Off), with = calibrated(data, ThermalUse::Auto);
    kept += with.thermal && with.thermal->response;
    without_mm += cell.judged(without.cell, without.covariance).mean_mm / runs;
    with_mm += cell.judged(with.cell, with.covariance).mean_mm / runs;
  }
  std::cout << "seeds 0.." << runs - 1 << ": warm, without the response " << without_mm << " mm, by order "
            << with_mm << " (kept in " << kept << ")\n";
  EXPECT_GE(kept, runs - runs / 10);
  EXPECT_LE(with_mm, without_mm / 2);
}

TEST(WarmthByTheOrderOfTheRows, IsFoundWhereTheClockOfTheirTimesStands) {
  WarmingCell cell(3);
  MeasurementData data = in_order_alone(cell.measured(120, 20));
  for (Measurement& point : data.points) point.time = "2026-11-26T08:00:00Z";
  const Calibration made = calibrated(data, ThermalUse::Auto);
  ASSERT_TRUE(made.thermal && made.thermal->clock);
  EXPECT_TRUE(made.thermal->clock->by_order);
}

TEST(WarmthByTheOrderOfTheRows, IsNotFoundInAnArmThatDoesNotChange) {
  const int runs = trials(1000);
  int kept = 0;
  for (int run = 0; run < runs; ++run) {
    WarmingCell still(static_cast<std::uint64_t>(run), false);
    kept += calibrated(in_order_alone(still.measured(60, 20)), ThermalUse::Auto).thermal.has_value();
  }
  EXPECT_EQ(kept, 0);
}

/// Gears that a geometric model does not describe, and rows that were sorted by a joint: what is left then
/// changes with the row, and is the same for all time.
TEST(WarmthByTheOrderOfTheRows, IsNotTakenFromRowsThatAreSorted) {
  const int runs = trials(200);
  int kept = 0;
  for (int run = 0; run < runs; ++run) {
    Random random(static_cast<std::uint64_t>(run) + 77);
    CalibratedCell truth = example::placed(example::kr210(), random);
    truth.robot.deviation = {{.joint = run % 6, .order = 2, .coefficient = 1e-3}};
    MeasurementData data = example::measured(truth, 120, 0.02, random);
    std::ranges::sort(data.points, {}, [&](const Measurement& point) { return point.q[run % 6]; });
    kept += calibrated(data, ThermalUse::Auto).thermal.has_value();
  }
  EXPECT_EQ(kept, 0);
}

TEST(WarmthByTheOrderOfTheRows, IsNotTakenFromATrackerThatSinks) {
  const int runs = trials(200);
  int kept = 0;
  for (int run = 0; run < runs; ++run) {
    WarmingCell still(static_cast<std::uint64_t>(run), false);
    MeasurementData data = in_order_alone(still.measured(120, 20));
    for (std::size_t i = 0; i < data.points.size(); ++i)
      data.points[i].p_WS_mm.z() += 0.3 * -std::expm1(-static_cast<double>(i) / 40);
    kept += calibrated(data, ThermalUse::Auto).thermal.has_value();
  }
  EXPECT_LE(kept, runs / 20);
}

TEST(ThermalResponseOverManyArms, LetsAWarmArmBeKnownAsUnchanged) {
  const int runs = trials(200);
  int warned = 0, warned_without = 0;
  for (int run = 0; run < runs; ++run) {
    WarmingCell cell(static_cast<std::uint64_t>(run));
    const MeasurementData data = cell.measured(60, 20);
    const Calibration made = calibrated(data, ThermalUse::Temperatures);
    if (!made.thermal->response) continue;
    const MeasurementData fitted = as_fitted(made, data);
    const MeasurementNoise noise = noise_about_model(made, fitted, kReadingNoise);
    const std::vector<Measurement> points = cell.warm_points(5);
    const std::vector<double> warm_c = mean_temperatures_c(points);
    const DriftReference cold{.cell = made.cell,
                              .covariance = made.covariance,
                              .noise = noise,
                              .validation_mean_mm = made.validate->after.mean,
                              .validation_distances2 = validation_distances2(made, fitted, noise)};
    DriftReference warm = cold;
    warm.cell = warm_cell(made, warm_c);
    warm.covariance = covariance_at_temperatures(made.cell, made.covariance, *made.thermal->response, warm_c);
    warned_without += drift_check(cold, points)->verdict != DriftVerdict::Ok;
    warned += drift_check(warm, points)->verdict != DriftVerdict::Ok;
  }
  std::cout << "warm arms warned of, of " << runs << ": " << warned << ", at the reference " << warned_without
            << '\n';
  EXPECT_LE(warned, runs / 50 + 1);
}

}  // namespace
}  // namespace truepose
