#include <fmt/format.h>

#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>

#include "config/cell_setup.hpp"
#include "config/measurement_file.hpp"
#include "config/text_file.hpp"
#include "core/plan/optimal_design.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/progress_line.hpp"
#include "tools/truepose/text.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::record {

void layout(Io& io, PredictedError& x) {
  io("rms_mm", x.rms_mm);
  io("max_mm", x.max_mm);
}
void layout(Io& io, DesignSize& x) {
  io("poses", x.poses);
  layout(io, x.error);
}

}  // namespace truepose::record

namespace truepose::tools {
namespace {

struct PlanCommand {
  std::string robot_file, cell_file, out_file;
  int poses = 50;
  std::optional<int> candidates;
  std::optional<std::uint64_t> seed;
  std::string criterion;
  bool as_json = false;
};

config::CellConfig cell_of(const PlanCommand& command) {
  config::CellConfig cell = config::load_cell(command.cell_file);
  if (!command.robot_file.empty()) config::use_robot(cell, command.robot_file);
  if (command.candidates) cell.campaign.candidates = *command.candidates;
  if (command.seed) cell.campaign.seed = *command.seed;
  if (command.criterion == "d") cell.campaign.criterion = DesignCriterion::D;
  if (command.criterion == "a") cell.campaign.criterion = DesignCriterion::A;
  if (command.criterion == "i") cell.campaign.criterion = DesignCriterion::I;
  return cell;
}

struct InDegMm {
  const RobotModel& robot;
  std::vector<double> form_of(const JointVector& q) const { return in_deg_mm(q, robot); }
};

record::ByName<int> rejected(const Candidates& candidates) {
  record::ByName<int> counts;
  for (std::size_t i = 0; i < kPoseFaults; ++i)
    counts.emplace_back(fault_text(static_cast<PoseFault>(i)), candidates.faults[i]);
  return counts;
}

/// What is printed as JSON.
struct PlanDocument {
  const RobotModel& robot;
  MeasurementPlan plan;
  PredictedError bound;
};
void layout(record::Io& io, PlanDocument& x) {
  MeasurementPlan& plan = x.plan;
  io("poses", plan.poses, InDegMm{x.robot});
  io("predicted", plan.predicted);
  io("random", plan.random);
  io("bound", x.bound);
  io("sizes", plan.sizes);
  io.nullable("enough", plan.enough);
  io("travel_s", plan.travel_s);
  io("random_travel_s", plan.random_travel_s);
  io.nullable("reference", plan.reference, InDegMm{x.robot});
  io("candidates", plan.candidates.poses.size());
  io("tried", plan.candidates.tried);
  io("rejected", rejected(plan.candidates));
}

void print_plan(const config::CellConfig& cell, const MeasurementPlan& plan, const PredictedError& bound) {
  std::printf("%zu poses of %zu candidates (%d joint positions tried)\n\n", plan.poses.size(),
              plan.candidates.poses.size(), plan.candidates.tried);
  for (std::size_t i = 0; i < kPoseFaults; ++i) {
    if (plan.candidates.faults[i] == 0) continue;
    std::printf("%9d %s\n", plan.candidates.faults[i],
                std::string(fault_text(static_cast<PoseFault>(i))).c_str());
  }
  std::vector<Cells> rows;
  const auto add = [&rows](const std::string& name, const PredictedError& error) {
    rows.push_back({name, fmt::format("{:.4f}", error.rms_mm), fmt::format("{:.4f}", error.max_mm)});
  };
  add("these poses", plan.predicted);
  add("random ones, as many", plan.random);
  add("no choice goes below", bound);
  for (const DesignSize& size : plan.sizes) add(std::to_string(size.poses) + " poses", size.error);
  std::printf("\npredicted error over the task, mm   RMS     worst\n%s",
              text_table({{-32, 2}, {6, 1}, {6, 2}}, rows).c_str());
  if (plan.enough) {
    std::printf("\n%d poses are enough: twice as many would make a compensated arm less than 5 %% better.\n",
                *plan.enough);
  }
  std::printf("\nmotions %.0f s, in a random order %.0f s\n", plan.travel_s, plan.random_travel_s);
  if (cell.robot.body.empty()) {
    std::puts(
        "\nThe robot file says nothing of the arm's body: only its joint centres are kept clear of floor, "
        "tracker and obstacles. Watch the first run.");
  }
}

std::expected<MeasurementPlan, std::string> planned(const config::CellConfig& cell, int poses) {
  ProgressLine line{"plan"};
  PlanOptions options = config::plan_options(cell, poses);
  options.progress = [&](double share, std::string_view doing) { line.show(share, doing); };
  return plan_measurements(config::rough_cell(cell), config::scene_of(cell), options);
}

int run_plan(const PlanCommand& command) {
  const config::CellConfig cell = cell_of(command);
  const auto plan = planned(cell, command.poses);
  if (!plan) throw config::ConfigError(command.cell_file + ": " + plan.error());
  if (!command.out_file.empty()) {
    std::ostringstream out;
    config::write_joints(out, plan->poses, cell.robot.model);
    config::write_text_file(command.out_file, out.str());
  }
  const PredictedError bound = error_bound(*plan->problem, command.poses);
  if (command.as_json) {
    std::cout << control::json_text(record::to_json(PlanDocument{cell.robot.model, *plan, bound})) << '\n';
  } else {
    print_plan(cell, *plan, bound);
    note_written({command.out_file});
  }
  return kDone;
}

}  // namespace

Command plan_command() {
  const auto command = std::make_shared<PlanCommand>();
  PlanCommand& c = *command;
  return {.name = "plan",
          .help = "Chooses and orders poses to measure: reachable, clear, visible and worth it",
          .options = {Option("--robot", &c.robot_file, "Robot file (YAML) in place of the cell's",
                             {.file = FileUse::Read}),
                      Option("--cell", &c.cell_file, "Cell file (YAML)",
                             {.required = true, .place = "CELL", .file = FileUse::Read}),
                      Option("--poses", &c.poses, "How many",
                             {.shows_default = true, .check = in_range(5, 1000)}),
                      Option("--candidates", &c.candidates, "Random poses to choose from; else the cell's",
                             {.check = in_range(10, 100'000)}),
                      Option("--seed", &c.seed, "Of the candidates; else the cell's"),
                      Option("--criterion", &c.criterion,
                             "i: best predictions over the task; d, a: best parameters; else the cell's",
                             {.check = available({"i", "d", "a"})}),
                      Option("--out", &c.out_file, "Write the joint positions here (CSV)",
                             {.file = FileUse::Written}),
                      Option("--json", &c.as_json, "One JSON document; joints in deg and mm")},
          .run = [command] { return run_plan(*command); },
          .examples = {{"plan cell.yaml --poses 40 -o poses.csv",
                        "Forty poses that determine the model best, in a short order"}}};
}

}  // namespace truepose::tools
