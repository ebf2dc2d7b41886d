#include "proto/rpc/campaign.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string_view>

#include "core/calibrate/option_names.hpp"
#include "proto/record/forms.hpp"

namespace truepose::rpc {

using record::kCount, record::kLargeCount, record::OneOf, record::Range, record::Size, record::Unless,
    record::Whole;

namespace {

/// The parameters of each kind. Every kind has kind and note.
const std::map<std::string_view, std::set<std::string_view>>& params_of_kinds() {
  static const std::map<std::string_view, std::set<std::string_view>> kParams{
      {"calibration", {"identify_poses", "validate_poses", "seed", "remeasure", "activate"}},
      {"targets", {"joints", "poses", "validate_poses", "rounds", "tolerance_mm", "readings", "seed"}},
      {"iso9283", {"cycles", "variation", "compensate", "seed"}},
      {"tool",
       {"number", "points", "at", "nominal", "facing", "orientation", "together", "poses_per_point", "seed"}},
      {"base", {"number", "points", "at", "nominal", "touch", "readings"}}};
  return kParams;
}

}  // namespace

void layout(Io& io, CampaignProgress& x) {
  io.record("CampaignProgress");
  io.about("The campaign").format("uuid")("id", x.id);
  io.about("What it measures for")("kind", x.kind,
                                   OneOf{"calibration", "drift", "targets", "iso9283", "tool", "base"});
  io("phase", x.phase,
     OneOf{"connecting", "warming_up", "identifying", "validating", "computing", "remeasuring", "correcting",
           "cycling", "measuring", "activating", "paused", "done", "aborted", "failed", "interrupted"});
  io.about("Poses measured over all phases")("done", x.done, kCount);
  io.about("Poses of the plan over all phases")("total", x.total, kCount);
  io.about(
        "Present mean position error: of the fit while identifying, of the last phase afterwards; null "
        "before the first fit")
      .nullable("error_mm", x.error_mm);
  io.about("Time left, s; null while unknown, and while the campaign is paused or waits for a device")
      .nullable("eta_s", x.eta_s);
  io.about("Poses given up so far").optional("skipped", x.skipped, kCount);
  io.about("Poses to come: done, skipped and left are total").optional("left", x.left, kCount);
  io.about("Why it was aborted or interrupted or failed, or its model not activated; else empty")
      .optional("reason", x.reason);
  io.about("Only in an event: an attempt failed, or a device is waited for, and what is done about it")
      .optional("trouble", x.trouble);
  io.about("The model that it made; null before done").nullable("model_id", x.model_id);
}

void layout(Io& io, CampaignSummary& x) {
  io.record("CampaignSummary");
  io.about("The campaign").format("uuid")("id", x.id);
  io("kind", x.kind, OneOf{"calibration", "drift", "targets", "iso9283", "tool", "base"});
  io.about("Begin").format("date-time")("started", x.started);
  io.about("End, or when it was interrupted; null while it runs").nullable("ended", x.ended);
  io("state", x.state, OneOf{"running", "done", "aborted", "failed", "interrupted"});
  io.about("For aborted, failed and interrupted, and why a model was not activated; else empty")("reason",
                                                                                                 x.reason);
  io("robot_model", x.robot_model);
  io("robot_serial", x.robot_serial);
  io("tracker_model", x.tracker_model);
  io("tracker_serial", x.tracker_serial);
  io.about("Who started it; null of one from before that was kept").nullable("by", x.by);
  io.about("His words for it, or empty")("note", x.note);
  io.about("The model that it made").nullable("model_id", x.model_id);
  io.about("The campaign that measured the points, where they were identified again; else null")
      .nullable("points_of", x.points_of);
}

void layout(Io& io, InterruptedCampaign& x) {
  io.record("InterruptedCampaign");
  io.about("For campaign.resume and campaign.abort").format("uuid")("id", x.id);
  io.about("Those that can be resumed")("kind", x.kind, OneOf{"calibration", "targets", "tool", "base"});
  io.about("Begin").format("date-time")("started", x.started);
  io.about("When, as far as it is known").format("date-time")("interrupted", x.interrupted);
  io.about("Poses measured")("done", x.done, kCount);
  io.about("Poses of the plan over all phases")("total", x.total, kCount);
  io.about("Why it was interrupted, or did not resume")("reason", x.reason);
}

void layout(Io& io, SeenPoint& x) {
  io.about("Its number in the campaign, from 1, as in documents, files and messages")("pose", x.pose, kCount);
  io("purpose", x.purpose,
     OneOf{"identify", "validate", "remeasure", "reference", "target", "cycle", "nest", "face1", "check",
           "frame"});
  io.about(
      "The reflector, or the point of a tool or base; of a pose that was skipped all that were looked for, as "
      "\"1, 2\"")("smr", x.smr);
  io.about("Null of a point that was touched or skipped").nullable("p_mm", x.p_mm);
  io.nullable("std_mm", x.std_mm);
  io.about("Of a 6-D target alone: KUKA's A, B, C of its axes in the tracker's frame")
      .optional("abc_deg", x.abc_deg);
  io.about("Of a 6-D target alone: standard deviation of a rotation about each axis")
      .optional("std_abc_deg", x.std_abc_deg);
}
void layout(Io& io, Point& x) {
  io.record("Point");
  layout(io, static_cast<SeenPoint&>(x));
  io.about("The wanted pose; empty of a point that was touched")("q_target_deg", x.q_target_deg);
  io.about("What was sent: differs when compensated; empty of a point that was touched")("q_commanded_deg",
                                                                                         x.q_commanded_deg);
  io.about("What the controller reported")("q_actual_deg", x.q_actual_deg);
  io.about("When").format("date-time")("time", x.time);
}

void layout(Io& io, TargetsDocument::Target& x) {
  io.about("From 1, in the order in which they were given")("target", x.target, kCount);
  io("reached", x.reached);
  io.about("Why it was not reached, else empty")("reason", x.reason);
  io.about("To command, deg (mm for a prismatic joint); empty where it was not measured")("joints_deg",
                                                                                          x.joints_deg);
  io.about("Measured in each round")("errors_mm", x.errors_mm);
  io.about("By how much the mean of all rounds misses the target before the last correction")("averaged_mm",
                                                                                              x.averaged_mm);
}
void layout(Io& io, TargetsDocument& x) {
  io.record("TargetsDocument");
  io("tolerance_mm", x.tolerance_mm);
  io.about("At most, of each target")("rounds", x.rounds, kCount);
  io.about("Of the tracker in each round")("readings", x.readings, kCount);
  io.about("How many targets")("reached", x.reached, kCount);
  io("targets", x.targets);
}

void layout(Io& io, Iso9283Document::Cube& x) {
  record::layout_xyz(io, x.center_mm, record::kAny);
  io("edge", x.edge_mm);
}
void layout(Io& io, Iso9283Document::Commanded& x) {
  io("point", x.point);
  io.about("In which the reflector comes to it, +x to -z of the base; left out: from the position before")
      .optional("direction", x.direction);
  record::layout_xyz(io, x.p_mm, record::kAny);
}
void layout(Io& io, Iso9283Document& x) {
  io.record("Iso9283Document", "What `truepose iso9283 --json` prints, and how it was measured. mm and rad");
  layout(io, x.test);
  io.about("By the model that was active")("compensated", x.compensated);
  io("cube", x.cube);
  io.about("Positions of the reflector in the robot base, in the order of a cycle")("commanded", x.commanded);
}

void layout(Io& io, CampaignStart::Result& x) {
  io.about("The campaign").format("uuid")("id", x.id);
  io.about("Poses of the plan over all phases")("total", x.total, kCount);
}
void layout(Io& io, CampaignStart& x) {
  io.about("What to measure for")
      .defaulted("kind", Unless{"calibration", x.kind},
                 OneOf{"calibration", "targets", "iso9283", "tool", "base"});
  io.about(
        "Targets: nominal joints, deg (mm for a prismatic joint); the real arm shall stand where the "
        "nominal one would")
      .optional("joints", x.joints, Size{1, kMostTargets});
  io.about("Targets: flange in the robot base, x,y,z in mm, KUKA a,b,c in deg")
      .optional("poses", x.poses, Size{1, kMostTargets});
  io.about("Corrections of a target at most").defaulted("rounds", x.rounds, Whole{1, 20});
  io.about("A target is reached where the mean of its readings is so near")
      .defaulted("tolerance_mm", x.tolerance_mm, Range{0, 10});
  io.about(
        "Of the tracker: in each round at a target (default 3), or of each point of a base (default 3). "
        "With touch: touches of each point (default 1), each with an orientation of its own")
      .optional("readings", x.readings, Whole{1, 100});
  io.about("Of an ISO 9283 test; default as configured").optional("cycles", x.cycles, Whole{2, 1000});
  io.about(
        "Of an ISO 9283 test: come to P1, P2 and P4 along the three axes of the base too; default as "
        "configured")
      .optional("variation", x.variation);
  io.about(
        "ISO 9283 with the joints that the active model asks for; false: with those of the nominal arm, "
        "which needs no model")
      .defaulted("compensate", Unless{true, x.compensate});
  io.about("Poses to identify from; default as configured")
      .optional("identify_poses", x.identify_poses, Whole{5, 1000});
  io.about("Poses to validate on, or targets (1 to 100); default as configured")
      .optional("validate_poses", x.validate_poses, Whole{0, 1000});
  io.about("Of the planner; default as configured").optional("seed", x.seed, kLargeCount);
  io.about("Reach the validation poses with compensated joints and measure again; default as configured")
      .optional("remeasure", x.remeasure);
  io.about("Activate the model if its validation beats the nominal arm")
      .defaulted("activate", Unless{true, x.activate});
  io.about("Of the tool in TOOL_DATA, or of the base in BASE_DATA; campaigns of these kinds need it")
      .optional("number", x.number, Whole{1, 1000});
  io.about(
        "Where a reflector sits, or what is touched: origin, x (ahead on +X) and xy (in the XY plane on "
        "the side of +Y). Three or more of any names with known. Of a tool: at most 6, and origin, the "
        "TCP, may stand alone (default)")
      .optional("points", x.points, Size{1, 50});
  io.about(
        "Roughly where each of the points is, x,y,z in mm. Of a tool: in the flange frame. Of a base, "
        "which needs it or touch: in the robot base. Default of a tool: the TCP measured before, else "
        "stream.tcp of the cell file, else its reflector")
      .optional("at", x.at, Size{1, 50});
  io.about(
        "Number of the tool that touches the points of a base with its TCP, in place of a reflector. It "
        "has to be in use (tool.activate), or of the cell file, and of use under the active model")
      .optional("touch", x.touch, Whole{1, 1000});
  io.about("Coordinates of each of the points in the frame, x,y,z in mm")
      .optional("nominal", x.nominal, Size{1, 50});
  io.about(
        "Direction of the opening of the tool's reflectors in the flange frame, one row; default: as "
        "the cell's")
      .optional("facing", x.facing, Size{1, 1});
  io.about(
        "Of the tool where the TCP alone is measured, KUKA a,b,c in deg, one row; default: a 6-D "
        "target's, else the flange's")
      .optional("orientation", x.orientation, Size{1, 1});
  io.about("Reflectors sit at all of the tool's points at once")
      .defaulted("together", Unless{false, x.together});
  io.about("In which each point of the tool is measured; fewer than 4 for a 6-D target alone")
      .defaulted("poses_per_point", x.poses_per_point, Whole{1, 100});
  io.about(
        "What for, in the operator's words: shown with the campaign and in its report; at most 500 "
        "characters")
      .optional("note", x.note, Size{0, 500});
}
void check(const Io& io, const CampaignStart& x) {
  CampaignStart empty;
  const std::set<std::string_view>& of_kind = params_of_kinds().at(x.kind);
  for (const std::string& key : record::keys_of([&empty](Io& keys) { layout(keys, empty); }))
    if (key != "kind" && key != "note" && !of_kind.contains(key) && io.has(key, false))
      io.fail_at(key, "unknown parameter");
  if (x.kind == "tool" || x.kind == "base") io.require("number");
  if (x.kind == "base") io.require("points");

  if (!x.joints.empty() && !x.poses.empty()) io.fail_at("joints", "give joints or poses, not both");
  if (x.kind == "targets" && x.validate_poses)
    if (const int poses = *x.validate_poses; poses < 1 || poses > kMostTargets)
      io.fail_at("validate_poses", "expected a whole number 1.." + std::to_string(kMostTargets) + ", found " +
                                       std::to_string(poses));
  if (std::set<std::string>(x.points.begin(), x.points.end()).size() != x.points.size())
    io.fail_at("points", "expected distinct names");
  if (!x.at.empty() && x.touch)
    io.fail_at("at", "the tracker looks for no points that touch asks for: leave out one of both");
  const std::size_t points = std::max<std::size_t>(x.points.size(), 1);  // of a tool its origin, by default
  if (!x.at.empty() && x.at.size() != points) io.fail_at("at", "expected a row for each of the points");
  if (!x.nominal.empty() && x.nominal.size() != points)
    io.fail_at("nominal", "expected a row for each of the points");
  if (!x.facing.empty() && x.facing.front().norm() < 1e-6) io.fail_at("facing", "a direction of no length");
}
const Method& CampaignStart::method() {
  static const Method kMethod{
      .name = "campaign.start",
      .role = Role::Operator,
      .summary =
          "Starts measuring: a calibration, targets with the tracker in the loop, an ISO 9283 test, "
          "a tool or a work frame",
      .description =
          "Answers once it runs; follow the topics campaign and measurement, the result is in "
          "campaign.get. Connects first where needed. Parameters of another kind are refused. Of kind "
          "calibration: identify_poses, validate_poses, seed, remeasure, activate. Of kind targets, which "
          "needs an active model: joints or poses, or validate_poses of a plan; rounds, tolerance_mm, "
          "readings, seed. Of kind iso9283: cycles, variation, compensate, seed. Of kind tool, which needs "
          "an active model: number, points, at, nominal, facing, orientation, together, poses_per_point, "
          "seed. A tool campaign with several points pauses before each but the first: the reflector is "
          "moved by hand. The reason of state paused names the next place; campaign.resume measures it. Of "
          "kind base, which needs an active model: number, points, at, nominal, readings; the arm stands "
          "still, and it pauses before each point. With touch in place of at, the TCP of that tool touches "
          "the points and the tracker is not used. It pauses before each touch; the arm is jogged there, "
          "in any operating mode, and campaign.resume takes the touch. It pauses again, with the reason, "
          "where the arm still moves, has not moved since the last touch, or its controller does not "
          "answer.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::WrongState, ErrorCode::Device,
                 ErrorCode::Busy, ErrorCode::Store},
  };
  return kMethod;
}

