#include "config/scenario.hpp"

#include <algorithm>

#include "config/robot_file.hpp"
#include "config/yaml_poses.hpp"
#include "config/yaml_reader.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"

namespace truepose::config {

namespace {

using std::filesystem::path;

constexpr Range kErrorMm{-100, 100};
constexpr Range kErrorRad{-0.1, 0.1};
constexpr Range kNoiseMm{0, 10};

void add_listed_errors(std::vector<Joint>& joints, const YamlValue& errors) {
  if (errors.list().size() != joints.size()) {
    errors.fail("expected one entry for each of the " + std::to_string(joints.size()) + " joints, found " +
                std::to_string(errors.list().size()));
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const YamlMap map(errors.list()[i], {"a", "alpha", "d", "theta", "beta"});
    Joint error;
    map.read("a", error.a_mm, kErrorMm);
    map.read("alpha", error.alpha_rad, kErrorRad);
    map.read("d", error.d_mm, kErrorMm);
    map.read("theta", error.theta_rad, kErrorRad);
    map.read("beta", error.beta_rad, kErrorRad);
    joints[i].a_mm += error.a_mm;
    joints[i].alpha_rad += error.alpha_rad;
    joints[i].d_mm += error.d_mm;
    joints[i].theta_rad += error.theta_rad;
    joints[i].beta_rad += error.beta_rad;
  }
}

/// Every parameter off by a uniform error within +-mm or +-rad, the same for the same seed on every machine.
void add_drawn_errors(std::vector<Joint>& joints, const YamlValue& errors) {
  const YamlMap map(errors, {"seed", "mm", "rad"});
  Random random(map.at("seed").seed());
  const double mm = map.at("mm").number({0, kErrorMm.max}), rad = map.at("rad").number({0, kErrorRad.max});
  for (Joint& joint : joints) {
    joint.a_mm += random.uniform(-mm, mm);
    joint.alpha_rad += random.uniform(-rad, rad);
    joint.d_mm += random.uniform(-mm, mm);
    joint.theta_rad += random.uniform(-rad, rad);
    joint.beta_rad += random.uniform(-rad, rad);
  }
}

NonGeometricErrors drives_value(const YamlValue& value, const RobotModel& robot) {
  const bool heavy_arm =
      robot.joints.size() == 6 &&
      std::ranges::all_of(robot.joints, [](const Joint& joint) { return joint.type == JointType::Revolute; });
  if (!heavy_arm) value.fail("known for arms of six revolute joints alone; leave it out");
  const YamlMap map(value, {"payload_kg", "compliance", "harmonics", "backlash_deg", "seed"});
  HeavyArmOptions options;
  double backlash_deg = 0;
  map.read("payload_kg", options.payload_kg, {0, 1000});
  map.read("compliance", options.compliance);
  map.read("harmonics", options.harmonics);
  map.read("backlash_deg", backlash_deg, {0, 1});
  options.backlash_rad = backlash_deg * kRadPerDeg;
  if (const YamlValue* seed = map.find("seed")) options.seed = seed->seed();
  return heavy_arm_errors(options);
}

Scenario::TrackerNoise tracker_noise_value(const YamlValue& value) {
  const YamlMap map(value, {"range_mm", "range_mm_per_m", "transverse_mm", "transverse_mm_per_m"});
  Scenario::TrackerNoise noise;
  map.read("range_mm", noise.range_mm, kNoiseMm);
  map.read("range_mm_per_m", noise.range_mm_per_m, kNoiseMm);
  map.read("transverse_mm", noise.transverse_mm, kNoiseMm);
  map.read("transverse_mm_per_m", noise.transverse_mm_per_m, kNoiseMm);
  return noise;
}

void read_reflector(const YamlValue& value, Scenario& scenario) {
  const YamlMap map(value, {"offset_mm", "facing", "acceptance_deg"});
  scenario.p_FS_mm = point_value(map.at("offset_mm"));
  if (const YamlValue* facing = map.find("facing")) scenario.facing_F = direction_value(*facing);
  map.read("acceptance_deg", scenario.acceptance_deg, {1, 180});
}

void read_controller(const YamlValue& value, Scenario& scenario) {
  const YamlMap map(value, {"model", "serial"});
  map.read("model", scenario.robot_model);
  map.read("serial", scenario.robot_serial);
}

Scenario::Air air_value(const YamlValue& value) {
  constexpr Range kAny{-1e12, 1e12};  // a broken sensor says anything
  const YamlMap map(value, {"temperature_c", "pressure_mbar", "humidity_percent"});
  Scenario::Air air;
  map.read("temperature_c", air.temperature_c, kAny);
  map.read("pressure_mbar", air.pressure_mbar, kAny);
  map.read("humidity_percent", air.humidity_percent, kAny);
  return air;
}

void read_tracker(const YamlValue& value, Scenario& scenario) {
  const YamlMap map(value, {"noise", "reflector", "bias_mm", "std_mm", "air", "power_lock"});
  if (const YamlValue* noise = map.find("noise")) scenario.noise = tracker_noise_value(*noise);
  map.read("reflector", scenario.reflector_name);
  if (const YamlValue* bias = map.find("bias_mm")) scenario.bias_mm = point_value(*bias);
  if (const YamlValue* std_mm = map.find("std_mm")) scenario.std_mm = std_mm->number({-1e12, 1e12});
  if (const YamlValue* air = map.find("air")) scenario.air = air_value(*air);
  map.read("power_lock", scenario.power_lock);
}

std::vector<double> lag_value(const YamlValue& value, const RobotModel& robot) {
  constexpr Range kLag{0, 1000};
  if (!value.is_list()) return {value.number(kLag)};
  if (value.list().size() != robot.joints.size()) {
    value.fail("expected one time, or one for each of the " + std::to_string(robot.joints.size()) +
               " joints, found " + std::to_string(value.list().size()));
  }
  std::vector<double> lags;
  for (const YamlValue& axis : value.list()) lags.push_back(axis.number(kLag));
  return lags;
}

void read_rsi(const YamlValue& value, const path& folder, Scenario& scenario) {
  const YamlMap map(
      value, {"cycle_ms", "timeout_cycles", "axis_corr_limit_deg", "ethernet_xml", "dead_time_ms", "lag_ms",
              "hold_on", "ignores_correction", "delay", "precision", "source_port", "arm"});
  map.read("cycle_ms", scenario.cycle, 1, 100);
  map.read("timeout_cycles", scenario.rsi_timeout_cycles, 1, 100'000);
  map.read("axis_corr_limit_deg", scenario.axis_corr_limit_deg, {0.001, 100});
  scenario.ethernet_xml = map.at("ethernet_xml").path_from(folder);
  map.read("dead_time_ms", scenario.dead_time_ms, {0, 100});
  if (const YamlValue* lag = map.find("lag_ms")) scenario.lag_ms = lag_value(*lag, scenario.nominal);
  if (const YamlValue* hold_on = map.find("hold_on")) scenario.hold_on = hold_on->boolean();
  map.read("ignores_correction", scenario.ignores_correction);
  map.read("delay", scenario.consecutive_delay, {{"cumulative", false}, {"consecutive", true}});
  map.read("precision", scenario.rsi_decimals, 0, 15);
  if (const YamlValue* port = map.find("source_port"))
    scenario.rsi_source_port = static_cast<std::uint16_t>(port->integer(0, 65535));
  if (const YamlValue* arm = map.find("arm")) scenario.rsi_arm = load_robot(arm->path_from(folder));
}

/// A list of axis positions in deg (mm), within the joint limits.
JointVector joints_value(const YamlValue& value, const RobotModel& robot) {
  if (value.list().size() != robot.joints.size()) {
    value.fail("expected " + std::to_string(robot.joint_count()) + " axes, found " +
               std::to_string(value.list().size()));
  }
  JointVector q(robot.joint_count());
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    const YamlValue& axis = value.list()[i];
    const double position = axis.number({-1e6, 1e6}) * unit_of(joint);
    if (position < joint.min || position > joint.max)
      axis.fail("outside the limits of joint " + std::to_string(i + 1));
    q[static_cast<Eigen::Index>(i)] = position;
  }
  return q;
}

}  // namespace

Scenario load_scenario(const path& file) {
  const YamlValue root = read_yaml(file);
  const YamlMap map(root, {"robot", "errors", "drives", "repeatability_mm", "placement", "reflector",
                           "controller", "tracker", "rsi", "stream_path", "faults"});
  const path folder = file.parent_path();
  Scenario scenario;
  scenario.nominal = load_robot(map.at("robot").path_from(folder));
  scenario.truth = scenario.nominal;
  if (const YamlValue* errors = map.find("errors")) {
    errors->is_list() ? add_listed_errors(scenario.truth.joints, *errors)
                      : add_drawn_errors(scenario.truth.joints, *errors);
  }
  if (const YamlValue* drives = map.find("drives")) scenario.drives = drives_value(*drives, scenario.nominal);
  map.read("repeatability_mm", scenario.repeatability_mm, kNoiseMm);
  scenario.X_WB = pose_value(map.at("placement"));
  read_reflector(map.at("reflector"), scenario);
  if (const YamlValue* controller = map.find("controller")) read_controller(*controller, scenario);
  if (const YamlValue* tracker = map.find("tracker")) read_tracker(*tracker, scenario);
  read_rsi(map.at("rsi"), folder, scenario);
  if (const YamlValue* stops = map.find("stream_path")) {
    for (const YamlValue& stop : stops->list())
      scenario.stream_path.push_back(joints_value(stop, scenario.nominal));
  }
  if (const YamlValue* faults = map.find("faults")) {
    for (const YamlValue& fault : faults->list()) scenario.faults.push_back(fault_value(fault));
  }
  return scenario;
}

}  // namespace truepose::config
