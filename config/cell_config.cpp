#include "config/cell_config.hpp"

#include <sstream>
#include <utility>

#include "config/number_text.hpp"
#include "config/ranges.hpp"
#include "config/robot_file.hpp"
#include "config/robot_payload.hpp"
#include "config/yaml_poses.hpp"
#include "config/yaml_reader.hpp"
#include "core/identify/option_names.hpp"

namespace truepose::config {

namespace {

using std::filesystem::path;

Endpoint endpoint(const YamlValue& value, std::uint16_t least_port = 1) {
  auto read = parse_endpoint(value.text(), least_port);
  if (!read) value.fail(read.error());
  return *std::move(read);
}

RobotConfig robot_config(const YamlValue& value, const path& folder) {
  const YamlMap map(value, {"file", "eki_motion", "eki_state", "rsi_peer", "expect_model",
                            "max_fk_deviation_mm", "repeatability_mm", "payload"});
  RobotConfig robot;
  robot.file = map.at("file").path_from(folder);
  robot.model = load_robot(robot.file);
  robot.body = load_body(robot.file);
  if (const YamlValue* payload = map.find("payload")) add_payload(robot.model, *payload);
  robot.eki_motion = endpoint(map.at("eki_motion"));
  robot.eki_state = endpoint(map.at("eki_state"));
  robot.rsi_peer = robot.eki_motion.host;
  map.read("rsi_peer", robot.rsi_peer);
  map.read("expect_model", robot.expect_model);
  map.read("max_fk_deviation_mm", robot.max_fk_deviation_mm, {0.001, 1000});
  map.read("repeatability_mm", robot.repeatability_mm, {1e-6, 10});
  return robot;
}

/// A step is small or large by the time that it takes: what the arm is asked for is a speed.
void check_speed(const StreamConfig& stream, const YamlMap& map) {
  constexpr double kGreatest_deg_s = 25;
  const double seconds = std::chrono::duration<double>(stream.cycle).count();
  if (stream.max_step_deg <= kGreatest_deg_s * seconds * (1 + 1e-9)) return;
  std::ostringstream text;
  text << "a step of " << stream.max_step_deg << " deg every " << stream.cycle.count() << " ms is "
       << stream.max_step_deg / seconds << " deg/s: expected at most " << kGreatest_deg_s << " deg/s, here "
       << kGreatest_deg_s * seconds << " deg";
  map.at("max_step_deg").fail(text.str());
}

StreamConfig stream_config(const YamlValue& value, const path& folder) {
  const YamlMap map(value,
                    {"listen", "ethernet_xml", "cycle_ms", "timeout_cycles", "rearm", "realtime", "priority",
                     "max_step_deg", "max_total_deg", "limit_margin_deg", "singular_deg", "tcp", "ramp_ms"});
  StreamConfig stream;
  stream.listen = endpoint(map.at("listen"), 0);
  stream.ethernet_xml = map.at("ethernet_xml").path_from(folder);
  map.read("cycle_ms", stream.cycle, 1, 100);
  map.read("timeout_cycles", stream.timeout_cycles, 1, 100'000);
  map.read("rearm", stream.rearm, {{"manual", Rearm::Manual}, {"automatic", Rearm::Automatic}});
  map.read("realtime", stream.realtime,
           {{"require", RealtimePolicy::Require},
            {"prefer", RealtimePolicy::Prefer},
            {"off", RealtimePolicy::Off}});
  map.read("priority", stream.priority, 1, 80);  // LimitRTPRIO= of the unit
  map.read("max_step_deg", stream.max_step_deg, {0.0001, 1});
  check_speed(stream, map);
  map.read("max_total_deg", stream.max_total_deg, {0.001, 10});
  map.read("limit_margin_deg", stream.limit_margin_deg, {0, 90});
  map.read("singular_deg", stream.singular_deg, {0, 45});
  if (const YamlValue* tcp = map.find("tcp")) stream.p_FT_mm = point_value(*tcp);
  map.read("ramp_ms", stream.ramp, 200, 60'000);
  return stream;
}

TrackerNoiseModel noise_value(const YamlValue& value) {
  const YamlMap map(value, {"range_mm", "transverse_mm_per_m"});
  return {.range_mm = map.at("range_mm").number({1e-6, 10}),
          .transverse_mm_per_m = map.at("transverse_mm_per_m").number({1e-6, 10})};
}

TrackerConfig tracker_config(const YamlValue& value) {
  const YamlMap map(value, {"address", "reflector", "measure_ms", "search_first_mm", "search_mm", "gate_mm",
                            "placement", "noise", "beam_radius_mm"});
  TrackerConfig tracker;
  tracker.address = endpoint(map.at("address"));
  map.read("reflector", tracker.reflector);
  map.read("measure_ms", tracker.measure, 1, 600'000);
  map.read("search_first_mm", tracker.search_first_mm, {1, 5000});
  map.read("search_mm", tracker.search_mm, {1, 5000});
  map.read("gate_mm", tracker.gate_mm, {0.1, 5000});
  if (const YamlValue* placement = map.find("placement")) tracker.placement = pose_value(*placement);
  if (const YamlValue* noise = map.find("noise")) tracker.noise = noise_value(*noise);
  map.read("beam_radius_mm", tracker.beam_radius_mm, {0, 1000});
  return tracker;
}

ReflectorConfig reflector_config(const YamlValue& value) {
  const YamlMap map(value, {"name", "offset_mm", "facing", "acceptance_deg"});
  ReflectorConfig reflector;
  map.read("name", reflector.name);
  if (const YamlValue* offset = map.find("offset_mm")) reflector.p_FS_mm = point_value(*offset);
  if (const YamlValue* facing = map.find("facing")) reflector.facing_F = direction_value(*facing);
  map.read("acceptance_deg", reflector.acceptance_deg, {1, 180});
  return reflector;
}

CampaignConfig campaign_config(const YamlValue& value) {
  const YamlMap map(
      value, {"identify_poses", "validate_poses", "drift_poses", "coarse_after", "seed", "speed_percent",
              "settle_ms", "warm_up_s", "warm_up_moves", "retries", "limit_margin_deg", "wrist_margin_deg",
              "criterion", "candidates", "reference_every", "approach", "approach_deg", "remeasure"});
  CampaignConfig campaign;
  map.read("identify_poses", campaign.identify_poses, 5, 10'000);
  map.read("validate_poses", campaign.validate_poses, 0, 10'000);
  map.read("drift_poses", campaign.drift_poses, 1, 1000);
  map.read("coarse_after", campaign.coarse_after, 5, 10'000);
  if (const YamlValue* seed = map.find("seed")) campaign.seed = seed->seed();
  map.read("speed_percent", campaign.speed_percent, {1, 100});
  map.read("settle_ms", campaign.settle, 0, 60'000);
  if (const YamlValue* warm_up = map.find("warm_up_s"))
    campaign.warm_up = std::chrono::seconds(warm_up->integer(0, 86'400));
  map.read("warm_up_moves", campaign.warm_up_moves, 0, 1000);
  map.read("retries", campaign.retries, 0, 100);
  map.read("limit_margin_deg", campaign.limit_margin_deg, {0, 90});
  map.read("wrist_margin_deg", campaign.wrist_margin_deg, {0, 45});
  map.read("criterion", campaign.criterion,
           {{"i", DesignCriterion::I}, {"d", DesignCriterion::D}, {"a", DesignCriterion::A}});
  map.read("candidates", campaign.candidates, 10, 100'000);
  map.read("reference_every", campaign.reference_every, 0, 10'000);
  map.read("approach", campaign.approach,
           {{"any", ApproachSide::Any},
            {"upwards", ApproachSide::Upwards},
            {"alternate", ApproachSide::Alternate}});
  map.read("approach_deg", campaign.approach_deg, {0.1, 45});
  map.read("remeasure", campaign.remeasure);
  if (campaign.coarse_after > campaign.identify_poses) {
    value.fail("coarse_after is more than identify_poses: expected at most " +
               std::to_string(campaign.identify_poses) + ", found " + std::to_string(campaign.coarse_after));
  }
  return campaign;
}

Surroundings surroundings_config(const YamlValue& value, RobotConfig& robot) {
  const YamlMap map(value, {"floor_mm", "clearance_mm", "tracker_radius_mm", "obstacles", "tool"});
  Surroundings about;
  map.read("floor_mm", about.floor_mm, kMm);
  map.read("clearance_mm", about.clearance_mm, {0, 10'000});
  map.read("tracker_radius_mm", about.tracker_radius_mm, {0, 10'000});
  if (const YamlValue* obstacles = map.find("obstacles")) about.obstacles = capsules_value(*obstacles);
  if (const YamlValue* tool = map.find("tool")) {
    for (const Capsule& capsule : capsules_value(*tool))
      robot.body.push_back({robot.model.joint_count() + 1, capsule});
  }
  return about;
}

CalibrationConfig calibration_config(const YamlValue& value) {
  const YamlMap map(value, {"deviation", "harmonics", "residual", "loss"});
  CalibrationConfig calibration;
  map.read("deviation", calibration.deviation, {{"none", false}, {"auto", true}});
  if (const YamlValue* harmonics = map.find("harmonics")) {
    calibration.harmonics.clear();
    for (const YamlValue& multiple : harmonics->list())
      calibration.harmonics.push_back(static_cast<int>(multiple.integer(1, 10'000)));
  }
  if (const auto residual = map.choice("residual", residual_names()))
    calibration.residual = *residual_kinds(*residual);
  if (const auto loss = map.choice("loss", names_of(kLossNames)))
    calibration.loss = value_of(kLossNames, *loss);
  return calibration;
}

Iso9283Config iso9283_config(const YamlValue& value) {
  const YamlMap map(value, {"cycles", "variation", "centre", "edge_mm", "orientation", "plane"});
  Iso9283Config iso9283;
  map.read("cycles", iso9283.cycles, 2, 1000);
  map.read("variation", iso9283.variation);
  if (const YamlValue* centre = map.find("centre")) iso9283.cube.centre_mm = point_value(*centre);
  if (map.find("edge_mm")) map.read("edge_mm", iso9283.cube.edge_mm.emplace(), {50, 5000});
  if (const YamlValue* orientation = map.find("orientation"))
    iso9283.cube.orientation = orientation_value(*orientation);
  if (const auto plane = map.choice("plane", names_of(kPlaneNames)))
    iso9283.cube.plane = value_of(kPlaneNames, *plane);
  return iso9283;
}

ControlConfig control_config(const YamlValue& value, const path& folder) {
  const YamlMap map(value, {"listen", "token_file"});
  ControlConfig control;
  if (const YamlValue* listen = map.find("listen")) control.listen = endpoint(*listen, 0);
  control.token_file = map.at("token_file").path_from(folder);
  return control;
}

}  // namespace

CellConfig load_cell(const path& file) {
  const YamlValue root = read_yaml(file);
  const YamlMap map(root,
                    {"name", "robot", "stream", "tracker", "reflector", "surroundings", "workspace", "task",
                     "campaign", "calibration", "iso9283", "control", "store", "runtime", "log_level"});
  const path folder = file.parent_path();
  CellConfig cell;
  cell.name = map.at("name").text();
  cell.robot = robot_config(map.at("robot"), folder);
  cell.stream = stream_config(map.at("stream"), folder);
  cell.tracker = tracker_config(map.at("tracker"));
  if (const YamlValue* reflector = map.find("reflector")) cell.reflector = reflector_config(*reflector);
  if (const YamlValue* about = map.find("surroundings")) {
    cell.surroundings = surroundings_config(*about, cell.robot);
  }
  if (const YamlValue* workspace = map.find("workspace")) cell.workspace = box_value(*workspace);
  cell.task = cell.workspace;
  if (const YamlValue* task = map.find("task")) cell.task = box_value(*task);
  if (const YamlValue* campaign = map.find("campaign")) cell.campaign = campaign_config(*campaign);
  if (const YamlValue* calibration = map.find("calibration")) {
    cell.calibration = calibration_config(*calibration);
  }
  if (const YamlValue* iso9283 = map.find("iso9283")) cell.iso9283 = iso9283_config(*iso9283);
  cell.control = control_config(map.at("control"), folder);
  cell.store = map.at("store").path_from(folder);
  if (const YamlValue* runtime = map.find("runtime")) cell.runtime = runtime->path_from(folder);
  map.read("log_level", cell.log_level,
           {{"trace", std::string("trace")},
            {"debug", "debug"},
            {"info", "info"},
            {"warn", "warn"},
            {"error", "error"}});
  return cell;
}

void use_robot(CellConfig& cell, const path& file) {
  RobotConfig& robot = cell.robot;
  const int flange = robot.model.joint_count() + 1;
  robot.file = file;
  robot.model = load_robot(file);
  std::vector<BodyPart> body = load_body(file);
  for (const BodyPart& part : robot.body) {
    if (part.link == flange) body.push_back({robot.model.joint_count() + 1, part.capsule});
  }
  robot.body = std::move(body);
}

}  // namespace truepose::config
