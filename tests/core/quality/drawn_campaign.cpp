#include "tests/core/quality/drawn_campaign.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"

namespace truepose {
namespace {

JointVector pose_of(const DrawnCell& cell, Random& random) {
  JointVector q = random_poses(cell.nominal, 1, random).front();
  for (Eigen::Index i = 0; i < q.size() && cell.within < 1; ++i) {
    const Joint& joint = cell.nominal.joints[static_cast<std::size_t>(i)];
    const double middle = (joint.min + joint.max) / 2 + 0.3;
    q[i] = middle + cell.within * (q[i] - (joint.min + joint.max) / 2);
  }
  return q;
}

}  // namespace

DrawnCell sound_cell(std::uint64_t seed) {
  DrawnCell cell{
      .random = Random{seed}, .nominal = {}, .truth = {}, .options = {}, .before = {}, .spoil = {}};
  Random& random = cell.random;
  const int arm = static_cast<int>(random.next() % 4);
  cell.nominal = arm == 0 ? example::lr_mate() : arm == 1 ? example::ur10() : example::kr210();
  const double strength = random.uniform(0.3, 1.5);
  const bool heavy = arm == 3;
  cell.truth.robot = example::deviating(cell.nominal, random, 0.3 * strength, 0.3e-3 * strength);
  if (heavy) {
    HeavyArmOptions with{.payload_kg = random.uniform(0, 200), .seed = seed};
    with.compliance = random.next() % 2 == 0;
    cell.truth.non_geometric = heavy_arm_errors(with);
    cell.nominal = example::kr210();
  }
  cell.truth.repeatability_mm = random.uniform(0.005, 0.02);
  cell.noise_mm = random.uniform(0.01, 0.03);
  cell.truth.X_WB.translation() =
      Eigen::Vector3d(random.uniform(2500, 5000), random.uniform(-1000, 1000), random.uniform(-800, 200));
  cell.truth.X_WB.rotate(Eigen::AngleAxisd{random.uniform(-3, 3), Eigen::Vector3d::UnitZ()});
  cell.truth.p_FS_mm = {random.uniform(50, 150), random.uniform(-100, 100), random.uniform(50, 200)};
  if (random.next() % 3 == 0)
    cell.truth.further = {{.p_FS_mm = {-random.uniform(50, 150), 50, 80}}, {.p_FS_mm = {0, -120, 150}}};
  if (random.next() % 2 == 0) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    cell.truth.facing_F = {x, y, z};
    cell.truth.acceptance_rad = turn(random.uniform(30, 60));
    cell.sees = true;
    cell.truth.further.clear();
  }
  cell.identify = static_cast<int>(random.uniform(heavy ? 40 : 14, 100));
  cell.validate = static_cast<int>(random.uniform(8, 40));
  cell.options.non_geometric = heavy || random.next() % 3 == 0;
  cell.states_noise = random.next() % 4 != 0;
  cell.reads_time = random.next() % 4 == 0;
  if (cell.identify > 40 && random.next() % 6 == 0) cell.options.field = FieldUse::Auto;
  if (cell.identify > 60 && random.next() % 3 == 0) {
    cell.truth.warm_up = {
        .zero = JointVector(6),
        .growth = random.uniform(0, 30e-6),
        .time_constant = Seconds{60 * random.uniform(15, (cell.identify + cell.validate) / 4.0)}};
    for (double& zero : cell.truth.warm_up.zero) zero = turn(0.004) * random.normal();
    cell.warms = true;
  }
  return cell;
}

