#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "config/measurement_file.hpp"
#include "config/number_text.hpp"
#include "config/positioner_file.hpp"
#include "config/target_file.hpp"
#include "config/text_file.hpp"
#include "core/arm/joint_units.hpp"
#include "core/compensate/nominal_inverse.hpp"
#include "core/fit/uncertainty.hpp"
#include "core/formatted.hpp"
#include "core/frames/positioner.hpp"
#include "core/frames/tool_frame.hpp"
#include "daemon/report/report.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/offline/compensate.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError, config::TargetForm, config::TargetReader, config::TargetRow,
    config::UnfinishedFile;

// ---- Targets as they are read ----

/// One row of a file. What the form does not tell is not set.
struct Target {
  JointVector q;        ///< Joints
  Eigen::Isometry3d X;  ///< Poses; Positions: its translation alone. mm, robot base frame
  std::optional<int> status, turn;
  JointVector e;  ///< of the positioner that carries it
};

bool turns(const Joint& joint) { return joint.type == JointType::Revolute; }

/// Whether what is read in degrees or millimetres was meant in radians or metres.
class UnitWatch {
 public:
  UnitWatch(const RobotModel& robot, TargetForm form, const CompensateOptions& options, std::string file)
      : robot_{robot},
        of_joints_{form == TargetForm::Joints && !options.reading.units},
        of_base_{form != TargetForm::Joints && options.base.empty() && options.positioner.empty()},
        file_{std::move(file)} {}

  /// A row as it was read. Throws CommandError where it is in metres.
  void see(const TargetRow& row, std::size_t number) {
    constexpr double kNear_mm = 10;  // of the arm's own base, within its foot
    const auto& v = row.numbers;
    if (of_base_ && std::hypot(v[0], v[1], v[2]) < kNear_mm)
      throw CommandError{kBadInput,
                         file_ + ": row " + std::to_string(number) +
                             ": the position is within 10 mm of the middle of the arm's foot: x, y, z are "
                             "read in mm, and these look like metres; if they are: --units deg,m"};
    for (std::size_t i = 0; of_joints_ && i < v.size(); ++i)
      if (turns(robot_.joints[i])) largest_ = std::max(largest_, std::abs(v[i]));
  }
  /// After the last row, or one that cannot be reached. Throws CommandError where all were in radians.
  void end() const {
    constexpr double kTurn_rad = 6.2832, kSmall = 0.35;  // 20 deg
    if (largest_ <= kSmall || largest_ > kTurn_rad) return;
    throw CommandError{
        kBadInput, file_ + ": no joint is beyond " + formatted("%.3g", largest_) +
                       " in any row: joints are read in deg, and these look like radians; say which it is "
                       "by --units rad,mm or --units deg,mm"};
  }

 private:
  const RobotModel& robot_;
  bool of_joints_, of_base_;
  std::string file_;
  double largest_ = 0;
};

