#include "tests/daemon/example_calibration.hpp"

#include <stdexcept>

#include "config/cell_setup.hpp"
#include "core/quality/model_noise.hpp"
#include "core/simulate/true_arm.hpp"
#include "tests/daemon/example_cell.hpp"

namespace truepose::test {

daemon::CampaignResult example_calibration(std::uint64_t seed) {
  const config::CellConfig cell = example_cell();
  const drivers::MockCellOptions truth = example_truth();
  Random random{seed};
  TrueArm arm{truth.truth, seed};
  daemon::CampaignResult result;
  result.identities = {{"#KR210R2700_2", "S1", "KSS"}, {"AT901", "T1", "1"}};
  const int poses = cell.campaign.identify_poses + cell.campaign.validate_poses;
  for (int pose = 1; pose <= poses; ++pose) {
    daemon::StoredPoint point;
    point.pose = pose;
    const bool identify = pose <= cell.campaign.identify_poses;
    point.purpose = identify ? daemon::PointPurpose::Identify : daemon::PointPurpose::Validate;
    point.q_target = truth.q_start;
    point.q_target[4] = 0.9;  // a wrist that is bent, as planned poses have it
    for (double& axis : point.q_target) axis += random.uniform(-0.6, 0.6);
    point.q_commanded = point.q_actual = point.q_target;
    point.smr = cell.reflector.name;
    arm.stop_anew();
    point.p_WS_mm = noisy_reading(arm.p_WS_mm(point.q_actual), truth.noise, random);
    point.std_mm.setConstant(truth.noise.range_mm);
    point.temperature_c = 20;
    point.pressure_mbar = 1013;
    point.humidity_percent = 50;
    result.points.push_back(point);
  }
  const CalibrateOptions options = config::calibrate_options(cell);
  const MeasurementData data = daemon::measurement_data(result.points, cell.reflector.name);
  auto calibration = calibrate(cell.robot.model, data, options);
  if (!calibration) throw std::runtime_error{calibration.error().detail};
  auto& found = result.as<daemon::CalibrationResult>();
  found.calibration = *std::move(calibration);
  found.noise = noise_about_model(found.calibration, data, options.noise);
  found.validation_distances2 = validation_distances2(found.calibration, data, found.noise);
  return result;
}

}  // namespace truepose::test
