#include "config/scenario.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "config/document_kind.hpp"
#include "config/robot_file.hpp"
#include "config/yaml_layout.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/random.hpp"

namespace truepose::config {

constexpr Range kErrorMm{-100, 100};
constexpr Range kErrorRad{-0.1, 0.1};
constexpr Range kNoiseMm{0, 10};
constexpr std::array kDelays{Named{"cumulative", false}, Named{"consecutive", true}};

// ---- What the arm really is

/// What is added to the link parameters of one joint.
struct LinkError {
  double a_mm = 0, alpha_rad = 0, d_mm = 0, theta_rad = 0, beta_rad = 0;
};
void layout(Io& io, LinkError& x) {
  io.optional("a", x.a_mm, kErrorMm);
  io.optional("alpha", x.alpha_rad, kErrorRad);
  io.optional("d", x.d_mm, kErrorMm);
  io.optional("theta", x.theta_rad, kErrorRad);
  io.optional("beta", x.beta_rad, kErrorRad);
}

/// Every parameter off by a uniform error within +-mm or +-rad, the same for the same seed on every machine.
struct DrawnErrors {
  std::uint64_t seed = 0;
  double mm = 0, rad = 0;
};
void layout(Io& io, DrawnErrors& x) {
  io("seed", x.seed);
  io("mm", x.mm, Range{0, kErrorMm.max});
  io("rad", x.rad, Range{0, kErrorRad.max});
}

struct PerJoint {
  std::size_t joints;
  std::string_view first = "expected one entry for each";
  void check(const YamlValue& list) const {
    if (list.list().size() == joints) return;
    list.fail(std::string{first} + " of the " + std::to_string(joints) + " joints, found " +
              std::to_string(list.list().size()));
  }
};

/// Errors listed joint by joint, or drawn.
struct LinkErrors {
  void read(const Io& io, RobotModel& truth) const {
    const YamlValue& value = yaml_value(io);
    std::vector<LinkError> errors;
    if (value.is_list()) {
      PerJoint{truth.joints.size()}.check(value);
      read_value(value, errors);
    } else {
      DrawnErrors drawn;
      read_value(value, drawn);
      Random random(drawn.seed);
      const auto mm = [&] { return random.uniform(-drawn.mm, drawn.mm); };
      const auto rad = [&] { return random.uniform(-drawn.rad, drawn.rad); };
      // Braces: drawn in this order.
      for (std::size_t i = 0; i < truth.joints.size(); ++i)
        errors.push_back({mm(), rad(), mm(), rad(), rad()});
    }
    for (std::size_t i = 0; i < errors.size(); ++i) {
      Joint& joint = truth.joints[i];
      joint.a_mm += errors[i].a_mm;
      joint.alpha_rad += errors[i].alpha_rad;
      joint.d_mm += errors[i].d_mm;
      joint.theta_rad += errors[i].theta_rad;
      joint.beta_rad += errors[i].beta_rad;
    }
  }
};

}  // namespace truepose::config

namespace truepose::record {

void layout(Io& io, HeavyArmOptions& x) {
  io.optional("payload_kg", x.payload_kg, Range{0, 1000});
  io.optional("compliance", x.compliance);
  io.optional("harmonics", x.harmonics);
  io.optional("backlash_deg", x.backlash_rad, Degrees{}, Range{0, 1});
  io.optional("seed", x.seed);
}

}  // namespace truepose::record

