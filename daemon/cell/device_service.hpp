#pragma once

#include <boost/asio/awaitable.hpp>
#include <expected>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/campaign/cell_devices.hpp"
#include "daemon/cell/cell_runner.hpp"
#include "daemon/cell/service.hpp"
#include "daemon/cell/store_watch.hpp"
#include "daemon/cell/watched_devices.hpp"
#include "daemon/threads/signal.hpp"
#include "proto/rpc/cell.hpp"

namespace truepose::daemon {

/// Robot and tracker as the cell's state has them: connects and closes them, and asks in every state in which
/// they are connected whether they are still there.
class DeviceService {
 public:
  /// @param status  of the whole cell, which the methods answer with
  DeviceService(const CellParts& parts, CellRunner& runner, StoreWatch& store,
                std::function<rpc::CellStatus()> status);

  static std::vector<Served<DeviceService>> methods();

  /// Looks after the devices. Ends when cancelled.
  boost::asio::awaitable<void> watch();
  /// Brakes the arm, and leaves the program that it is in.
  boost::asio::awaitable<void> stop_robot();
  void disconnect() { devices_.disconnect(); }
  /// Connects what an abort has left without a connection. @return whether both are connected then
  boost::asio::awaitable<bool> connect_again();
  /// Whether both are connected.
  bool connected() const { return robot_.connected() && tracker_.connected(); }
  /// A campaign begins, and is not bothered about what it does not use.
  void serve(const CampaignNeeds& needs) { needs_ = needs; }

  /// The controller's latest state, or why it is not known.
  std::expected<drivers::RobotState, std::string> robot_state() const;
  /// What keeps a ready cell's arm from moving, and the way out; empty where nothing does.
  std::string how_to_get_ready() const;
  /// Of the arm that is connected, else as the state server reported it last; none: unknown.
  std::optional<std::string> arm_serial() const;
  /// That something belongs to another arm than the one that is there, in one sentence; empty: it does not,
  /// or that is not known.
  /// @param what    "the model"
  /// @param serial  of the arm that it belongs to
  std::string other_arm(const std::string& what, const std::string& serial) const;
  /// Asks the state server, without a connection.
  boost::asio::awaitable<void> refresh_robot();
  /// Asks the devices at once, and not only at the next second.
  void ask_soon() { soon_.notify(); }
  WatchedRobot& robot() { return robot_; }
  const WatchedRobot& robot() const { return robot_; }
  WatchedTracker& tracker() { return tracker_; }
  const WatchedTracker& tracker() const { return tracker_; }
  rpc::RobotStatus robot_status() const;
  rpc::TrackerStatus tracker_status() const;

 private:
  Reply<rpc::SystemConfig> config(rpc::SystemConfig);
  Reply<rpc::GetCellStatus> status(rpc::GetCellStatus);
  Reply<rpc::CellConnect> connect(rpc::CellConnect, std::string by);
  Reply<rpc::CellDisconnect> disconnect(rpc::CellDisconnect, std::string by);
  Reply<rpc::CellAcknowledge> acknowledge(rpc::CellAcknowledge, std::string by);

  void close();
  bool in_campaign() const { return runner_.in<Running>() || runner_.in<Paused>(); }
  bool may_be_asked() const { return runner_.in<Ready>() || runner_.in<Streaming>() || in_campaign(); }
  boost::asio::awaitable<void> ask_robot();
  boost::asio::awaitable<void> ask_tracker();

  CellParts parts_;
  CellRunner& runner_;
  StoreWatch& store_;
  std::function<rpc::CellStatus()> status_;
  Signal soon_;
  WatchedRobot robot_;
  WatchedTracker tracker_;
  CellDevices devices_;
  CampaignNeeds needs_;  ///< of the last campaign
};

}  // namespace truepose::daemon
