#include "tools/sim/cell_report.hpp"

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>

#include "core/math/angles.hpp"

namespace truepose::sim {
namespace {

namespace json = boost::json;

json::object truth(const config::Scenario& scenario) {
  const Eigen::Vector3d p = scenario.X_WB.translation();
  const Eigen::Vector3d angles = angles_zyx(scenario.X_WB.linear());
  const Eigen::Vector3d& smr = scenario.p_FS_mm;
  json::array links;
  for (const Joint& joint : scenario.truth.joints) {
    links.push_back(json::object{{"a", joint.a_mm},
                                 {"alpha", joint.alpha_rad},
                                 {"d", joint.d_mm},
                                 {"theta", joint.theta_rad},
                                 {"beta", joint.beta_rad}});
  }
  return {{"base", json::object{{"x", p.x()},
                                {"y", p.y()},
                                {"z", p.z()},
                                {"rx", angles.x()},
                                {"ry", angles.y()},
                                {"rz", angles.z()}}},
          {"smr", json::object{{"x", smr.x()}, {"y", smr.y()}, {"z", smr.z()}}},
          {"links", std::move(links)}};
}

json::object turnaround_us(const TurnaroundHistogram& turnaround) {
  json::array counts;
  for (const auto& [us, count] : turnaround.counts()) counts.push_back(json::array{us, count});
  return {{"p50", turnaround.percentile_us(0.5)},
          {"p99", turnaround.percentile_us(0.99)},
          {"p999", turnaround.percentile_us(0.999)},
          {"max", turnaround.max_us()},
          {"counts", std::move(counts)}};
}

json::object rsi(const RsiStatistics& statistics) {
  const RsiCounters& counters = statistics.counters;
  return {{"cycles", counters.cycles},
          {"answered", counters.answered},
          {"late", counters.late},
          {"lost", counters.lost},
          {"wrong_ipoc", counters.wrong_ipoc},
          {"rejected", counters.rejected},
          {"clamped", counters.clamped},
          {"max_step_deg", counters.max_step_rad * kDegPerRad},
          {"correction_deg", counters.correction_rad * kDegPerRad},
          {"turnaround_us", turnaround_us(statistics.turnaround)},
          {"sessions", statistics.sessions},
          {"timeouts", statistics.timeouts},
          {"overruns", statistics.overruns},
          {"second_senders",
           json::object{{"cycles", statistics.second_senders.cycles},
                        {"answered", statistics.second_senders.answered},
                        {"max_step_deg", statistics.second_senders.max_step_rad * kDegPerRad}}}};
}

}  // namespace

std::string truth_json(const config::Scenario& scenario) { return json::serialize(truth(scenario)); }

std::string statistics_json(const CellStatistics& statistics, const config::Scenario& scenario) {
  return json::serialize(json::object{{"rsi", rsi(statistics.rsi)},
                                      {"moves", statistics.moves},
                                      {"measurements", statistics.measurements},
                                      {"truth", truth(scenario)}});
}

}  // namespace truepose::sim