const Method& CampaignPause::method() {
  static const Method kMethod{
      .name = "campaign.pause",
      .role = Role::Operator,
      .summary = "Stops after the point under way",
      .errors = {ErrorCode::Forbidden, ErrorCode::WrongState},
      .is_always_carried_out = true,
  };
  return kMethod;
}

void layout(Io& io, CampaignResume& x) {
  io.about("Campaign that was interrupted").format("uuid").optional("id", x.id, kIdSize);
}
const Method& CampaignResume::method() {
  static const Method kMethod{
      .name = "campaign.resume",
      .role = Role::Operator,
      .summary = "Resumes a paused or an interrupted campaign",
      .description =
          "An interrupted campaign checks the arm, warms it up and measures nests and two earlier poses "
          "again. Where the tracker has moved, later readings are transformed to its first station. The "
          "campaign then continues at the first pose that was not measured. Where a check fails it stays "
          "interrupted, and its reason has the cause. Without id: the campaign that is paused. Campaigns "
          "of kind iso9283, drift and base are never interrupted: they fail, and are started again.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::NotFound, ErrorCode::WrongState,
                 ErrorCode::Device, ErrorCode::Store},
  };
  return kMethod;
}

void layout(Io& io, CampaignAbort& x) {
  io.about("Campaign that was interrupted; default: the one that runs")
      .format("uuid")
      .optional("id", x.id, kIdSize);
}
const Method& CampaignAbort::method() {
  static const Method kMethod{
      .name = "campaign.abort",
      .role = Role::Operator,
      .summary = "Brakes the arm and ends the campaign; what was measured is kept",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotFound, ErrorCode::WrongState, ErrorCode::Store},
      .is_always_carried_out = true,
      .is_long = true,
  };
  return kMethod;
}

