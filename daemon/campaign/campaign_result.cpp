#include "daemon/campaign/campaign_result.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "core/frames/tool_turn.hpp"

namespace truepose::daemon {
namespace {

/// Of those that were measured, `first` before all others.
std::vector<std::string> reflector_names(const std::vector<StoredPoint>& points, const std::string& first) {
  std::vector<std::string> names;
  for (const StoredPoint& point : points)
    if (shows_arm(point) && std::ranges::find(names, point.smr) == names.end()) names.push_back(point.smr);
  if (names.empty()) return {first};
  if (const auto found = std::ranges::find(names, first); found != names.end())
    std::rotate(names.begin(), found, found + 1);
  return names;
}

}  // namespace

std::string model_serial(const CampaignOrder& order) {
  const auto serial = []<typename Order>(const Order& by_model) -> std::string {
    if constexpr (std::is_same_v<Order, CalibrationOrder>)
      return {};
    else if constexpr (std::is_same_v<Order, DriftOrder>)
      return by_model.model.robot_serial;
    else
      return by_model.model_serial;
  };
  return std::visit(serial, order);
}

MeasurementData measurement_data(const std::vector<StoredPoint>& points, const std::string& smr) {
  MeasurementData data;
  data.smr_names = reflector_names(points, smr);
  for (const StoredPoint& point : points) {
    if (!shows_arm(point)) continue;
    Measurement measurement;
    measurement.q = point.q_actual;
    measurement.direction = point.direction;
    measurement.smr = static_cast<int>(std::ranges::find(data.smr_names, point.smr) - data.smr_names.begin());
    measurement.p_WS_mm = *point.p_WS_mm;
    measurement.orientation = point.orientation;
    measurement.set = point.purpose == PointPurpose::Identify ? PoseSet::Identify : PoseSet::Validate;
    measurement.time = point.time;
    measurement.pose = point.pose;
    data.points.push_back(measurement);
  }
  return data;
}

FrameReadings frame_readings(const std::vector<StoredPoint>& points,
                             std::vector<FramePoint> points_of_frame) {
  const bool all = points_of_frame.empty();
  FrameReadings data{.points = std::move(points_of_frame), .readings = {}};
  for (const StoredPoint& point : points) {
    if (point.purpose != PointPurpose::Frame) continue;
    auto of = std::ranges::find(data.points, point.smr, &FramePoint::name);
    if (of == data.points.end()) {
      if (!all) continue;
      of = data.points.insert(of, {point.smr, std::nullopt});
    }
    data.readings.push_back({.point = static_cast<std::size_t>(of - data.points.begin()),
                             .q = point.q_actual,
                             .p_WS_mm = point.p_WS_mm,
                             .orientation = point.orientation,
                             .row = static_cast<int>(data.readings.size()) + 1});
  }
  // A 6-D target that is put from point to point is a reflector there: the points give the orientation.
  if (data.points.size() > 1 || (!data.points.empty() && data.points.front().p_mm))
    return without_orientations(std::move(data));
  return data;
}

FrameReadings readings_of_base(const std::vector<StoredPoint>& points,
                               std::vector<FramePoint> points_of_frame) {
  FrameReadings data = frame_readings(points, std::move(points_of_frame));
  for (FrameReading& reading : data.readings)
    if (reading.p_WS_mm) reading.q.resize(0);
  return without_orientations(std::move(data));
}

std::vector<Measurement> numbered_points(const std::vector<StoredPoint>& points) {
  std::vector<Measurement> numbered = measurement_data(points, {}).points;
  for (std::size_t i = 0; i < numbered.size(); ++i) numbered[i].row = static_cast<int>(i) + 1;
  return numbered;
}

}  // namespace truepose::daemon
