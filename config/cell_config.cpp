#include "config/cell_config.hpp"

#include <algorithm>
#include <sstream>

#include "config/document_kind.hpp"
#include "config/robot_file.hpp"
#include "config/robot_library.hpp"
#include "config/yaml_layout.hpp"
#include "core/calibrate/option_names.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::record {

void layout(Io& io, TrackerNoiseModel& x) {
  io("range_mm", x.range_mm, Range{1e-6, 10});
  io("transverse_mm_per_m", x.transverse_mm_per_m, Range{1e-6, 10});
}

}  // namespace truepose::record

namespace truepose::config {

constexpr std::array kRearms{Named{"manual", Rearm::Manual}, Named{"automatic", Rearm::Automatic}};
constexpr std::array kRealtimePolicies{Named{"require", RealtimePolicy::Require},
                                       Named{"prefer", RealtimePolicy::Prefer},
                                       Named{"off", RealtimePolicy::Off}};
constexpr std::array kApproachSides{Named{"any", ApproachSide::Any}, Named{"upwards", ApproachSide::Upwards},
                                    Named{"alternate", ApproachSide::Alternate}};

/// HOST:PORT
struct HostPort {
  std::uint16_t least_port = 1;
  std::string form_of(const Endpoint& endpoint) const { return config::text(endpoint); }
  void read(const Io& io, Endpoint& x) const {
    const YamlValue& value = yaml_value(io);
    auto endpoint = parse_endpoint(value.text(), least_port);
    if (!endpoint) value.fail(endpoint.error());
    x = *std::move(endpoint);
  }
};

/// HOST:PORT of a socket of ours, or "off".
struct HostPortOrOff {
  void read(const Io& io, std::optional<Endpoint>& x) const {
    x.reset();
    if (yaml_value(io).text() != "off") HostPort{0}.read(io, x.emplace());
  }
};

/// "https://hmi.plant:8443"
struct Origins {
  std::string fault(const std::vector<std::string>& origins) const {
    for (const std::string& origin : origins) {
      const bool is_one = origin.starts_with("http://") || origin.starts_with("https://");
      const std::string host = is_one ? origin.substr(origin.find("://") + 3) : "";
      if (host.empty() || host.find('/') != std::string::npos)
        return "expected origins as browsers send them, as https://hmi.plant, found " + in_quotes(origin);
    }
    return {};
  }
};

/// A robot file, or the name of a shipped one.
struct RobotFileOrName {
  void read(const Io& io, std::filesystem::path& file) const try {
    const YamlValue& given = yaml_value(io);
    const std::filesystem::path named = given.text();
    file = named.has_parent_path() ? given.file() : robot_file_of(named, given.file().parent_path());
  } catch (const ConfigError& error) {
    yaml_value(io).fail(error.what());
  }
};

/// {kg, x, y, z} that the arm carries.
struct Payload {
  void read(const Io& io, RobotModel& robot) const { add_payload(robot, yaml_value(io)); }
};

struct LogLevel {
  friend std::vector<std::string_view> words_of(LogLevel) {
    return {"trace", "debug", "info", "warn", "error"};
  }
  friend std::string_view word_of(LogLevel, const std::string& level) { return level; }
  friend std::string meaning_of(LogLevel, std::string_view word) { return std::string{word}; }
};

struct OfDifferentTools {
  std::string fault(const std::vector<ToolLoad>& loads) const {
    for (auto load = loads.begin(); load != loads.end(); ++load)
      if (std::find_if(loads.begin(), load,
                       [&](const ToolLoad& other) { return other.tool == load->tool; }) != load)
        return "two loads of tool " + std::to_string(load->tool);
    return {};
  }
};

/// Files of measured tools, each of another number.
struct ToolFiles {
  const RobotModel& robot;
  void read(const Io& io, std::vector<ToolFile>& tools) const {
    for (const YamlValue& each : yaml_value(io).list()) {
      ToolFile tool = load_tool(each.file(), robot);
      if (std::ranges::find(tools, tool.number, &ToolFile::number) != tools.end())
        each.fail("another file is of tool " + std::to_string(tool.number) + " too");
      tools.push_back(std::move(tool));
    }
  }
};

// ---- Layouts. The file states the unit next to every number

void layout(Io& io, RobotConfig& x) {
  io("file", x.file, RobotFileOrName{});
  io.on_read(x, [](auto& robot) {
    robot.model = load_robot(robot.file);
    robot.body = load_body(robot.file);
  });
  io.optional("payload", x.model, Payload{});
  io("eki_motion", x.eki_motion, HostPort{});
  io("eki_state", x.eki_state, HostPort{});
  io.on_read(x, [](auto& robot) { robot.rsi_peer = robot.eki_motion.host; });
  io.optional("rsi_peer", x.rsi_peer);
  io.optional("expect_model", x.expect_model);
  io.optional("max_fk_deviation_mm", x.max_fk_deviation_mm, Range{0.001, 1000});
  io.optional("repeatability_mm", x.repeatability_mm, Range{1e-6, 10});
}

void layout(Io& io, StreamConfig& x) {
  io("listen", x.listen, HostPort{0});
  io("ethernet_xml", x.ethernet_xml);
  io.optional("cycle_ms", x.cycle, Whole{1, 100});
  io.optional("timeout_cycles", x.timeout_cycles, Whole{1, 100'000});
  io.optional("rearm", x.rearm, kRearms);
  io.optional("realtime", x.realtime, kRealtimePolicies);
  io.optional("priority", x.priority, Whole{1, 80});  // LimitRTPRIO= of the unit
  io.optional("cpu", x.cpu, Whole{-1, 1023});
  io.optional("max_step_deg", x.max_step_deg, Range{0.0001, 1});
  io.optional("max_total_deg", x.max_total_deg, Range{0.001, 10});
  io.optional("limit_margin_deg", x.limit_margin_deg, Range{0, 90});
  io.optional("singularity_threshold_deg", x.singularity_threshold_deg, Range{0, 45});
  io.optional("tcp", x.p_FT_mm, kPoint);
  io.optional("tool", x.tool, Whole{1, 1000});
  io.optional("ramp_ms", x.ramp, Whole{200, 60'000});
}
/// A step is small or large by the time that it takes: what the arm is asked for is a speed.
void check(const Io& io, const StreamConfig& stream) {
  constexpr double kGreatest_deg_s = 25;
  const double seconds = std::chrono::duration<double>(stream.cycle).count();
  if (stream.max_step_deg <= kGreatest_deg_s * seconds * (1 + 1e-9)) return;
  std::ostringstream text;
  text << "a step of " << stream.max_step_deg << " deg every " << stream.cycle.count() << " ms is "
       << stream.max_step_deg / seconds << " deg/s: expected at most " << kGreatest_deg_s << " deg/s, here "
       << kGreatest_deg_s * seconds << " deg";
  io.fail_at("max_step_deg", text.str());
}

void layout(Io& io, TrackerConfig& x) {
  io.optional("protocol", x.protocol, kTrackerProtocols);
  io("address", x.address, HostPort{});
  io.defaulted("reflector", x.reflector);
  io.optional("measure_ms", x.measure, Whole{1, 600'000});
  io.optional("reinitialise_after_min", x.reinitialise_after, Whole{0, 1440});
  io.optional("first_search_radius_mm", x.first_search_radius_mm, Range{1, 5000});
  io.optional("search_radius_mm", x.search_radius_mm, Range{1, 5000});
  io.optional("gate_mm", x.gate_mm, Range{0.1, 5000});
  io.optional("robot_base", x.robot_base, KukaPose{});
  io.optional("noise", x.noise);
  io.optional("beam_radius_mm", x.beam_radius_mm, Range{0, 1000});
  io.optional("max_std_mm", x.max_std_mm, Range{0, 10});
  io.optional("nests", x.nests_mm, kPoint);
  io.optional("air", x.air);
  io.defaulted("air_file", x.air_file);
  io.optional("air_max_age_s", x.air_max_age, Whole{1, 86'400});
}
void check(const Io& io, const TrackerConfig& tracker) {
  if (tracker.air && !tracker.air_file.empty())
    io.fail_at("air_file", "air is given already: leave one of them out");
  constexpr std::size_t kFewest = 3;  // by which a turn shows
  if (!tracker.nests_mm.empty() && tracker.nests_mm.size() < kFewest)
    io.fail_at("nests", "expected none or at least " + std::to_string(kFewest) + ", not all on one line");
}

void layout(Io& io, ReflectorConfig& x) {
  io.optional("name", x.name);
  io.optional("offset_mm", x.p_FS_mm, kPoint);
  io.optional("facing", x.facing_F, Direction{});
  io.optional("acceptance_deg", x.acceptance_deg, Range{1, 180});
}

/// A list of reflectors, the first of which is the cell's; they are called 1, 2, ... where no name is given.
struct Reflectors {
  void read(const Io& io, CellConfig& cell) const {
    const YamlValue& list = yaml_value(io);
    if (list.list().empty() || list.list().size() > kMostReflectors)
      list.fail("expected 1 to " + std::to_string(kMostReflectors) + " reflectors, found " +
                std::to_string(list.list().size()));
    std::vector<ReflectorConfig> all;
    for (const YamlValue& each : list.list()) {
      ReflectorConfig reflector{.name = std::to_string(all.size() + 1)};
      read_value(each, reflector);
      if (std::ranges::find(all, reflector.name, &ReflectorConfig::name) != all.end())
        each.fail("another reflector is called \"" + reflector.name + "\" too");
      all.push_back(std::move(reflector));
    }
    cell.reflector = all.front();
    cell.further_reflectors.assign(all.begin() + 1, all.end());
  }
};

void layout(Io& io, CampaignConfig& x) {
  io.optional("identify_poses", x.identify_poses, Whole{5, 10'000});
  io.optional("validate_poses", x.validate_poses, Whole{0, 10'000});
  io.optional("drift_poses", x.drift_poses, Whole{1, 1000});
  io.optional("coarse_after", x.coarse_after, Whole{5, 10'000});
  io.optional("seed", x.seed);
  io.optional("speed_percent", x.speed_percent, Range{1, 100});
  io.optional("settle_ms", x.settle, Whole{0, 60'000});
  io.optional("warm_up_s", x.warm_up, Whole{0, 86'400});
  io.optional("warm_up_moves", x.warm_up_moves, Whole{0, 1000});
  io.optional("retries", x.retries, Whole{0, 100});
  io.optional("pause_after_s", x.pause_after, Whole{1, 86'400});
  io.optional("pause_after_lost", x.pause_after_lost, Whole{0, 1000});
  io.optional("limit_margin_deg", x.limit_margin_deg, Range{0, 90});
  io.optional("singularity_margin_deg", x.singularity_margin_deg, Range{0, 45});
  io.optional("criterion", x.criterion, kCriteria);
  io.optional("candidates", x.candidates, Whole{10, 100'000});
  io.optional("nests_every", x.nests_every, Whole{1, 10'000});
  io.optional("correct_by_nests", x.correct_by_nests);
  io.optional("two_face_every", x.two_face_every, Whole{0, 10'000});
  io.optional("reference_every", x.reference_every, Whole{0, 10'000});
  io.optional("approach", x.approach, kApproachSides);
  io.optional("approach_deg", x.approach_deg, Range{0.1, 45});
  io.optional("remeasure", x.remeasure);
}
void check(const Io& io, const CampaignConfig& campaign) {
  if (campaign.coarse_after <= campaign.identify_poses) return;
  io.fail("coarse_after is more than identify_poses: expected at most " +
          std::to_string(campaign.identify_poses) + ", found " + std::to_string(campaign.coarse_after));
}

/// What stands around the arm, and on its flange, which is a part of its body.
struct SurroundingsAndTool {
  Surroundings& about;
  RobotConfig& robot;
};
void layout(Io& io, SurroundingsAndTool& x) {
  io.optional("floor_mm", x.about.floor_mm, kMm);
  io.optional("clearance_mm", x.about.clearance_mm, Range{0, 10'000});
  io.optional("tracker_radius_mm", x.about.tracker_radius_mm, Range{0, 10'000});
  io.optional("obstacles", x.about.obstacles);
  std::vector<Capsule> tool;
  io.optional("tool", tool);
  for (const Capsule& capsule : tool) x.robot.body.push_back({x.robot.model.joint_count() + 1, capsule});
}

void layout(Io& io, CalibrationConfig& x) {
  io.optional("non_geometric", x.non_geometric, kNoneOrAuto);
  io.optional("harmonics", x.harmonics, Whole{1, 10'000});
  io.optional("residual", x.field, kFieldNames);
  io.optional("loss", x.loss, kLossNames);
  io.optional("prior", x.prior, kPriorNames);
}

/// What a campaign goes by, apart from the cell that it is measured in.
struct CampaignOptions {
  CampaignConfig campaign;
  CalibrationConfig calibration;
};
void layout(Io& io, CampaignOptions& x) {
  io("campaign", x.campaign);
  io("calibration", x.calibration);
}

void layout(Io& io, Iso9283Config& x) {
  io.optional("cycles", x.cycles, Whole{2, 1000});
  io.optional("variation", x.variation);
  io.optional("centre", x.cube.centre_mm, kPoint);
  io.optional("edge_mm", x.cube.edge_mm, Range{50, 5000});
  io.optional("orientation", x.cube.orientation, KukaAngles{});
  io.optional("plane", x.cube.plane, kPlaneNames);
}

void layout(Io& io, TlsConfig& x) {
  io("listen", x.listen, HostPort{0});
  io("certificate", x.certificate);
  io("key", x.key);
}

void layout(Io& io, ControlConfig& x) {
  io.optional("listen", x.listen, HostPort{0});
  io("token_file", x.token_file);
  io.optional("tls", x.tls);
}

void layout(Io& io, WebConfig& x) {
  io.optional("listen", x.listen, HostPortOrOff{});
  io.optional("origins", x.origins, Origins{});
}

void layout(Io& io, RecordingConfig& x) {
  io.defaulted("folder", x.folder);
  io.optional("ring_mb", x.ring_mb, Whole{1, 4096});
  io.optional("max_files", x.max_files, Whole{1, 1000});
  io.optional("max_mb", x.max_mb, Whole{1, 1'000'000});
}

void layout(Io& io, ToolLoad& x) {
  io("tool", x.tool, Whole{0, 1000});
  layout(io, x.payload);
}

void layout(Io& io, CellConfig& x) {
  io("name", x.name);
  io("robot", x.robot);
  io.optional("tools", x.tools, ToolFiles{x.robot.model});
  io.optional("loads", x.loads, OfDifferentTools{});
  io("stream", x.stream);
  io("tracker", x.tracker);
  io.optional("reflector", x.reflector);
  io.optional("reflectors", x, Reflectors{});
  io.optional("surroundings", SurroundingsAndTool{x.surroundings, x.robot});
  io.optional("workspace", x.workspace);
  io.on_read(x, [](auto& cell) { cell.task = cell.workspace; });
  io.optional("task", x.task);
  io.optional("campaign", x.campaign);
  io.optional("calibration", x.calibration);
  io.optional("iso9283", x.iso9283);
  io("control", x.control);
  io.optional("web", x.web);
  io("store", x.store);
  io.on_read(x, [](auto& cell) { cell.recording.folder = cell.store.string() + ".recordings"; });
  io.optional("recording", x.recording);
  io.optional("runtime", x.runtime);
  io.optional("log_level", x.log_level, LogLevel{});
}

void check(const Io& io, const CellConfig&) {
  if (io.has("reflector", false) && io.has("reflectors", false))
    io.fail_at("reflectors", "reflector is given already: leave one of them out");
}

std::vector<ReflectorConfig> reflectors_of(const CellConfig& cell) {
  std::vector<ReflectorConfig> all{cell.reflector};
  all.insert(all.end(), cell.further_reflectors.begin(), cell.further_reflectors.end());
  return all;
}

const ToolFile* tool_of(const CellConfig& cell, int number) {
  const auto found = std::ranges::find(cell.tools, number, &ToolFile::number);
  return found == cell.tools.end() ? nullptr : &*found;
}

CellConfig load_cell(const std::filesystem::path& file) {
  const YamlValue yaml = read_yaml(file);
  expect_kind(yaml, DocumentKind::Cell);
  CellConfig cell;
  read_value(yaml, cell);
  return cell;
}

std::string campaign_options(const CellConfig& cell) {
  return yaml_of(CampaignOptions{cell.campaign, cell.calibration});
}

// By hand is what a layout does not have, as the name of the robot's model, and what keeps secrets: of these
// sections a key is shown only where it is named here.
boost::json::object cell_json(const CellConfig& cell) {
  const RobotConfig& robot = cell.robot;
  const WebConfig web = cell.web.value_or(WebConfig{});
  return {{"name", cell.name},
          {"robot",
           {{"file", robot.file.string()},
            {"model", robot.model.name},
            {"eki_motion", text(robot.eki_motion)},
            {"eki_state", text(robot.eki_state)},
            {"expect_model", robot.expect_model}}},
          {"loads", value_json(cell.loads)},
          {"stream", value_json(cell.stream)},
          {"tracker", value_json(cell.tracker)},
          {"reflectors", value_json(reflectors_of(cell))},
          {"campaign", value_json(cell.campaign)},
          {"calibration", value_json(cell.calibration)},
          {"iso9283", value_json(cell.iso9283)},
          {"control", {{"listen", text(cell.control.listen)}}},
          {"web", {{"listen", web.listen ? boost::json::value(text(*web.listen)) : boost::json::value{}}}},
          {"store", cell.store.string()},
          {"recording", value_json(cell.recording)}};
}

void use_campaign_options(CellConfig& cell, const std::string& text) {
  CampaignOptions options;
  read_value(parse_yaml(text, "the campaign's options"), options);
  cell.campaign = std::move(options.campaign);
  cell.calibration = std::move(options.calibration);
}

void use_robot(CellConfig& cell, const std::filesystem::path& file) {
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