namespace truepose::config {

/// Errors of the joints' drives.
struct DriveErrors {
  const RobotModel& robot;
  void read(const Io& io, NonGeometricErrors& drives) const {
    const YamlValue& value = yaml_value(io);
    const bool heavy_arm =
        robot.joints.size() == 6 && std::ranges::all_of(robot.joints, [](const Joint& joint) {
          return joint.type == JointType::Revolute;
        });
    if (!heavy_arm) value.fail("known for arms of six revolute joints alone; leave it out");
    HeavyArmOptions options;
    read_value(value, options);
    drives = heavy_arm_errors(options);
  }
};

/// What warmth does, in the units of the file.
struct Warmth {
  std::vector<double> zero;  // deg, mm
  double expansion_ppm = 0;
  double minutes = 30;
};
void layout(Io& io, Warmth& x) {
  io.optional("zero", x.zero, Range{-1, 1});
  io.optional("expansion_ppm", x.expansion_ppm, Range{-1000, 1000});
  io.optional("minutes", x.minutes, Range{0.1, 1000});
}

struct WarmUpOf {
  const RobotModel& robot;
  void read(const Io& io, WarmUp& warm_up) const {
    const YamlValue& value = yaml_value(io);
    Warmth warmth;
    read_value(value, warmth);
    if (!warmth.zero.empty() && warmth.zero.size() != robot.joints.size())
      value.fail("zero: expected one for each of the " + std::to_string(robot.joints.size()) + " joints");
    if (!warmth.zero.empty()) warm_up.zero = joints_from(warmth.zero, robot);
    warm_up.growth = 1e-6 * warmth.expansion_ppm;
    warm_up.time_constant = std::chrono::duration<double, std::ratio<60>>{warmth.minutes};
  }
};

// ---- The scenario, part by part

void layout(Io& io, Scenario::TrackerNoise& x) {
  io.optional("range_mm", x.range_mm, kNoiseMm);
  io.optional("range_mm_per_m", x.range_mm_per_m, kNoiseMm);
  io.optional("transverse_mm", x.transverse_mm, kNoiseMm);
  io.optional("transverse_mm_per_m", x.transverse_mm_per_m, kNoiseMm);
}

void layout(Io& io, Scenario::Air& x) {
  io.optional("temperature_c", x.temperature_c, kReported);
  io.optional("pressure_mbar", x.pressure_mbar, kReported);
  io.optional("humidity_percent", x.humidity_percent, kReported);
}

// Parts of the file whose members are the scenario's own.

struct ReflectorPart {
  Scenario& scenario;
};
/// What is hidden by the arm: its body as its robot file says, with a tool on its flange.
struct OcclusionPart {
  Scenario& scenario;
  std::filesystem::path robot_file;
};
struct ControllerPart {
  Scenario& scenario;
};
struct TrackerPart {
  Scenario& scenario;
};
struct RsiPart {
  Scenario& scenario;
};

void layout(Io& io, SixDTarget& x) {
  io("orientation", x.R_FT, KukaAngles{});
  io("std_deg", x.sigma_rad, Degrees{}, Range{1e-6, 5});
}

}  // namespace truepose::config

namespace truepose::record {

void layout(Io& io, TrueReflector& x) {
  io("offset_mm", x.p_FS_mm, kPoint);
  io.optional("facing", x.facing_F, Direction{});
  io.optional("acceptance_deg", x.acceptance_rad, Degrees{}, Range{1, 180});
}

}  // namespace truepose::record

namespace truepose::config {

void layout(Io& io, ReflectorPart& x) {
  io("offset_mm", x.scenario.p_FS_mm, kPoint);
  io.optional("facing", x.scenario.facing_F, Direction{});
  io.optional("acceptance_deg", x.scenario.acceptance_deg, Range{1, 180});
  io.optional("target_6d", x.scenario.target_6d);
}

void layout(Io& io, OcclusionPart& x) {
  io("body", x.robot_file);
  std::vector<Capsule> tool;
  io.optional("tool", tool);
  io.on_read(x, [&](auto& part) {
    part.scenario.body = load_body(part.robot_file);
    const int flange = part.scenario.nominal.joint_count() + 1;
    for (const Capsule& capsule : tool) part.scenario.body.push_back({flange, capsule});
  });
}

void layout(Io& io, ControllerPart& x) {
  io.optional("model", x.scenario.robot_model);
  io.optional("serial", x.scenario.robot_serial, Whole{0, 999'999'999});
  io.optional("files", x.scenario.controller_files);
  io.optional("archive", x.scenario.archive);
  io.optional("programs", x.scenario.programs);
  io.optional("pass_advance_run", x.scenario.pass_advance_run);
  io.optional("selected", x.scenario.selected);
  io.optional("operator_s", x.scenario.operator_s, Range{0, 1e6});
}

constexpr Range kUrad{-1000, 1000};

/// Millionths of a radian.
struct Microradians {
  double form_of(double rad) const { return 1e6 * rad; }
  double value_of(double urad) const { return 1e-6 * urad; }
};

/// The same about three axes.
struct MicroradiansXyz {
  Eigen::Vector3d form_of(const Eigen::Vector3d& rad) const { return 1e6 * rad; }
  Eigen::Vector3d value_of(const Eigen::Vector3d& urad) const { return 1e-6 * urad; }
};

}  // namespace truepose::config

namespace truepose::record {

using config::kUrad, config::Microradians, config::MicroradiansXyz;

void layout(Io& io, AimingErrors& x) {
  io.optional("collimation", x.collimation, Microradians{}, kUrad);
  io.optional("tilt", x.tilt, Microradians{}, kUrad);
  io.optional("index", x.index, Microradians{}, kUrad);
}

void layout(Io& io, TrackerWarming& x) {
  io.optional("range_mm", x.range_mm, Range{-10, 10});
  io.optional("horizontal_urad", x.horizontal_rad, Microradians{}, kUrad);
  io.optional("vertical_urad", x.vertical_rad, Microradians{}, kUrad);
  io.optional("minutes", x.minutes, Range{0.1, 1000});
}

void layout(Io& io, TripodDrift& x) {
  io.optional("mm_per_hour", x.mm_per_hour, kPoint);
  io.optional("urad_per_hour", x.rad_per_hour, MicroradiansXyz{}, Xyz{kUrad});
}

}  // namespace truepose::record

