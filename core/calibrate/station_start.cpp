#include "core/calibrate/station_start.hpp"

#include <algorithm>
#include <map>

#include "core/fit/measurement_model.hpp"
#include "core/math/angles.hpp"
#include "core/math/rigid_fit.hpp"

namespace truepose {
namespace {

using Reflectors = std::map<std::string, Eigen::Vector3d>;  // p_FS that are known so far

std::vector<MeasurementData> by_station(const MeasurementData& data) {
  MeasurementData identify = data;
  identify.points = points_of(data, PoseSet::Identify);
  std::vector<MeasurementData> stations;
  for (int s = 0; s < data.station_count(); ++s) stations.push_back(of_station(identify, s));
  return stations;
}

/// The points of one station with the flange of the nominal arm at each.
struct Seen {
  const MeasurementData& data;
  std::vector<Eigen::Isometry3d> X_BF;

  const std::string& name(const Measurement& m) const {
    return data.smr_names[static_cast<std::size_t>(m.smr)];
  }
};

std::expected<Eigen::Isometry3d, std::string> base_by(const Reflectors& known, const Seen& seen) {
  std::vector<Eigen::Vector3d> p_B, p_W;
  for (std::size_t n = 0; n < seen.data.points.size(); ++n) {
    const auto found = known.find(seen.name(seen.data.points[n]));
    if (found == known.end()) continue;
    p_B.push_back(seen.X_BF[n] * found->second);
    p_W.push_back(seen.data.points[n].p_WS_mm);
  }
  return rigid_fit(p_B, p_W);
}

/// Adds the reflectors that are not known yet: the mean of where the points put them.
void add_reflectors(const Eigen::Isometry3d& X_WB, const Seen& seen, Reflectors& known) {
  std::map<std::string, std::pair<Eigen::Vector3d, int>> sums;
  for (std::size_t n = 0; n < seen.data.points.size(); ++n) {
    const Measurement& m = seen.data.points[n];
    auto& [sum, count] = sums.try_emplace(seen.name(m), Eigen::Vector3d::Zero(), 0).first->second;
    sum += inverse_of(X_WB * seen.X_BF[n]) * m.p_WS_mm;
    ++count;
  }
  for (const auto& [name, of] : sums) known.try_emplace(name, of.first / of.second);
}

}  // namespace

std::expected<CalibratedCell, CalibrationError> station_start(
    const Identification& id, const std::function<CalibratedCell(const Identification&)>& alone) {
  const std::vector<MeasurementData> stations = by_station(id.data);
  std::vector<std::size_t> order(stations.size());
  for (std::size_t s = 0; s < order.size(); ++s) order[s] = s;
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t s) { return stations[s].points.size(); });

  CalibratedCell cell{.robot = id.nominal, .base = {}, .reflectors = {}};
  cell.further_bases.resize(stations.size() - 1);
  Reflectors known;
  for (const std::size_t s : order) {
    const MeasurementData& data = stations[s];
    const Seen seen{data, flange_poses(id.nominal, data.points)};
    auto X_WB = base_by(known, seen);
    // Gross errors would carry a rigid motion away, where a start of its own withstands them.
    const bool enough = count_poses(data.points) >= kPosesToPlace;
    if (enough && (!X_WB || reweighs(id.options.loss))) {
      const CalibratedCell start = alone(Identification(id.nominal, data, id.options));
      for (const Reflector& reflector : start.reflectors)
        known.try_emplace(reflector.name, reflector.p_FS_mm);
      X_WB = start.base.isometry();
    }
    if (!X_WB) {
      return std::unexpected(CalibrationError{
          CalibrationFault::TooFewPoses, station_prefix(id.data, static_cast<int>(s)) + X_WB.error() +
                                             ": measure five poses from it, or three that show reflectors "
                                             "that another station has seen"});
    }
    add_reflectors(*X_WB, seen, known);
    cell.base_at(static_cast<int>(s)) = BasePose::of(*X_WB);
  }
  for (const std::string& name : id.data.smr_names) cell.reflectors.push_back({name, known.at(name)});
  return cell;
}

}  // namespace truepose
