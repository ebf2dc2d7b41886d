#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/json/value.hpp>
#include <expected>
#include <optional>
#include <string>

#include "daemon/control/audit_trail.hpp"
#include "daemon/control/caller.hpp"
#include "daemon/control/command_memory.hpp"
#include "daemon/control/control_lease.hpp"
#include "daemon/control/control_server.hpp"
#include "proto/control/request.hpp"

namespace truepose::daemon {

/// Carries out what changes anything (every method for which a viewer's role is too low): for who has control
/// or while nobody has it, once for each command_id, and on record: a command that cannot be written down is
/// not carried out. Outlives the calls under way.
class Commands {
 public:
  using Result = std::expected<boost::json::value, control::RpcError>;

  /// @param audit  none: nothing is kept on record
  Commands(ControlServerParts& parts, boost::asio::any_io_executor executor, std::optional<AuditTrail> audit);

  /// @param from  where the caller is
  boost::asio::awaitable<Result> carry_out(Caller caller, std::string from, control::Request request);
  /// Calls the cell. What it throws becomes an error, but for the end of the server.
  boost::asio::awaitable<Result> call_cell(std::string method, boost::json::object params, std::string by);

  /// control.get and audit.list.
  Result who_has_control(const boost::json::object& params) const;
  boost::asio::awaitable<Result> records(boost::json::object params);

  /// Sees whether control was lost: then the campaign under way is paused.
  boost::asio::awaitable<void> look();

 private:
  struct Outcome {
    Result result;
    bool carried_out = false;
  };
  boost::asio::awaitable<Outcome> once(Caller caller, std::string from, control::Request request);
  boost::asio::awaitable<Result> act(Caller caller, control::Request request);
  Result change_control(const Caller& caller, const control::Request& request);
  /// @return the number of the record
  boost::asio::awaitable<std::expected<std::uint64_t, std::string>> write_down(boost::json::object record);
  void tell(const char* change, const std::string& by, boost::json::object more);

  ControlServerParts& parts_;
  boost::asio::any_io_executor executor_;
  std::optional<AuditTrail> audit_;
  ControlLease lease_;
  CommandMemory memory_;
};

}  // namespace truepose::daemon