void layout(Io& io, CampaignIdentify::Result& x) {
  io.about("The campaign that it is kept as").format("uuid")("id", x.id);
  io.about("The campaign that measured").format("uuid")("points_of", x.points_of);
  io.about("The model").format("uuid")("model_id", x.model_id);
  io("activated", x.activated);
  io.about("Why it was not activated though that was asked for; else empty")("reason", x.reason);
  io.about("That it was identified from")("identify_poses", x.identify_poses, kCount);
  io.about("That validated it")("validate_poses", x.validate_poses, kCount);
  io.about("Mean error of the nominal arm there; null: not validated")
      .nullable("validation_before_mm", x.validation_before_mm);
  io.about("Mean error of the model there").nullable("validation_after_mm", x.validation_after_mm);
  io.about("As in the calibration document")("verdict", x.verdict);
}
void layout(Io& io, CampaignIdentify& x) {
  io.about("The campaign").format("uuid")("id", x.id, kIdSize);
  io.about("Errors of the joints, as cross-validation keeps them")
      .optional("non_geometric", x.non_geometric, kNoneOrAuto);
  io.about("Multiples of a joint's angle to look for")
      .optional("harmonics", x.harmonics, Size{0, 32}, Whole{1, 10000});
  io.about("A Gaussian process over what the model leaves; auto: where cross-validation shows that it helps")
      .optional("residual", x.residual, kFieldNames);
  io.optional("loss", x.loss, kLossNames);
  io.about("Whether deviations from the data sheet are taken as small until measured")
      .optional("prior", x.prior, kPriorNames);
  io.about("Put the points right by how the tracker's nests moved")
      .optional("correct_by_nests", x.correct_by_nests);
  io.about(
        "Share of the poses that identify; the others validate. Default: as they were measured, and 0.7 "
        "where none was measured to validate and that leaves enough")
      .optional("split", x.split, Range{0.1, 1});
  io.about("Of the split").optional("seed", x.seed, kLargeCount);
  io.about("The model, if nothing contradicts it").defaulted("activate", x.activate);
}
const Method& CampaignIdentify::method() {
  static const Method kMethod{
      .name = "campaign.identify",
      .role = Role::Operator,
      .summary = "Identifies the stored points of a campaign again, also of an aborted or failed one",
      .description =
          "The result is a campaign of its own, with a document and a model. It names the campaign that "
          "measured the points. Options that are not given are the cell file's. Refused where the points "
          "are too few.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::WrongState, ErrorCode::NotFound,
                 ErrorCode::Busy, ErrorCode::Store},
  };
  return kMethod;
}

