#include "tests/daemon/sample_document.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "proto/record/calibration_content.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;

constexpr unsigned kSeed = 20;

AxisStatistics axis(const std::vector<Eigen::Vector3d>& errors, int k) {
  AxisStatistics s;
  for (const Eigen::Vector3d& e : errors) {
    s.mean_abs += std::abs(e[k]) / static_cast<double>(errors.size());
    s.rms += e[k] * e[k] / static_cast<double>(errors.size());
    s.max_abs = std::max(s.max_abs, std::abs(e[k]));
  }
  s.rms = std::sqrt(s.rms);
  return s;
}

ErrorStatistics statistics(const std::vector<Eigen::Vector3d>& errors) {
  const double n = static_cast<double>(errors.size());
  ErrorStatistics s;
  s.count = static_cast<int>(errors.size());
  s.min = 1e300;
  for (const Eigen::Vector3d& e : errors) {
    s.mean += e.norm() / n;
    s.rms += e.squaredNorm() / n;
    s.max = std::max(s.max, e.norm());
    s.min = std::min(s.min, e.norm());
  }
  s.std = std::sqrt((s.rms - s.mean * s.mean) * n / (n - 1));
  s.rms = std::sqrt(s.rms);
  s.x = axis(errors, 0);
  s.y = axis(errors, 1);
  s.z = axis(errors, 2);
  return s;
}

std::vector<Eigen::Vector3d> random_errors(std::mt19937& random, int count, double size_mm) {
  std::normal_distribution<double> normal{0, size_mm};
  std::vector<Eigen::Vector3d> errors;
  for (int i = 0; i < count; ++i) errors.emplace_back(normal(random), normal(random), normal(random));
  return errors;
}

/// Somewhere in the workspace, far from the axes of both joints.
Eigen::Vector3d place(std::size_t i) {
  const double angle = 0.7 * static_cast<double>(i);
  return {3000 + 900 * std::cos(angle), -1200 + 900 * std::sin(angle), 800 + 9 * static_cast<double>(i)};
}

StageErrors add_set(Calibration& calibration, MeasurementData& data, std::mt19937& random, int count,
                    PoseSet set) {
  const auto before = random_errors(random, count, 1.8), geometric = random_errors(random, count, 0.4),
             after = random_errors(random, count, 0.33);
  for (std::size_t i = 0; i < before.size(); ++i) {
    Measurement m;
    m.q = Eigen::Vector2d{0.01 * static_cast<double>(data.points.size()), 20};
    m.p_WS_mm = place(data.points.size());
    m.set = set;
    calibration.points.push_back({before[i], geometric[i], after[i]});
    data.points.push_back(m);
  }
  return {count, count, statistics(before), statistics(geometric), statistics(after)};
}

json::object sample(std::mt19937& random, int points, bool validated) {
  Calibration calibration;
  calibration.converged = true;
  calibration.coarse_iterations = 7;
  calibration.fine_iterations = 4;
  calibration.rank = 5;
  calibration.observability.o2 = 1 / 48.7;
  calibration.coarse.robot.name = "Two joints";
  calibration.coarse.robot.joints = {{.d_mm = 500, .min = -3, .max = 3, .speed = 1},
                                     {.a_mm = 300, .alpha_rad = -1.5, .min = -3, .max = 3, .speed = 1}};
  calibration.cell.robot = calibration.coarse.robot;
  calibration.cell.base = {{3000, -1200, 50}, {0.01, 0.02, 2.5}};
  calibration.cell.reflectors = {{"1", {40.1, -30.2, 120.3}}};
  calibration.parameters = {{"base.x", 0, 3000, 0.013, true, 1},
                            {"base.rz", 0, 2.5, 4e-6, true, 1},
                            {"smr.1.x", 0, 40.1, 0.008, true, 1},
                            {"link2.a", 330, 330.6261, 0.0112, true, 1},
                            {"link2.alpha", -1.5707963, -1.5687, 1.1e-5, true, 1},
                            {"link2.beta", 0, 0, 0, false}};
  MeasurementData data{.smr_names = {"1"}, .points = {}};
  calibration.identify = add_set(calibration, data, random, points, PoseSet::Identify);
  if (validated) calibration.validate = add_set(calibration, data, random, points, PoseSet::Validate);
  json::object document = record::calibration_document(calibration, data, 0.0042);
  document["verdict"] = record::verdict_json({});
  return document;
}

}  // namespace

json::object sample_document(int points, bool validated) {
  std::mt19937 random{kSeed};
  return sample(random, points, validated);
}

json::object full_document(int points) {
  std::mt19937 random{kSeed};
  json::object document = sample(random, points, true);
  const std::vector<Eigen::Vector3d> remeasured = random_errors(random, points, 0.3);
  document["remeasured"] = record::to_json(statistics(remeasured));
  json::array list;
  for (const Eigen::Vector3d& e : remeasured) {
    const int pose = points + 1 + static_cast<int>(list.size());
    list.push_back({{"pose", pose}, {"smr", "1"}, {"error", {e.x(), e.y(), e.z()}}});
  }
  document["remeasured_points"] = std::move(list);
  document["stream"] = {{"cycles", 15000},
                        {"answered", 14998},
                        {"late", 2},
                        {"wrong_ipoc", 0},
                        {"max_step_deg", 0.00213},
                        {"turnaround_us", {{"p50", 31}, {"p99", 74.5}, {"p999", 212}, {"max", 640}}}};
  document["truth"] = {
      {"base", {{"x", 3000.01}, {"y", 0}, {"z", 0}, {"rx", 0}, {"ry", 0}, {"rz", 2.5 - 6.283185307179586}}},
      {"smr", {{"x", 40.0}, {"y", 0}, {"z", 0}}},
      {"links",
       {{{"a", 0}, {"alpha", 0}, {"d", 0}, {"theta", 0}, {"beta", 0}},
        {{"a", 330.63}, {"alpha", -1.5688}, {"d", 0}, {"theta", 0}, {"beta", 0.001}}}}};
  document["robot"] = "KUKA KR 210 R2700-2";
  document["tracker"] = "Leica AT960";
  document["campaign"] = "Campaign 12";
  return document;
}

}  // namespace truepose::report
