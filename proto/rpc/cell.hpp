#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/campaign.hpp"
#include "proto/rpc/method.hpp"
#include "proto/rpc/model.hpp"
#include "proto/rpc/stream.hpp"

namespace truepose::rpc {

struct RobotStatus {
  bool connected = false;
  std::string model{};
  std::string serial{};
  std::string software{};
  bool ready = false;
  std::string why_not_ready{};
  std::vector<double> q_deg{};
};
void layout(Io& io, RobotStatus& x);

struct TrackerStatus {
  bool connected = false;
  std::string model{};
  std::string serial{};
  std::string firmware{};
  std::string why_not_ready{};
};
void layout(Io& io, TrackerStatus& x);

struct Fault {
  std::string code{};
  std::string severity{};
  std::string text{};
  std::string since{};
};
void layout(Io& io, Fault& x);
/// Its members, in a record around it.
void layout_members(Io& io, Fault& x);

struct AwaitedDevice {
  std::string device{};
  std::string since{};
  std::string reason{};
};

struct CellStatus {
  struct Recording {
    double seconds = 0;
    std::uint64_t bytes = 0;
    std::uint64_t dropped = 0;
    std::optional<std::string> last{};
  };
  std::string cell{};
  std::string state{};
  std::string state_text{};
  std::optional<std::string> next{};
  std::vector<std::string> allowed{};
  std::optional<AwaitedDevice> waiting{};
  std::string time{};
  RobotStatus robot{};
  TrackerStatus tracker{};
  std::optional<CampaignProgress> campaign{};
  std::vector<InterruptedCampaign> interrupted{};
  std::optional<ModelSummary> model{};
  StreamStatus stream{};
  Recording recording{};
  std::vector<Fault> faults{};
};
void layout(Io& io, CellStatus& x);

/// system.config
struct SystemConfig : NoParameters {
  struct Result {
    boost::json::object config{};
  };
  static const Method& method();
};
void layout(Io& io, SystemConfig::Result& x);

/// cell.status
struct GetCellStatus : NoParameters {
  using Result = CellStatus;
  static const Method& method();
};

/// cell.connect
struct CellConnect : NoParameters {
  using Result = CellStatus;
  static const Method& method();
};

/// cell.disconnect
struct CellDisconnect : NoParameters {
  using Result = CellStatus;
  static const Method& method();
};

/// cell.acknowledge
struct CellAcknowledge : NoParameters {
  using Result = CellStatus;
  static const Method& method();
};

/// The methods of this file.
std::vector<Described> cell_methods();

}  // namespace truepose::rpc
