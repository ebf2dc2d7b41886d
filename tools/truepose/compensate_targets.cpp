#include "tools/truepose/compensate_targets.hpp"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "config/text_file.hpp"
#include "core/arm/joint_units.hpp"
#include "core/compensate/nominal_inverse.hpp"
#include "core/identify/uncertainty.hpp"
#include "tools/truepose/exit_code.hpp"
#include "tools/truepose/reached_target.hpp"
#include "tools/truepose/target_reader.hpp"

namespace truepose::tools {

namespace {

namespace json = boost::json;
using config::ConfigError;
using config::UnfinishedFile;

constexpr std::string_view kStandard = "-";
constexpr const char* kNoSigma = ": tells no covariance, so no sigma_mm is given; calibrate again to have it";

/// Standard deviation (length of the vector, mm) of where the arm will stand, told by the model's covariance
/// and the arm's repeatability. It is that of the first reflector: of that point the measurements tell, while
/// what they know of the arm alone is mixed with what they know of base and tool.
class PositionSigma {
 public:
  explicit PositionSigma(const config::ModelFile& model) : model_(model) {}

  bool is_known() const { return model_.covariance.size() > 0 && !model_.cell.reflectors.empty(); }
  double at(const JointVector& q) const {
    const double repeatability = model_.noise ? model_.noise->repeatability_mm : 0;
    const double of_model = position_covariance(model_.cell, model_.covariance, q, 0).trace();
    return std::sqrt(std::max(0.0, of_model) + 3 * repeatability * repeatability);
  }

 private:
  const config::ModelFile& model_;
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
  Targets(const TargetOptions& options, const RobotModel& nominal, const config::ModelFile& model,
          TargetForm form, bool by_status)
      : nominal_(nominal),
        sigma_(model),
        form_(form),
        by_status_(by_status),
        X_FT_(options.X_FT.value_or(Eigen::Isometry3d::Identity())),
        position_only_(options.position_only || form == TargetForm::Positions),
        inverse_(nominal, near_of(options.near, nominal)),
        compensation_(nominal, model.cell.robot, options.bounds) {}

  ReachColumns columns() const { return {.orientation = !position_only_, .sigma = sigma_.is_known()}; }

  std::expected<ReachedTarget, std::string> reach(const Target& target) {
    const auto q = nominal_joints(target);
    if (!q) return std::unexpected(q.error());
    const auto compensated = compensate(target, *q);
    if (!compensated) return std::unexpected(described(compensated.error(), nominal_));
    ReachedTarget reached{.q_nominal = *q, .compensated = *compensated, .sigma_mm = {}};
    if (sigma_.is_known()) reached.sigma_mm = sigma_.at(compensated->q);
    return reached;
  }

 private:
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
    if (form_ == TargetForm::Joints) return compensation_.at_joints(q, p_F_mm());
    return compensation_.at_pose(flange(target), q, p_F_mm());
  }

  const RobotModel& nominal_;
  PositionSigma sigma_;
  TargetForm form_;
  bool by_status_;
  Eigen::Isometry3d X_FT_;
  bool position_only_;
  NominalInverse inverse_;
  TargetCompensation compensation_;
};

/// Where the results go: rows at once, what must be whole at the end.
class Output {
 public:
  Output(const TargetOptions& options, const RobotModel& nominal, const ReachColumns& columns,
         const std::string& file)
      : options_(options),
        nominal_(nominal),
        columns_(columns),
        report_{nominal.name, file, !columns.orientation, {}} {
    if (options.as_json) document_ = empty_document(columns);
    if (!options.out_file.empty() && options.out_file != kStandard) out_.emplace(options.out_file);
    if (!options.report_file.empty()) report_file_.emplace(options.report_file);
    if (std::ostream* out = csv()) {
      write_csv_header(*out, nominal, columns);
      out->flush();
    }
  }

  /// @param flush  a reader may be waiting for this row before it sends the next
  void add(const ReachedTarget& target, bool flush) {
    if (std::ostream* out = csv()) {
      write_csv_row(*out, nominal_, target, columns_);
      if (flush) out->flush();
      if (!*out) throw ConfigError("the joint positions cannot be written");
    }
    if (options_.as_json) append(document_, nominal_, target);
    if (report_file_) report_.rows.push_back(report_row(nominal_, target));
  }

  void finish() {
    if (report_file_) report_file_->stream() << report::render_compensation_html(report_);
    if (!columns_.sigma) note(options_.arm.model.string() + kNoSigma);
    if (options_.as_json) std::cout << document_ << '\n';
    if (!std::cout.flush()) throw ConfigError("standard output cannot be written");
    for (auto* file : {&out_, &report_file_}) {
      if (*file) (*file)->close();
    }
    for (auto* file : {&out_, &report_file_}) {
      if (*file) (*file)->take_place();
    }
  }

 private:
  void note(std::string text) {
    if (options_.as_json) {
      document_["notes"] = json::array{std::move(text)};
    } else {
      std::cerr << "truepose: " << text << '\n';
    }
  }
  std::ostream* csv() {
    if (out_) return &out_->stream();
    return options_.as_json ? nullptr : &std::cout;
  }

  const TargetOptions& options_;
  const RobotModel& nominal_;
  ReachColumns columns_;
  std::optional<UnfinishedFile> out_, report_file_;
  json::object document_;
  report::CompensationReport report_;
};

}  // namespace

int run_compensate_targets(const TargetOptions& options, const RobotModel& nominal,
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

  TargetReader reader(in, file, nominal, of_joints);
  Targets targets(options, nominal, model, reader.form(), reader.has_status());
  Output output(options, nominal, targets.columns(), file);
  while (const auto target = reader.next()) {
    const auto reached = targets.reach(*target);
    if (!reached) {
      std::cout.flush();
      std::cerr << "truepose: " << file << ": row " << reader.row() << ": " << reached.error() << '\n';
      return kFailed;
    }
    output.add(*reached, is_pipe && in.rdbuf()->in_avail() <= 0);
  }
  output.finish();
  return kDone;
}

}  // namespace truepose::tools