Target target_of(TargetRow row, TargetForm form, const RobotModel& robot) {
  Target target{.q = {},
                .X = Eigen::Isometry3d::Identity(),
                .status = row.status,
                .turn = row.turn,
                .e = std::move(row.e)};
  std::vector<double>& v = row.numbers;
  if (form == TargetForm::Joints) {
    target.q = joints_from(v, robot);
  } else {
    v.resize(6);
    target.X = pose_from_kuka({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
  }
  return target;
}

// ---- What became of them, as it is written ----

/// What became of a target.
struct ReachedTarget {
  JointVector q_nominal;
  CompensatedTarget compensated;
  std::optional<double> sigma_mm;  ///< of the position where the arm will stand, with what is given up of it
};

/// All targets, by column; deg and mm.
struct ReachedColumns {
  bool has_orientation = false, has_sigma = false;
  std::vector<std::vector<double>> joints{};
  std::vector<double> residual_mm{}, residual_deg{}, sigma_mm{};
  std::vector<int> iterations{};
  std::vector<bool> damped{};
  std::vector<std::string> notes{};
};
void layout(record::Io& io, ReachedColumns& x) {
  io("joints", x.joints);
  io("residual_mm", x.residual_mm);
  io("iterations", x.iterations);
  io.where(x.has_orientation, "residual_deg", x.residual_deg);
  io.where(x.has_orientation, "damped", x.damped);
  io.where(x.has_sigma, "sigma_mm", x.sigma_mm);
  io.optional("notes", x.notes);
}

/// A row of the report, deg and mm.
report::CompensationRow report_row(const RobotModel& robot, const ReachedTarget& target) {
  return {.residual_mm = target.compensated.residual_mm,
          .residual_deg = target.compensated.residual_rad * kDegPerRad,
          .sigma_mm = target.sigma_mm,
          .damped = target.compensated.damped,
          .corrections = in_deg_mm(target.compensated.q - target.q_nominal, robot)};
}

// ---- The way from one to the other ----

constexpr std::string_view kStandard = "-";
constexpr const char* kNoSigma = ": has no covariance, so no sigma_mm is given; calibrate again to have it";
constexpr const char* kToolGiven =
    "--tool was given, not measured: sigma_mm does not hold what the TCP is off by on the flange, often more than "
    "half a millimetre; `truepose tool` measures it";

constexpr const char* kBaseGiven =
    "--base has no uncertainty: sigma_mm leaves out the base's own error, and its rotation, which grows with the "
    "distance from it; `truepose base` measures it";

/// What carries the workpiece that the targets stand in.
class Table {
 public:
  /// Throws ConfigError.
  Table(const std::filesystem::path& file, const config::ModelFile& arm)
      : Table(config::load_positioner(file, arm), file.string(), arm) {}

  const RobotModel& robot() const { return by_.cell.robot; }
  bool has_sigma() const { return by_.covariance.size() > 0; }
  /// The workpiece in the robot's base.
  Eigen::Isometry3d workpiece_at(const JointVector& e) const {
    return table_in_base(arm_, by_.cell, e) * workpiece_.X;
  }
  /// Variance (mm^2) of where a point of the workpiece is that is at p_B.
  double variance(const JointVector& e, const Eigen::Vector3d& p_B_mm) const {
    const Eigen::Vector3d p_F_mm = inverse_of(table_in_base(arm_, by_.cell, e)) * p_B_mm;
    const double repeatability_mm = by_.noise.repeatability_mm;
    return tcp_covariance(by_.cell, by_.covariance, e, p_F_mm, &workpiece_).trace() +
           3 * repeatability_mm * repeatability_mm;
  }

 private:
  Table(const config::PositionerFile& file, const std::string& name, const config::ModelFile& arm)
      : arm_{arm.cell}, by_{measuring_cell_of(file.table, name)} {
    auto workpiece = tool_frame(file.workpiece, by_);
    if (!workpiece) throw ConfigError(name + ": " + workpiece.error());
    workpiece_ = *std::move(workpiece);
    report_failed_verdict(file.table, name + ": table");
  }

  CalibratedCell arm_;
  MeasuringCell by_;
  MeasuredFrame workpiece_;
};

/// Standard deviation (length of the vector, mm) of where the arm will put the TCP, by the covariances of
/// model and tool, what the model leaves, and the arm's repeatability. Without a tool that of the first
/// reflector: of that point the measurements tell, while what they know of the arm alone is mixed with what
/// they know of base and tool.
///
/// On a positioner's table, or in a base that was measured, it is of where the TCP will be in the workpiece:
/// both were measured for themselves, and so err for themselves. (A base that this arm touched errs less
/// against it: the sigma is then rather too large.)
class PositionSigma {
 public:
  PositionSigma(const config::ModelFile& model, const std::optional<Tool>& tool, const Base& base,
                const Table* table)
      : model_(model), tool_(tool), base_(base), table_(table) {}

  bool is_known() const {
    return model_.covariance.size() > 0 && !model_.cell.reflectors.empty() &&
           (!table_ || table_->has_sigma());
  }
  /// @param e  joints of the table
  double at(const JointVector& q, const JointVector& e) const {
    const double of_arm_mm = std::hypot(model_.noise ? model_.noise->repeatability_mm : 0, model_.misfit_mm);
    const Eigen::Vector3d p_B_mm = forward_kinematics(model_.cell.robot, q) * p_F_mm();
    return std::sqrt(std::max(0.0, of_model(q).trace() + of_workpiece(p_B_mm, e)) +
                     3 * of_arm_mm * of_arm_mm);
  }

 private:
  Eigen::Vector3d p_F_mm() const {
    return tool_ ? Eigen::Vector3d(tool_->X_FT.translation()) : model_.cell.reflectors.front().p_FS_mm;
  }
  double of_workpiece(const Eigen::Vector3d& p_B_mm, const JointVector& e) const {
    if (table_) return table_->variance(e, p_B_mm);
    return base_.covariance ? variance_at(*base_.covariance, p_B_mm - base_.X.translation()) : 0;
  }
  Eigen::Matrix3d of_model(const JointVector& q) const {
    if (!tool_) return position_covariance(model_.cell, model_.covariance, q, 0);
    return tcp_covariance(model_.cell, model_.covariance, q, tool_->X_FT.translation(),
                          tool_->measured ? &*tool_->measured : nullptr);
  }

  const config::ModelFile& model_;
  const std::optional<Tool>& tool_;
  const Base& base_;
  const Table* table_;
};

std::optional<JointVector> near_of(const std::vector<double>& values, const RobotModel& nominal) {
  if (values.empty()) return std::nullopt;
  if (values.size() != nominal.joints.size())
    throw ConfigError("--near: " + std::to_string(values.size()) + " joint positions for an arm with " +
                      std::to_string(nominal.joints.size()) + " joints");
  return joints_from(values, nominal);
}

class Targets {
 public:
  Targets(const CompensateOptions& options, const RobotModel& nominal, const config::ModelFile& model,
          const Table* table, TargetForm form, bool by_status)
      : nominal_(nominal),
        table_(table),
        tool_(tool_of(options.tool, "--tool", nominal, model)),
        base_(base_of(options.base, "--base", model).value_or(Base{})),
        sigma_(model, tool_, base_, table),
        form_(form),
        by_status_(by_status),
        X_FT_(tool_.value_or(Tool{}).X_controller),
        exact_F_mm_(exact_point(model)),
        position_only_(options.position_only || form == TargetForm::Positions),
        inverse_(nominal, near_of(options.near, nominal)),
        compensation_(nominal, with_tool(model.cell.robot, tool_.value_or(Tool{}).X_FT, X_FT_),
                      options.bounds) {}

  bool is_position_only() const { return position_only_; }
  bool has_sigma() const { return sigma_.is_known(); }
  bool is_tool_measured() const { return !tool_ || tool_->measured; }
  bool knows_base_covariance() const { return base_.covariance.has_value(); }

  std::expected<ReachedTarget, std::string> reach(Target target) {
    target.X = (table_ ? table_->workpiece_at(target.e) : base_.X) * target.X;
    const auto q = nominal_joints(target);
    if (!q) return std::unexpected(q.error());
    const auto compensated = compensate(target, *q);
    if (!compensated) return std::unexpected(described(compensated.error(), nominal_));
    ReachedTarget reached{.q_nominal = *q, .compensated = *compensated, .sigma_mm = {}};
    if (sigma_.is_known())
      reached.sigma_mm = std::hypot(sigma_.at(compensated->q, target.e), compensated->residual_mm);
    return reached;
  }

 private:
  /// What stays exact where position and orientation cannot both: the TCP, or what the model was measured
  /// with.
  Eigen::Vector3d exact_point(const config::ModelFile& model) const {
    if (tool_ || model.cell.reflectors.empty()) return X_FT_.translation();
    return model.cell.reflectors.front().p_FS_mm;
  }
  Eigen::Vector3d p_F_mm() const { return X_FT_.translation(); }
  Eigen::Isometry3d flange(const Target& target) const { return target.X * X_FT_.inverse(); }

  NominalInverse::Result nominal_joints(const Target& target) {
    if (form_ == TargetForm::Joints) return target.q;
    if (form_ == TargetForm::Positions) return inverse_.at_position(target.X.translation(), p_F_mm());
    if (by_status_) return inverse_.at_pose(flange(target), target.status, target.turn);
    return inverse_.at_pose(flange(target));
  }

  TargetCompensation::Result compensate(const Target& target, const JointVector& q) const {
    if (position_only_) {
      const bool of_joints = form_ == TargetForm::Joints;
      const Eigen::Vector3d p_B_mm =
          of_joints ? Eigen::Vector3d(forward_kinematics(nominal_, q) * p_F_mm()) : target.X.translation();
      return compensation_.at_position(p_B_mm, q, p_F_mm());
    }
    if (form_ == TargetForm::Joints) return compensation_.at_joints(q, exact_F_mm_);
    return compensation_.at_pose(flange(target), q, exact_F_mm_);
  }

  const RobotModel& nominal_;
  const Table* table_;  ///< null: the targets stand in the base
  std::optional<Tool> tool_;
  Base base_;
  PositionSigma sigma_;
  TargetForm form_;
  bool by_status_;
  Eigen::Isometry3d X_FT_;
  Eigen::Vector3d exact_F_mm_;
  bool position_only_;
  NominalInverse inverse_;
  TargetCompensation compensation_;
};

/// The rows that give up more than was allowed.
struct GivenUp {
  double most;  ///< allowed
  std::size_t rows = 0, worst_row = 0;
  double worst = 0;

  void see(double value, std::size_t row) {
    if (value > most) ++rows;
    if (value <= worst) return;
    worst = value;
    worst_row = row;
  }
  /// @param unit  "mm of position"
  std::string text(std::size_t of_rows, const std::string& unit) const {
    return std::to_string(rows) + " of " + std::to_string(of_rows) + " rows give up more than " +
           formatted("%g", most) + ' ' + unit + " next to a singularity, row " + std::to_string(worst_row) +
           " the most (" + formatted("%.2f", worst) + ' ' + unit.substr(0, unit.find(' ')) + ")";
  }
};

/// Where the results go: rows at once, what must be whole at the end.
class Output {
 public:
  Output(const CompensateOptions& options, const RobotModel& nominal, const Targets& targets,
         const std::string& file)
      : options_(options),
        nominal_(nominal),
        document_{.has_orientation = !targets.is_position_only(), .has_sigma = targets.has_sigma()},
        is_tool_measured_(targets.is_tool_measured()),
        knows_base_covariance_(targets.knows_base_covariance()),
        report_{nominal.name, file, targets.is_position_only(), {}},
        turned_{.most = options.max_orientation_residual_deg},
        displaced_{.most = options.max_position_residual_mm} {
    if (!options.out_file.empty() && options.out_file != kStandard) out_.emplace(options.out_file);
    if (!options.report_file.empty()) report_file_.emplace(options.report_file);
    if (std::ostream* out = csv()) {
      std::string header;
      for (const std::string& name : config::joint_column_names("q", nominal)) header += name + ',';
      header += "residual_mm,";
      if (document_.has_orientation) header += "residual_deg,";
      if (document_.has_sigma) header += "sigma_mm,";
      write_line(*out, std::move(header));
      out->flush();
    }
  }

  /// @param flush  a reader may be waiting for this row before it sends the next
  void add(const ReachedTarget& target, std::size_t row, bool flush) {
    ++rows_;
    turned_.see(target.compensated.residual_rad * kDegPerRad, row);
    displaced_.see(target.compensated.residual_mm, row);
    if (std::ostream* out = csv()) {
      write_line(*out, row_of(target));
      if (flush) out->flush();
      if (!*out) throw ConfigError("the joint positions cannot be written");
    }
    if (options_.as_json) {
      document_.joints.push_back(in_deg_mm(target.compensated.q, nominal_));
      document_.residual_mm.push_back(target.compensated.residual_mm);
      document_.iterations.push_back(target.compensated.iterations);
      document_.residual_deg.push_back(target.compensated.residual_rad * kDegPerRad);
      document_.damped.push_back(target.compensated.damped);
      document_.sigma_mm.push_back(target.sigma_mm.value_or(0));
    }
    if (report_file_) report_.rows.push_back(report_row(nominal_, target));
  }

  /// @return whether every row keeps its orientation and position as well as was asked for
  bool finish() {
    if (report_file_) report_file_->stream() << report::render_compensation_html(report_);
    if (!document_.has_sigma) note(options_.arm.model.string() + kNoSigma);
    if (!is_tool_measured_) note(kToolGiven);
    if (document_.has_sigma && !options_.base.empty() && !knows_base_covariance_) note(kBaseGiven);
    if (turned_.rows > 0)
      print_to_stderr(
          "truepose: " + turned_.text(rows_, "deg of orientation") +
          ": what is far from the point that stays exact is off by that; move these targets away from there, "
          "or allow it by --max-orientation-residual");
    if (displaced_.rows > 0)
      print_to_stderr(
          "truepose: " + displaced_.text(rows_, "mm of position") +
          ": the orientation would be worse than without a correction; move these targets away from there, or "
          "allow it by --max-position-residual");
    if (options_.as_json) std::cout << control::json_text(record::to_json(document_)) << '\n';
    flush_standard_output();  // before a file takes its place
    for (auto* file : {&out_, &report_file_}) {
      if (*file) (*file)->close();
    }
    for (auto* file : {&out_, &report_file_}) {
      if (*file) (*file)->take_place();
    }
    if (!options_.as_json) note_written({options_.out_file, options_.report_file});
    return turned_.rows == 0 && displaced_.rows == 0;
  }

 private:
  std::string row_of(const ReachedTarget& target) const {
    std::string row;
    for (std::size_t i = 0; i < nominal_.joints.size(); ++i)
      row +=
          config::joint_field(target.compensated.q[static_cast<Eigen::Index>(i)], nominal_.joints[i]) + ',';
    const auto add = [&row](double number) { row += config::format_number(number) + ','; };
    add(target.compensated.residual_mm);
    if (document_.has_orientation) add(target.compensated.residual_rad * kDegPerRad);
    if (document_.has_sigma) add(target.sigma_mm.value());
    return row;
  }
  /// @param cells  a comma behind each
  static void write_line(std::ostream& out, std::string cells) {
    cells.back() = '\n';
    out << cells;
  }
  void note(std::string text) {
    if (options_.as_json) {
      document_.notes.push_back(std::move(text));
    } else {
      print_to_stderr("truepose: " + text);
    }
  }
  std::ostream* csv() {
    if (out_) return &out_->stream();
    return options_.as_json ? nullptr : &std::cout;
  }

  const CompensateOptions& options_;
  const RobotModel& nominal_;
  ReachedColumns document_;
  bool is_tool_measured_, knows_base_covariance_;
  std::optional<UnfinishedFile> out_, report_file_;
  report::CompensationReport report_;
  std::size_t rows_ = 0;
  GivenUp turned_, displaced_;
};

}  // namespace

int run_compensate_targets(const CompensateOptions& options, const RobotModel& nominal,
                           const config::ModelFile& model) {
  std::ios::sync_with_stdio(false);
  const bool of_joints = !options.joints_file.empty();
  const std::string& name = of_joints ? options.joints_file : options.poses_file;
  const bool is_standard = name == kStandard;
  const bool is_pipe = is_standard || !std::filesystem::is_regular_file(name);
  const std::string file = is_standard ? "standard input" : name;
  std::ifstream opened;
  if (!is_standard) opened = config::open_to_read(name);
  std::istream& in = is_standard ? std::cin : opened;

  std::optional<Table> positioner;
  if (!options.positioner.empty()) positioner.emplace(options.positioner, model);
  const Table* table = positioner ? &*positioner : nullptr;
  TargetReader reader(in, file,
                      {.arm = &nominal,
                       .of_joints = of_joints,
                       .whole_poses_alone = false,
                       .table = table ? &table->robot() : nullptr,
                       .reading = &options.reading});
  Targets targets(options, nominal, model, table, reader.form(), reader.has_status());
  Output output(options, nominal, targets, file);
  UnitWatch units(nominal, reader.form(), options, file);
  while (auto row = reader.next()) {
    units.see(*row, reader.row());
    const auto reached = targets.reach(target_of(*std::move(row), reader.form(), nominal));
    if (!reached) {
      units.end();  // then that is the reason
      std::cout.flush();
      throw CommandError{kFailed, file + ": row " + std::to_string(reader.row()) + ": " + reached.error()};
    }
    output.add(*reached, reader.row(), is_pipe && in.rdbuf()->in_avail() <= 0);
  }
  units.end();
  return output.finish() ? kDone : kFailed;
}

}  // namespace truepose::tools
