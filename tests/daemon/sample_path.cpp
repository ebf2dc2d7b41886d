#include "tests/daemon/sample_path.hpp"

#include <algorithm>
#include <sstream>

namespace truepose::report {
namespace {

/// Wanted after so many samples.
Eigen::Vector3d sample_place(int k) {
  constexpr double kStep_mm = 5;
  constexpr int kCorner = 80;
  return {1000 + kStep_mm * std::min(k, kCorner), kStep_mm * std::max(k - kCorner, 0), 500};
}

}  // namespace

ProductionPath sample_path() {
  ProductionPath path{"GLUING", {}};
  const auto add = [&path](int k, bool at_point, const Eigen::Vector3d& with_mm, double without_mm) {
    path.samples.push_back({.time_s = 0.02 * k,
                            .at_point = at_point,
                            .gain_percent = 100,
                            .wanted_mm = sample_place(k),
                            .with_mm = with_mm,
                            .without_mm = sample_place(k) + Eigen::Vector3d{0, 0, without_mm}});
  };
  for (int k = 0; k <= 120; ++k) {
    add(k, false, sample_place(std::max(k - 2, 0)) + Eigen::Vector3d{0, 0, 0.05}, 1.5);
    if (k == 80) add(k, true, sample_place(k) + Eigen::Vector3d{0.06, 0, 0.08}, 2);
    if (k == 120) add(k, true, sample_place(k) + Eigen::Vector3d{0, 0, 0.2}, 1);
  }
  return path;
}

std::string path_file_of(const ProductionPath& path, const Eigen::Isometry3d& X_WB,
                         const Eigen::Vector3d& p_FS_mm) {
  std::ostringstream rows;
  rows.precision(12);
  rows << "time_s,program,point,gain_percent,flange_x_mm,flange_y_mm,flange_z_mm,flange_a_deg,flange_b_deg,"
          "flange_c_deg,with_x_mm,with_y_mm,with_z_mm,without_x_mm,without_y_mm,without_z_mm\n";
  const auto add = [&rows](const Eigen::Vector3d& p) {
    rows << ',' << p.x() << ',' << p.y() << ',' << p.z();
  };
  for (const PathSample& sample : path.samples) {
    rows << sample.time_s << ',' << path.program << ',' << sample.at_point << ',' << sample.gain_percent;
    add(sample.wanted_mm - p_FS_mm);
    add({0, 0, 0});
    add(X_WB * sample.with_mm);
    add(X_WB * sample.without_mm);
    rows << '\n';
  }
  return rows.str();
}

}  // namespace truepose::report
