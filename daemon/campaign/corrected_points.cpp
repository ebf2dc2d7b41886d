#include "daemon/campaign/corrected_points.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "core/change/drift_causes.hpp"
#include "core/change/tracker_motion.hpp"
#include "core/change/two_face.hpp"
#include "core/math/statistics.hpp"
#include "daemon/campaign/campaign_past.hpp"
#include "daemon/campaign/campaign_result.hpp"

namespace truepose::daemon {
namespace {

// ---- Faces

/// A reflector at a pose.
using Seen = std::pair<int, std::string>;
Seen seen_of(const StoredPoint& point) { return {point.pose, point.smr}; }

/// What face 1 saw of what was seen in both.
std::map<Seen, Eigen::Vector3d> seen_in_face1(const std::vector<StoredPoint>& measured) {
  std::map<Seen, Eigen::Vector3d> seen;
  for (const StoredPoint& point : measured)
    if (point.purpose == PointPurpose::Face1) seen.insert_or_assign(seen_of(point), *point.p_WS_mm);
  return seen;
}

std::optional<AimingConstants> constants_of(const std::vector<StoredPoint>& points,
                                            const std::map<Seen, Eigen::Vector3d>& face1,
                                            const TrackerNoiseModel& noise) {
  std::vector<FacePair> pairs;
  for (const StoredPoint& point : points)
    if (const auto seen = face1.find(seen_of(point)); seen != face1.end())
      pairs.push_back({seen->second, *point.p_WS_mm});
  return aiming_constants(pairs, noise);
}

void correct_aim(const std::vector<StoredPoint>& measured, const TrackerNoiseModel& noise,
                 CorrectedPoints& corrected) {
  const auto face1 = seen_in_face1(measured);
  const auto constants = constants_of(corrected.points, face1, noise);
  if (!constants) return;
  corrected.findings.push_back(finding(FindingKind::TwoFace, described(*constants)));
  if (constants->fit < kSignificance)
    corrected.findings.push_back(finding(FindingKind::TwoFaceUnexplained,
                                         "the tracker's faces differ by more than such constants explain"));
  if (!constants->significant()) return;
  for (StoredPoint& point : corrected.points)
    if (!face1.contains(seen_of(point))) point.p_WS_mm = constants->corrected(*point.p_WS_mm);
}

// ---- Nests

/// All nests measured at one time.
struct Check {
  int pose = 0;  ///< number that they share
  NestReadings nests;
  std::size_t points_before = 0;  ///< of the arm
};

std::size_t number_of_nest(const std::string& name) {
  const std::string_view digits = std::string_view{name}.substr(std::string_view{kNestName}.size());
  std::size_t number = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

std::vector<Check> checks_of(const std::vector<StoredPoint>& measured, std::size_t nests) {
  std::vector<Check> checks;
  std::size_t points = 0;
  for (const StoredPoint& point : measured) {
    points += is_pose(point.purpose);
    if (point.purpose != PointPurpose::Nest) continue;
    if (checks.empty() || checks.back().pose != point.pose)
      checks.push_back({point.pose, NestReadings(nests), points});
    const std::size_t nest = number_of_nest(point.smr);
    if (nest >= 1 && nest <= nests) checks.back().nests[nest - 1] = {*point.p_WS_mm, 1};
  }
  return checks;
}

/// Where a point lies between two checks.
struct Place {
  std::size_t check = 0;  ///< the one before it
  double share = 0;       ///< of the way to the next
};

/// Of each point of the arm; nothing before the first check.
std::vector<std::optional<Place>> places_of(const std::vector<Check>& checks, std::size_t points) {
  std::vector<std::optional<Place>> places(points);
  for (std::size_t k = 0; k < checks.size(); ++k) {
    const std::size_t from = checks[k].points_before;
    const std::size_t to = k + 1 < checks.size() ? checks[k + 1].points_before : points;
    for (std::size_t i = from; i < to; ++i)
      places[i] = Place{k, (static_cast<double>(i - from) + 0.5) / static_cast<double>(to - from)};
  }
  return places;
}

/// Whether it is open, by more than the noise, where the first stand would have seen a point.
bool is_open(const StandHistory& history, const Place& place, const Eigen::Vector3d& p_mm,
             const MeasurementNoise& noise) {
  constexpr double kMostSigmas = 3;
  if (!history.stepped_after(place.check)) return false;
  const Eigen::Vector3d before_mm = history.to_start(place.check, 0) * p_mm;
  const Eigen::Vector3d after_mm = history.to_start(place.check, 1) * p_mm;
  const double sigma_mm = std::sqrt(reading_covariance(p_mm, noise).trace() / 3);
  return (after_mm - before_mm).norm() > kMostSigmas * sigma_mm;
}

/// Brings each point to where the first stand would have seen it, and leaves out those of which nothing shows
/// that.
/// @return the numbers of the poses that were left out
std::set<int> move_to_start(const std::vector<Check>& checks, const StandHistory& history,
                            const MeasurementNoise& noise, std::vector<StoredPoint>& points) {
  const auto places = places_of(checks, points.size());
  std::vector<StoredPoint> moved;
  std::set<int> left_out;  // a pose has a point of each reflector
  for (std::size_t i = 0; i < points.size(); ++i) {
    StoredPoint& point = points[i];
    if (places[i] && is_open(history, *places[i], *point.p_WS_mm, noise)) {
      left_out.insert(point.pose);
      continue;
    }
    if (places[i]) point.transform(history.to_start(places[i]->check, places[i]->share));
    moved.push_back(std::move(point));
  }
  points = std::move(moved);
  return left_out;
}

/// "3 poses that were measured while it moved were left out: 17, 18, 19"
std::string left_out_text(const std::set<int>& poses) {
  std::string text =
      std::to_string(poses.size()) +
      (poses.size() == 1 ? " pose that was measured while the tracker moved was left out: "
                         : " poses that were measured while the tracker moved were left out: ");
  for (const int pose : poses) text += (pose == *poses.begin() ? "" : ", ") + std::to_string(pose);
  return text;
}

void correct_tracker_drift(const std::vector<StoredPoint>& measured, const config::CellConfig& config,
                           CorrectedPoints& corrected) {
  const std::vector<Check> checks = checks_of(measured, config.tracker.nests_mm.size());
  std::vector<NestReadings> seen;
  for (const Check& check : checks) seen.push_back(check.nests);
  const StandHistory history = stand_history(seen, config.tracker.noise);
  const bool correct = config.campaign.correct_by_nests;
  for (const std::string& move : described_moves(history))
    corrected.findings.push_back(
        correct ? finding(FindingKind::NestsCorrected, move + "; its points were corrected by that")
                : finding(FindingKind::NestsMoved, move));
  for (const std::string& doubt : history.doubts)
    corrected.findings.push_back(finding(FindingKind::NestsDoubtful, doubt));
  if (!correct || !history.moved()) return;
  const MeasurementNoise noise{config.tracker.noise, config.robot.repeatability_mm};
  const std::set<int> left_out = move_to_start(checks, history, noise, corrected.points);
  if (!left_out.empty())
    corrected.findings.push_back(finding(FindingKind::LeftOutMoving, left_out_text(left_out)));
}

// ---- Reflectors

/// Leaves out what validates by a reflector that was seen at no pose to identify from: nothing tells where it
/// is on the flange, and the others tell of the arm all the same.
void leave_out_unidentified(CorrectedPoints& corrected) {
  std::set<std::string> identified;
  for (const StoredPoint& point : corrected.points)
    if (point.purpose == PointPurpose::Identify) identified.insert(point.smr);
  if (identified.empty()) return;
  std::map<std::string, int> left_out;
  std::erase_if(corrected.points, [&](const StoredPoint& point) {
    const bool unknown = !identified.contains(point.smr);
    if (unknown) ++left_out[point.smr];
    return unknown;
  });
  for (const auto& [name, count] : left_out)
    corrected.findings.push_back(
        finding(FindingKind::ReflectorUnidentified,
                "reflector \"" + name + "\" was seen at no pose to identify from: what was measured of it (" +
                    std::to_string(count) + (count == 1 ? " point" : " points") + ") was left out"));
}

// ---- Scatter

/// Whether a tracker tells the scatter of single readings or of their mean differs from make to make: what
/// counts is by how much a point's own exceeds that of most.
void weigh_by_scatter(const std::vector<StoredPoint>& points, const TrackerNoiseModel& noise,
                      MeasurementData& data) {
  constexpr double kUnsteady = 2;  // times: by chance ten readings seldom scatter so much more than others
  std::map<Seen, double> scatter_mm;
  std::vector<double> all_mm;
  for (const StoredPoint& point : points) all_mm.push_back(scatter_mm[seen_of(point)] = point.std_mm.norm());
  const double usual_mm = median(std::move(all_mm));
  for (Measurement& point : data.points) {
    const std::string& smr = data.smr_names[static_cast<std::size_t>(point.smr)];
    const double times = usual_mm > 0 ? scatter_mm[{point.pose, smr}] / usual_mm : 1;
    if (times <= kUnsteady) continue;
    const double stated_mm = std::sqrt(reading_covariance(point.p_WS_mm, {.tracker = noise}).trace() / 3);
    point.excess_mm = stated_mm * std::sqrt(times * times - 1);
  }
}

}  // namespace

CorrectedPoints corrected_points(const std::vector<StoredPoint>& measured, const config::CellConfig& config,
                                 const std::vector<Resumption>& resumptions) {
  CorrectedPoints corrected;
  for (const StoredPoint& point : measured)
    if (is_pose(point.purpose)) corrected.points.push_back(point);
  correct_aim(measured, config.tracker.noise, corrected);
  std::vector<StoredPoint> at_first = measured;
  for (std::vector<StoredPoint>* points : {&at_first, &corrected.points})
    for (StoredPoint& point : *points) point = in_first_frame(std::move(point), resumptions);
  for (const Resumption& resumption : resumptions)
    corrected.findings.push_back(finding(FindingKind::Resumed, described(resumption)));
  correct_tracker_drift(at_first, config, corrected);
  leave_out_unidentified(corrected);
  return corrected;
}

const StoredPoint* validation_of(const StoredPoint& again, const std::vector<StoredPoint>& points) {
  const auto found = std::ranges::find_if(points, [&](const StoredPoint& point) {
    return point.purpose == PointPurpose::Validate && point.q_target == again.q_target;
  });
  return found == points.end() ? nullptr : &*found;
}

MeasurementData campaign_data(const std::vector<StoredPoint>& measured, const config::CellConfig& config,
                              const std::vector<Resumption>& resumptions) {
  const std::vector<StoredPoint> points = corrected_points(measured, config, resumptions).points;
  MeasurementData data = measurement_data(points, config.reflector.name);
  weigh_by_scatter(points, config.tracker.noise, data);
  return data;
}

}  // namespace truepose::daemon
