#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/json/object.hpp>
#include <cstdio>
#include <iostream>
#include <memory>
#include <span>

#include "config/number_text.hpp"
#include "config/test_cycle_file.hpp"
#include "config/text_file.hpp"
#include "core/math/angles.hpp"
#include "core/quality/commanded_poses.hpp"
#include "core/quality/iso9283.hpp"
#include "core/quality/test_cube.hpp"
#include "daemon/report/report.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/iso9283_document.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/offline/table_options.hpp"
#include "tools/truepose/progress_line.hpp"
#include "tools/truepose/text.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;

struct Iso9283Command {
  std::string data_file, targets_file, model_file, report_file, plane = "C1-C2-C7-C8";
  TableOptions table;
  std::vector<double> cube;
  bool fit_frame = false, as_json = false;
};

/// The commanded positions of a test, as a file of targets.
int print_targets(const Iso9283Command& command) {
  if (command.cube[3] <= 0)
    throw bad_usage("--cube: the edge is " + config::format_number(command.cube[3]) +
                    " mm, it must be above 0");
  TestCube cube{.edge_mm = command.cube[3]};
  cube.X_BC.translation() = Eigen::Vector3d(command.cube[0], command.cube[1], command.cube[2]);
  std::puts("point,x,y,z");
  int number = 0;
  for (const Eigen::Vector3d& p : test_positions(cube, value_of(kPlaneNames, command.plane))) {
    std::printf("P%d,%s,%s,%s\n", ++number, config::format_number(p.x()).c_str(),
                config::format_number(p.y()).c_str(), config::format_number(p.z()).c_str());
  }
  return kDone;
}

/// What was evaluated, so that the report carries it.
std::vector<report::EmbeddedFile> embedded_files(const Iso9283Command& command) {
  std::vector<report::EmbeddedFile> files;
  const auto add = [&files](const char* name, const std::string& file, const char* type, const char* about) {
    if (!file.empty()) files.push_back({name, type, config::read_bytes(file), about});
  };
  add("cycles.csv", command.data_file, "text/csv", "the cycles, as truepose iso9283 --data reads them");
  add("targets.csv", command.targets_file, "text/csv", "the commanded poses (--targets)");
  add("model.yaml", command.model_file, "application/yaml", "the model that gave the base pose (--model)");
  return files;
}

std::string frame_text(record::Iso9283Frame frame) {
  switch (frame) {
    case record::Iso9283Frame::AsGiven:
      return "Measured poses were taken as given, in the frame of the commanded ones.\n";
    case record::Iso9283Frame::Model:
      return "Measured poses were brought into the robot's base by the model's base pose.\n";
    case record::Iso9283Frame::Fitted:
      return "The measuring frame was fitted to the commanded positions: AP is relative to that fit, and the "
             "absolute one is greater.\n";
  }
  return {};
}

/// "P1", "P1 +x", "P1 +x 60 min"
std::string label(const TestPoint& point, const std::string& direction, const std::string& series) {
  return point.name + (direction.empty() ? "" : " " + direction) + (series.empty() ? "" : " " + series);
}

std::string angles_text(const Eigen::Vector3d& abc_rad) {
  const Eigen::Vector3d deg = abc_rad * kDegPerRad;
  return fmt::format(" {:9.4f} {:9.4f} {:9.4f}", deg.x(), deg.y(), deg.z());
}

void add_angles(Cells& cells, const Eigen::Vector3d& abc_rad) {
  for (const double angle_rad : abc_rad) cells.push_back(fmt::format("{:.4f}", angle_rad * kDegPerRad));
}