JudgedCampaign judged(DrawnCell cell, std::uint64_t seed) {
  JudgedCampaign made;
  TrueArm arm{cell.truth, seed};
  TrueArmSetup truth = cell.truth;
  const double read_mm = cell.true_noise_mm > 0 ? cell.true_noise_mm : cell.noise_mm;
  const TrackerNoiseModel noise{.range_mm = read_mm, .transverse_mm = read_mm};
  const int all = cell.identify + cell.validate;
  const bool in_place =
      !cell.in_order && cell.random.next() % 2 == 0;  // validation among the others, or after them
  const bool two_files = !cell.in_order && cell.random.next() % 2 == 0;
  std::vector<PoseSet> set(static_cast<std::size_t>(all), PoseSet::Identify);
  std::fill(set.begin() + cell.identify, set.end(), PoseSet::Validate);
  if (in_place)
    for (std::size_t i = set.size(); i-- > 1;) std::swap(set[i], set[cell.random.next() % (i + 1)]);
  for (std::size_t k = 0; k <= cell.truth.further.size(); ++k)
    made.data.smr_names.push_back(std::to_string(k + 1));
  for (int n = 0; n < all; ++n) {
    if (cell.before) cell.before(arm, truth, n, all);
    if (cell.warms) arm.warm_up(n * Seconds{60});
    JointVector q = pose_of(cell, cell.random);
    while (cell.sees && !arm.visible(q)) q = pose_of(cell, cell.random);
    arm.move_to(q);
    for (int k = 0; k < static_cast<int>(made.data.smr_names.size()); ++k) {
      Measurement point{.q = q, .smr = k, .set = set[static_cast<std::size_t>(n)]};
      const Eigen::Vector3d moved = truth.X_WB.translation() - cell.truth.X_WB.translation();
      point.p_WS_mm = noisy_reading(arm.p_WS_mm(q, static_cast<std::size_t>(k)) + moved, noise, cell.random);
      point.in_order = cell.in_order || point.set == PoseSet::Identify;
      if (cell.reads_time) point.time = std::to_string(60.0 * n + 3 * k);
      point.direction = arm.directions();
      made.data.points.push_back(point);
    }
  }
  if (two_files) std::ranges::stable_sort(made.data.points, {}, &Measurement::set);
  for (std::size_t i = 0; i < made.data.points.size(); ++i) made.data.points[i].row = static_cast<int>(i) + 1;
  if (cell.rounded_deg > 0)
    for (Measurement& point : made.data.points)
      for (double& angle : point.q)
        angle = turn(cell.rounded_deg) * std::round(angle / turn(cell.rounded_deg));
  if (cell.spoil) cell.spoil(made.data, cell.random);
  const MeasurementNoise stated{.tracker = {.range_mm = cell.noise_mm, .transverse_mm = cell.noise_mm},
                                .repeatability_mm = cell.truth.repeatability_mm};
  std::optional<MeasurementNoise> given;
  if (cell.states_noise) given = stated;
  cell.options.noise = given;
  auto found = calibrate(cell.nominal, made.data, cell.options);
  if (!found) {
    made.refused = true;
    made.refusal = found.error().detail;
    return made;
  }
  made.calibration = *std::move(found);
  const MeasurementData fitted = as_fitted(made.calibration, made.data);
  made.verdict = calibration_verdict({.calibration = made.calibration, .data = fitted, .stated = given});
  if (cell.warms) arm.warm_up(Seconds{40000});
  double squares = 0;
  constexpr int kElsewhere = 200;
  Random elsewhere{seed + 77};
  for (int n = 0; n < kElsewhere; ++n) {
    const JointVector q = random_poses(cell.nominal, 1, elsewhere).front();
    arm.move_to(q);
    const CalibratedCell& model = made.calibration.cell;
    // As the arm stands on average.
    TrueArmSetup still = arm.setup();
    still.repeatability_mm = 0;
    still.X_WB = cell.truth.X_WB;
    TrueArm average{still, seed};
    if (cell.warms) average.warm_up(Seconds{40000});
    average.move_to(q);
    squares += (model.predict(q, 0, average.directions()) - average.p_WS_mm(q)).squaredNorm() / kElsewhere;
  }
  made.true_rms_mm = std::sqrt(squares);
  return made;
}

}  // namespace truepose
