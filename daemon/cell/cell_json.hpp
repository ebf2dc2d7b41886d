#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <string>

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/realtime/latency_histogram.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

/// What an operator should know of, until it ends.
struct Fault {
  std::string code;      ///< stable, for programs
  std::string severity;  ///< "warning" or "error"
  std::string text;      ///< one sentence
  std::string since;     ///< RFC 3339
};

// The schemas of proto/control/openrpc.json, filled in.

boost::json::array vector_json(const Eigen::Vector3d& v);
std::string_view purpose_name(PointPurpose purpose);

boost::json::object campaign_json(const CampaignRecord& record);
boost::json::object skipped_json(const SkippedPose& skipped);
boost::json::object point_json(const RobotModel& robot, const StoredPoint& point);
boost::json::object model_json(const ModelRecord& record);
boost::json::object parameter_json(const IdentifiedParameter& parameter);
boost::json::object fault_json(const Fault& fault);
boost::json::object config_json(const config::CellConfig& config);

/// What stands around the stream's own status.
struct StreamSurroundings {
  bool streaming = false;                ///< the cell is in its state "streaming"
  std::optional<drivers::Duration> age;  ///< of the controller's last good packet, where there was one
  std::string refused;                   ///< the last packet that was not taken, in words; empty = none
  std::string trouble;  ///< why it does not run, which the realtime thread does not know; empty = it may
  std::string model_id;
};

/// @param model_id   of the model in force, or empty
boost::json::object stream_json(const StreamStatus& status, const LatencyHistogram::Summary& turnaround,
                                const StreamSurroundings& around);

}  // namespace truepose::daemon