std::string characteristics_table(const Iso9283Result& result, std::span<const TestPoint> points) {
  const bool oriented = std::ranges::any_of(
      result.sets, [](const CycleSet& s) { return s.characteristics.repeatability.abc_rad.has_value(); });
  std::vector<Cells> rows{{"mm, deg", "cycles", "AP_p", "AP_x", "AP_y", "AP_z", "RP_l"}};
  if (oriented) rows[0].insert(rows[0].end(), {"AP_a", "AP_b", "AP_c", "RP_a", "RP_b", "RP_c"});
  int width = 14;
  double worst_ap = 0, worst_rp = 0;
  const auto mm = [](double length_mm) { return fmt::format("{:.4f}", length_mm); };
  for (const CycleSet& set : result.sets) {
    const auto& [ap, rp] = set.characteristics;
    rows.push_back({label(points[set.point], set.direction, set.series), std::to_string(set.cycles),
                    mm(ap.p_mm), mm(ap.xyz_mm.x()), mm(ap.xyz_mm.y()), mm(ap.xyz_mm.z()), mm(rp.l_mm)});
    width = std::max(width, static_cast<int>(rows.back()[0].size()) + 1);
    if (ap.abc_rad) add_angles(rows.back(), *ap.abc_rad);
    if (rp.abc_rad) add_angles(rows.back(), *rp.abc_rad);
    worst_ap = std::max(worst_ap, ap.p_mm);
    worst_rp = std::max(worst_rp, rp.l_mm);
  }
  rows.push_back({"worst", "", mm(worst_ap), "", "", "", mm(worst_rp)});
  std::vector<Column> columns(rows[0].size(), {9, 1});
  columns[0] = {-width};
  columns[1] = {7};
  return text_table(columns, rows);
}

/// Tables of AP and RP, and where they were measured of vAP and of the drift; mm and deg.
std::string iso9283_text(const Iso9283Result& result, std::span<const TestPoint> points,
                         record::Iso9283Frame frame) {
  std::string text = "ISO 9283:1998. " + frame_text(frame);
  if (const auto missing = record::poses_without_cycle(points); !missing.empty()) {
    text += fmt::format(
        "No cycle came to {}: these figures do not hold there, as the standard asks for {} cycles at every "
        "commanded pose, and they do not comply.\n",
        fmt::join(missing, ", "), kIso9283Cycles);
  } else if (result.fewest_cycles < kIso9283Cycles) {
    text +=
        fmt::format("The standard asks for {} cycles, and some poses have {}: these figures do not comply.\n",
                    kIso9283Cycles, result.fewest_cycles);
  }
  text += "\n" + characteristics_table(result, points);
  for (const PointVariation& v : result.variations) {
    text +=
        fmt::format("\n{}: vAP_p {:.4f} mm over {} directions{}\n", label(points[v.point], "", v.series),
                    v.variation.p_mm, v.directions.size(),
                    v.variation.abc_rad ? ", vAP_a, b, c" + angles_text(*v.variation.abc_rad) + " deg" : "");
  }
  for (const PointDrift& d : result.drifts) {
    text += fmt::format(
        "\n{}: dAP_p {:.4f}, dRP_l {:.4f} mm from {} to {}; the mean position moved by {:.4f} mm\n",
        label(points[d.point], d.direction, ""), d.drift.ap_p_mm, d.drift.rp_l_mm, d.series.front(),
        d.series.back(), d.drift.moved_mm);
  }
  return text;
}

/// The points that a cycle came to.
std::vector<TestPoint> measured_points(std::vector<TestPoint> points) {
  std::erase_if(points, [](const TestPoint& point) { return point.attained.empty(); });
  return points;
}

record::Iso9283Frame frame_of(const Iso9283Command& command) {
  if (!command.model_file.empty()) return record::Iso9283Frame::Model;
  return command.fit_frame ? record::Iso9283Frame::Fitted : record::Iso9283Frame::AsGiven;
}

