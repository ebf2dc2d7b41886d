#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <expected>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/campaign/cell_devices.hpp"
#include "daemon/cell/cell_runner.hpp"
#include "daemon/cell/service.hpp"

namespace truepose::daemon {

/// Robot and tracker as the cell's state has them: connects and closes them, and asks while nobody else does
/// whether they are still there.
class DeviceService {
 public:
  /// @param status  of the whole cell, which the methods answer with
  DeviceService(const CellParts& parts, CellRunner& runner, std::function<boost::json::object()> status);

  static std::vector<Method<DeviceService>> methods();

  /// Looks after the devices. Ends when cancelled.
  boost::asio::awaitable<void> watch();
  /// Calls to a device come one at a time: returns when watch() asks none.
  boost::asio::awaitable<void> unasked();
  /// Brakes the arm, and leaves the program that it is in.
  boost::asio::awaitable<void> stop_robot() { return devices_.stop(); }
  void disconnect() { devices_.disconnect(); }

  /// What the controller has told of itself lately, or why that is not known.
  std::expected<drivers::RobotState, std::string> robot_state() const;
  /// Of the devices that are connected.
  const std::optional<Identities>& identities() const { return identities_; }
  void know(const Identities& identities) { identities_ = identities; }
  boost::json::object robot_json() const;
  boost::json::object tracker_json() const;

 private:
  MethodReply config(boost::json::object params);
  MethodReply status(boost::json::object params);
  MethodReply connect(boost::json::object params);
  MethodReply disconnect(boost::json::object params);
  MethodReply acknowledge(boost::json::object params);

  MethodResult request(const boost::json::object& params, const CellEvent& event, const std::string& reason);
  void close();
  bool may_be_asked() const { return runner_.in<Ready>() || runner_.in<Streaming>(); }
  void take(drivers::RobotState state);
  boost::asio::awaitable<void> ask_robot();
  boost::asio::awaitable<void> look_at_robot();
  boost::asio::awaitable<void> ask_tracker();

  CellParts parts_;
  CellRunner& runner_;
  std::function<boost::json::object()> status_;
  CellDevices devices_;
  std::optional<Identities> identities_;
  std::optional<drivers::RobotState> robot_state_;
  TimePoint robot_told_{};      ///< when it was
  std::string robot_not_told_;  ///< why it was not, when it was asked last
  bool asked_ = false;          ///< a question of watch() is under way
  Signal answered_;
};

}  // namespace truepose::daemon
