#include "config/scenario.hpp"

#include <algorithm>

#include "config/robot_file.hpp"
#include "config/yaml_poses.hpp"
#include "config/yaml_reader.hpp"
#include "core/kinematics/angles.hpp"
#include "core/kinematics/joint_units.hpp"
#include "core/random.hpp"

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

void read_tracker(const YamlValue& value, Scenario& scenario) {
  const YamlMap map(value, {"noise", "reflector"});
  if (const YamlValue* noise = map.find("noise")) scenario.noise = tracker_noise_value(*noise);
  map.read("reflector", scenario.reflector_name);
}

void read_rsi(const YamlValue& value, const path& folder, Scenario& scenario) {
  const YamlMap map(value, {"cycle_ms", "timeout_cycles", "axis_corr_limit_deg", "ethernet_xml"});
  map.read("cycle_ms", scenario.cycle, 1, 100);
  map.read("timeout_cycles", scenario.rsi_timeout_cycles, 1, 100'000);
  map.read("axis_corr_limit_deg", scenario.axis_corr_limit_deg, {0.001, 100});
  scenario.ethernet_xml = map.at("ethernet_xml").path_from(folder);
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

Scenario::Fault fault_value(const YamlValue& value) {
  const YamlMap map(value, {"at_ms", "kind", "lasts_ms"});
  constexpr int kYear_s = 31'536'000;
  Scenario::Fault fault;
  fault.at = std::chrono::milliseconds(map.at("at_ms").integer(0, std::int64_t{1000} * kYear_s));
  map.at("kind");
  map.read("kind", fault.kind,
           {{"beam-break", std::string("beam-break")},
            {"tracker-restart", "tracker-restart"},
            {"eki-drop", "eki-drop"},
            {"rsi-drop", "rsi-drop"}});
  map.read("lasts_ms", fault.lasts, 0, 86'400'000);
  return fault;
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