void layout(Io& io, CampaignExport::Result& x) {
  io.about("The campaign").format("uuid")("id", x.id);
  io.about("First byte of the part")("offset", x.offset);
  io.about("Text (CSV); empty at the end")("data", x.data);
}
void layout(Io& io, CampaignExport& x) {
  io.about("Default: the newest").format("uuid").optional("id", x.id, kIdSize);
  io.about("First byte of the part").defaulted("offset", x.offset);
}
const Method& CampaignExport::method() {
  static const Method kMethod{
      .name = "campaign.export",
      .summary = "A part of the measurement file of a campaign; ask on behind it until none comes",
      .description =
          "The points to identify and to validate from, as they were measured, in the format of truepose "
          "calibrate --data.",
      .errors = {ErrorCode::NotFound, ErrorCode::Store},
  };
  return kMethod;
}

void layout(Io& io, CampaignList::Result& x) {
  io("campaigns", x.campaigns);
  io.about("Of all")("total", x.total, kCount);
}
void layout(Io& io, CampaignList& x) {
  io.about("At most so many").defaulted("limit", x.limit, Whole{1, 100});
  io.about("Skip so many, newest first").defaulted("offset", x.offset);
}
const Method& CampaignList::method() {
  static const Method kMethod{
      .name = "campaign.list",
      .summary = "Campaigns, newest first",
  };
  return kMethod;
}

