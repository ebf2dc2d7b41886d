#include "daemon/campaign/campaign_result.hpp"

namespace truepose::daemon {

MeasurementData measurement_data(const std::vector<StoredPoint>& points, const std::string& smr) {
  MeasurementData data;
  data.smr_names = {smr};
  for (const StoredPoint& point : points) {
    if (point.purpose != PointPurpose::Identify && point.purpose != PointPurpose::Validate) continue;
    Measurement measurement;
    measurement.q = point.q_actual;
    measurement.direction = point.direction;
    measurement.p_WS_mm = point.p_WS_mm;
    measurement.set = point.purpose == PointPurpose::Identify ? PoseSet::Identify : PoseSet::Validate;
    measurement.time = point.time;
    measurement.pose = point.pose;
    data.points.push_back(measurement);
  }
  return data;
}

std::vector<Measurement> numbered_points(const std::vector<StoredPoint>& points) {
  std::vector<Measurement> numbered = measurement_data(points, {}).points;
  for (std::size_t i = 0; i < numbered.size(); ++i) numbered[i].row = static_cast<int>(i) + 1;
  return numbered;
}

}  // namespace truepose::daemon