IntoCommandedFrame bringing_into_base(const Iso9283Command& command, record::Iso9283Frame frame) {
  using Points = std::vector<TestPoint>;
  if (frame == record::Iso9283Frame::AsGiven) return [](Points points) { return points; };
  if (frame == record::Iso9283Frame::Model) {
    const Eigen::Isometry3d X_WB = load_model_to_use(command.model_file).cell.base.isometry();
    return [X_BW = X_WB.inverse()](Points points) { return in_base(std::move(points), X_BW); };
  }
  return [](Points points) -> std::expected<Points, std::string> {
    const auto X_BM = fitted_frame(measured_points(points));
    if (!X_BM) return std::unexpected("--fit-frame: " + X_BM.error());
    return in_base(std::move(points), *X_BM);
  };
}

int run_iso9283(const Iso9283Command& command) {
  if (!command.cube.empty()) return print_targets(command);
  if (command.data_file.empty()) throw bad_usage("--data, --cube: missing. Give one of them");
  const ProgressLine line{"evaluation"};
  const record::Iso9283Frame frame = frame_of(command);
  const IntoCommandedFrame into_base = bringing_into_base(command, frame);
  const config::TableReading reading = reading_of(command.table);
  const std::vector<TestPoint> measured =
      config::load_test_cycles(command.data_file, command.targets_file, &reading);
  if (const auto why = not_as_commanded(measured_points(measured), into_base))
    throw ConfigError(command.data_file + ": " + *why);
  const std::vector<TestPoint> points = *into_base(measured);
  const auto result = evaluate_iso9283(points);
  if (!result) throw ConfigError(command.data_file + ": " + result.error());
  const boost::json::object document = record::iso9283_document(*result, points, frame);
  if (!command.report_file.empty())
    config::write_text_file(command.report_file, report::render_iso9283_html(document, command.data_file,
                                                                             embedded_files(command)));
  if (command.as_json) {
    std::cout << control::json_text(document) << '\n';
  } else {
    std::fputs(iso9283_text(*result, points, frame).c_str(), stdout);
    note_written({command.report_file});
  }
  return kDone;
}

}  // namespace

Command iso9283_command() {
  const auto command = std::make_shared<Iso9283Command>();
  Iso9283Command& c = *command;
  return {
      .name = "iso9283",
      .help = "Pose accuracy and repeatability by ISO 9283:1998",
      .options =
          {Option(
               "--data", &c.data_file,
               "Cycles (CSV: point,cycle,x,y,z in mm; optional a,b,c in deg, smr, direction, and time, the same "
               "for all rows of a series; commanded poses in cx,cy,cz,ca,cb,cc or in --targets)",
               {.place = "DATA", .file = FileUse::Read}),
           Option("--targets", &c.targets_file,
                  "Commanded poses of the measured point (CSV: point,x,y,z; optional a,b,c, smr)",
                  {.needs = {"--data"}, .file = FileUse::Read}),
           Option(
               "--model", &c.model_file,
               "The data are in the tracker's frame: bring them into the robot's base by this model's base pose",
               {.needs = {"--data"}, .file = FileUse::Read}),
           Option("--fit-frame", &c.fit_frame,
                  "Or by a fit of the mean positions to the commanded ones, which makes AP relative",
                  {.needs = {"--data"}, .excludes = {"--model"}}),
           Option(
               "--cube", &c.cube,
               "Without data: print the five positions of a test in this cube as targets, its edges parallel to "
               "the base",
               {.type = "X,Y,Z,EDGE", .count = 4, .excludes = {"--data"}}),
           Option("--plane", &c.plane, "Diagonal plane of the cube",
                  {.check = available(names_of(kPlaneNames)), .needs = {"--cube"}}),
           columns_option(c.table), units_option(c.table),
           Option("--report", &c.report_file, "Write a report here (HTML, one file)",
                  {.needs = {"--data"}, .file = FileUse::Written}),
           Option("--json", &c.as_json, "One JSON document", {.needs = {"--data"}})},
      .run = [command] { return run_iso9283(*command); },
      .examples = {{"iso9283 --cube 1700,0,1100,800", "Print the five positions of a test"},
                   {"iso9283 cycles.csv --report iso9283.html", "Evaluate what was measured"}}};
}

}  // namespace truepose::tools