void layout(Io& io, CampaignGet::Result& x) {
  io("campaign", x.campaign);
  io.nullable("progress", x.progress);
  io("skipped", x.skipped);
  io.about("After which it resumed")("interruptions", x.interruptions);
  io.about("The verdict of a drift check that is done").refers("DriftDocument").nullable("drift", x.drift);
  io.about("What the tracker loop found, once it is done; null where points are asked for")
      .refers("TargetsDocument")
      .nullable("targets", x.targets);
  io.about("The characteristics of an ISO 9283 test that is done; null where points are asked for")
      .refers("Iso9283Document")
      .nullable("iso9283", x.iso9283);
  io.about("The tool or the base that was measured, once that is done; null where points are asked for")
      .refers("FrameDocument")
      .nullable("frame", x.frame);
  io.about("Points measured")("points_total", x.points_total);
  io("points", x.points);
}
void layout(Io& io, CampaignGet& x) {
  io.about("Default: the newest").format("uuid").optional("id", x.id, kIdSize);
  io.defaulted("points_offset", x.points_offset);
  io.about("Points to list").defaulted("points_limit", x.points_limit, Whole{0, 100});
}
const Method& CampaignGet::method() {
  static const Method kMethod{
      .name = "campaign.get",
      .summary = "One campaign with its points",
      .description = "progress is null unless it runs.",
      .errors = {ErrorCode::NotFound, ErrorCode::Store},
  };
  return kMethod;
}

