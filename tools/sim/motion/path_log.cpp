#include "tools/sim/motion/path_log.hpp"

#include <stdexcept>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"

namespace truepose::sim {
namespace {

constexpr std::uint64_t kEvery = 5;   // cycles
constexpr double kStands_rad = 1e-6;  // from one cycle to the next: the drives have arrived to some um

constexpr std::string_view kHeader =
    "time_s,program,point,gain_percent,flange_x_mm,flange_y_mm,flange_z_mm,flange_a_deg,flange_b_deg,flange_c_deg,"
    "with_x_mm,with_y_mm,with_z_mm,without_x_mm,without_y_mm,without_z_mm";

std::string columns(const Eigen::Vector3d& v) { return formatted(",%.5f,%.5f,%.5f", v.x(), v.y(), v.z()); }

std::string axis_columns(const JointVector& q_rad) {
  std::string text;
  for (const double axis : q_rad) text += formatted(",%.6f", axis * kDegPerRad);
  return text;
}

std::string axis_names(Eigen::Index axes) {
  std::string names;
  for (const char* name : {"set", "correction", "actual"}) {
    for (Eigen::Index i = 1; i <= axes; ++i) names += formatted(",%s_a%d_deg", name, static_cast<int>(i));
  }
  return names;
}

}  // namespace

PathLog::PathLog(const std::filesystem::path& file, RobotModel nominal, TrueArmSetup truth)
    : nominal_{std::move(nominal)}, truth_{std::move(truth)}, file_{file} {
  file_ << kHeader << axis_names(nominal_.joint_count()) << "\n";
  if (!file_.flush()) throw std::runtime_error{file.string() + ": cannot be written"};
}

void PathLog::take(const ProgramCycle& cycle) {
  const bool point = is_point(cycle);
  if (!point && cycles_++ % kEvery != 0) return;
  const auto seen_W_mm = [&](const JointVector& q) {
    const JointVector displaced = q + joint_displacement(truth_.robot, truth_.non_geometric, q, {});
    return Eigen::Vector3d{truth_.X_WB * (forward_kinematics(truth_.robot, displaced) * truth_.p_FS_mm)};
  };
  const Eigen::Isometry3d X_BF = forward_kinematics(nominal_, cycle.set_points);
  const std::string row = formatted("%.3f,", cycle.time.count()) + cycle.program +
                          formatted(",%d,%d", point ? 1 : 0, cycle.gain_percent) +
                          columns(X_BF.translation()) + columns(kuka_abc_deg(X_BF.linear())) +
                          columns(seen_W_mm(cycle.actual)) + columns(seen_W_mm(cycle.set_points)) +
                          axis_columns(cycle.set_points) + axis_columns(cycle.correction) +
                          axis_columns(cycle.actual) + "\n";
  const std::lock_guard lock{mutex_};
  rows_ += row;
}

void PathLog::flush() {
  std::string rows;
  {
    const std::lock_guard lock{mutex_};
    rows = std::exchange(rows_, {});
  }
  file_ << rows << std::flush;
}

/// Once after each motion, when the drives have followed it to its end.
bool PathLog::is_point(const ProgramCycle& cycle) {
  const bool stands =
      cycle.is_standing && actual_.size() > 0 && (cycle.actual - actual_).cwiseAbs().maxCoeff() < kStands_rad;
  actual_ = cycle.actual;
  return stands && std::exchange(judged_, cycle.motions_made) != cycle.motions_made;
}

}  // namespace truepose::sim
