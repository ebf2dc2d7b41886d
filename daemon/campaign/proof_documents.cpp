#include "daemon/campaign/proof_documents.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <cmath>

#include "proto/record/arm_document.hpp"

namespace truepose::daemon {

namespace json = boost::json;

namespace {

/// Whole 0.1 um: what follows tells nothing, and a hundred targets are to fit into one message.
double rounded(double mm) { return std::round(mm * 1e4) / 1e4; }

json::object target_json(const TargetOutcome& outcome, std::size_t number, const RobotModel& robot) {
  json::array errors;
  for (const double error_mm : outcome.errors_mm) errors.emplace_back(rounded(error_mm));
  return {{"target", number},
          {"reached", outcome.reached},
          {"reason", outcome.reason},
          {"joints_deg", record::joints_json(outcome.q, robot)},
          {"errors_mm", std::move(errors)},
          {"averaged_mm", rounded(outcome.averaged_error_mm)}};
}

json::object position_json(const Eigen::Vector3d& p_mm) {
  return {{"x", p_mm.x()}, {"y", p_mm.y()}, {"z", p_mm.z()}};
}

}  // namespace

json::object targets_document(const TargetsResult& result, const RobotModel& robot) {
  json::array targets;
  for (const TargetOutcome& outcome : result.targets)
    targets.push_back(target_json(outcome, targets.size() + 1, robot));
  return {{"tolerance_mm", result.loop.tolerance_mm},
          {"rounds", result.loop.rounds},
          {"readings", result.readings},
          {"reached", std::ranges::count(result.targets, true, &TargetOutcome::reached)},
          {"targets", std::move(targets)}};
}

json::object iso9283_campaign_document(const Iso9283Test& test) {
  json::object document = record::iso9283_document(test.result, test.points, test.frame);
  document["compensated"] = test.compensated;
  json::object cube = position_json(test.cube.X_BC.translation());
  cube["edge"] = test.cube.edge_mm;
  document["cube"] = std::move(cube);
  json::array commanded;
  for (const Iso9283Stop& stop : test.stops) {
    const TestPoint& point = test.points[stop.point];
    json::object position = position_json(point.commanded.p_mm);
    position["point"] = point.name;
    if (!stop.direction.empty()) position["direction"] = stop.direction;
    commanded.push_back(std::move(position));
  }
  document["commanded"] = std::move(commanded);
  return document;
}

}  // namespace truepose::daemon