void layout(Io& io, CampaignPoints::Result& x) {
  io.about("The campaign").format("uuid")("id", x.id);
  io("format", x.format, OneOf{"json", "csv"});
  io.about("As asked for")("offset", x.offset);
  io.about("Offset of the next part; null: there is none").nullable("next", x.next);
  io.about("Points of the campaign, or rows of the file")("total", x.total, kCount);
  io.about("Of json").optional("points", x.points);
  io.about("Of csv: rows, the first part with the header").optional("csv", x.csv);
}
void layout(Io& io, CampaignPoints& x) {
  io.about("The campaign; left out: the last one").format("uuid").optional("id", x.id, kIdSize);
  io.about("Left out: json").optional("format", x.format, OneOf{"json", "csv"});
  io.about("Points to leave out at the beginning").optional("offset", x.offset, kLargeCount);
  io.about("At most so many").optional("limit", x.limit, Whole{1, 1000});
}
const Method& CampaignPoints::method() {
  static const Method kMethod{
      .name = "campaign.points",
      .summary = "A campaign's points, as many as fit into a line",
      .description =
          "json: every point as it is stored. csv: the measurement file that `truepose calibrate` reads, "
          "of the points that identify and validate; the parts one after the other are the file. Continue "
          "with `next` until it is null.",
      .errors = {ErrorCode::Unauthenticated, ErrorCode::InvalidParams, ErrorCode::NotFound, ErrorCode::Store},
      .is_long = true,
  };
  return kMethod;
}

std::vector<Described> campaign_methods() {
  return {described<CampaignStart>(), described<CampaignPause>(),    described<CampaignResume>(),
          described<CampaignAbort>(), described<CampaignIdentify>(), described<CampaignExport>(),
          described<CampaignList>(),  described<CampaignGet>(),      described<CampaignPoints>()};
}

}  // namespace truepose::rpc