namespace truepose::config {

void layout(Io& io, TrackerPart& x) {
  io.optional("noise", x.scenario.noise);
  io.optional("bias_mm", x.scenario.bias_mm, kPoint);
  io.optional("std_mm", x.scenario.std_mm, kReported);
  io.optional("air", x.scenario.air);
  io.optional("power_lock", x.scenario.power_lock);
  TrackerInstrument& instrument = x.scenario.instrument;
  io.optional("weather_station", instrument.weather_station);
  io.optional("true_air", instrument.air);
  io.optional("aiming_urad", instrument.aiming);
  io.optional("nests_mm", instrument.nests_mm, kPoint);
  io.optional("warm_up", instrument.warming);
  io.optional("tripod", instrument.stand);
}

/// One time of all axes, or one of each.
struct Lag {
  std::size_t joints;
  void read(const Io& io, std::vector<double>& lag_ms) const {
    const YamlValue& value = yaml_value(io);
    constexpr Range kLag{0, 1000};
    if (!value.is_list()) {
      lag_ms = {value.number(kLag)};
      return;
    }
    PerJoint{joints, "expected one time, or one for each"}.check(value);
    read_value(value, lag_ms, kLag);
  }
};

/// The arm of another file.
struct RobotOf {
  void read(const Io& io, auto& robot) const { robot = load_robot(yaml_value(io).file()); }
};

void layout(Io& io, RsiPart& part) {
  Scenario& x = part.scenario;
  io.optional("cycle_ms", x.cycle, Whole{1, 100});
  io.optional("timeout_cycles", x.rsi_timeout_cycles, Whole{1, 100'000});
  io.optional("axis_corr_limit_deg", x.axis_corr_limit_deg, Range{0.001, 100});
  io("ethernet_xml", x.ethernet_xml);
  io.optional("dead_time_ms", x.dead_time_ms, Range{0, 100});
  io.optional("lag_ms", x.lag_ms, Lag{x.nominal.joints.size()});
  io.optional("hold_on", x.hold_on);
  io.optional("ignores_correction", x.ignores_correction);
  io.optional("delay", x.consecutive_delay, kDelays);
  io.optional("precision", x.rsi_decimals, Whole{0, 15});
  io.optional("source_port", x.rsi_source_port, Whole{0, 65535});
  io.optional("arm", x.rsi_arm, RobotOf{});
}

/// Lists of axis positions in deg (mm), within the joint limits.
struct Stops {
  const RobotModel& robot;
  void read(const Io& io, std::vector<JointVector>& stops) const {
    for (const YamlValue& stop : yaml_value(io).list()) stops.push_back(position(stop));
  }
  JointVector position(const YamlValue& value) const {
    if (value.list().size() != robot.joints.size()) {
      value.fail("expected " + std::to_string(robot.joint_count()) + " axes, found " +
                 std::to_string(value.list().size()));
    }
    JointVector q(robot.joint_count());
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      const Joint& joint = robot.joints[i];
      const YamlValue& axis = value.list()[i];
      const double at = axis.number({-1e6, 1e6}) * unit_of(joint);
      if (at < joint.min || at > joint.max) axis.fail("outside the limits of joint " + std::to_string(i + 1));
      q[static_cast<Eigen::Index>(i)] = at;
    }
    return q;
  }
};

void layout(Io& io, Scenario& x) {
  io("robot", x.nominal, RobotOf{});
  io.on_read(x, [](auto& scenario) { scenario.truth = scenario.nominal; });
  io.optional("errors", x.truth, LinkErrors{});
  io.optional("drives", x.drives, DriveErrors{x.nominal});
  io.optional("warm_up", x.warm_up, WarmUpOf{x.nominal});
  io.optional("repeatability_mm", x.repeatability_mm, kNoiseMm);
  io("robot_base", x.X_WB, KukaPose{});
  io("reflector", ReflectorPart{x});
  io.optional("further_reflectors", x.further_reflectors);
  io.optional("occlusion", OcclusionPart{x, {}});
  io.optional("controller", ControllerPart{x});
  io.optional("tracker", TrackerPart{x});
  io("rsi", RsiPart{x});
  io.optional("stream_path", x.stream_path, Stops{x.nominal});
  io.optional("faults", x.faults);
}

Scenario load_scenario(const std::filesystem::path& file) {
  const YamlValue yaml = read_yaml(file);
  expect_kind(yaml, DocumentKind::Scenario);
  Scenario scenario;
  read_value(yaml, scenario);
  return scenario;
}

}  // namespace truepose::config
