#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/json/value.hpp>
#include <expected>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/control/audit_trail.hpp"
#include "daemon/control/caller.hpp"
#include "daemon/control/command_memory.hpp"
#include "daemon/control/control_lease.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/control/served.hpp"
#include "proto/control/request.hpp"
#include "proto/rpc/control.hpp"

namespace truepose::daemon {

/// Carries out what changes anything (every method for which a viewer's role is too low): for who has control
/// or while nobody has it, once for each command_id, and on record: a command that cannot be written down is
/// not carried out. Those that take motion, a correction or control away (x-always in openrpc.json) need
/// neither control nor a record. Outlives the calls under way.
class Commands {
 public:
  using Result = std::expected<boost::json::value, control::RpcError>;

  /// What the server knows of its callers.
  struct Presence {
    std::function<bool(const Caller& who)> is_known;      ///< still let in as who he was
    std::function<bool(const Caller& who)> is_connected;  ///< by a session that is open
  };

  /// @param audit  none: nothing is kept on record
  Commands(ControlServerParts& parts, boost::asio::any_io_executor executor, std::optional<AuditTrail> audit,
           Presence presence);

  /// @param from  where the caller is
  boost::asio::awaitable<Result> carry_out(Caller caller, std::string from, control::Request request);
  /// Calls the cell. What it throws becomes an error, but for the end of the server.
  boost::asio::awaitable<Result> call_cell(std::string method, boost::json::object params, std::string by);

  /// Methods of the server that are commands.
  static std::vector<std::string_view> own_methods();
  rpc::Control who_has_control() const;
  Reply<rpc::AuditList> records(rpc::AuditList request);

  /// Writes what is pending into the audit trail, sees that its files are in their places, and whether
  /// control was lost: then the campaign under way is paused. Each command looks first.
  boost::asio::awaitable<void> look();
  /// Where the audit trail ends; none: none is kept. Once the worker has ended.
  std::optional<control::AuditHead> audit_end() const {
    return audit_ ? std::optional{audit_->end()} : std::nullopt;
  }
  /// Notes where the audit trail ends: in the store, and in the log.
  boost::asio::awaitable<void> bear_witness();
  /// A session was opened or has ended.
  void see_connections() { lease_.see_connections(parts_.clock.now(), presence_.is_connected); }
  /// When the control lease expires if it is not renewed.
  std::optional<drivers::TimePoint> control_ends() const { return lease_.end(); }

 private:
  struct Outcome {
    Result result;
    bool carried_out = false;
  };
  using Act = std::function<boost::asio::awaitable<Result>()>;
  /// What the audit trail knows of numbered commands of before a restart.
  void remember();
  /// @param id  that the caller gave the command; empty: none
  boost::asio::awaitable<Outcome> once(Caller caller, std::string from, control::Request request,
                                       std::string id = {});
  /// Acts, with a record before and one behind it.
  boost::asio::awaitable<Outcome> on_record(boost::json::object command, Act act);
  boost::asio::awaitable<Result> act(Caller caller, control::Request request);
  boost::asio::awaitable<Result> result_of(std::string method, boost::asio::awaitable<Result> call);
  Result change_control(const Caller& caller, const control::Request& request);
  Answer<rpc::ControlRelease> release(const Caller& caller, const boost::json::object& params);
  Answer<rpc::ControlAcquire> take(const Caller& caller, const control::Request& request);
  /// @param must_be  on the disk, else nothing of it is kept. @return the number of the record
  boost::asio::awaitable<std::expected<std::uint64_t, std::string>> write_down(boost::json::object record,
                                                                               bool must_be);
  void cannot_write(const std::string& why);
  /// What was found of the audit trail stands as a fault until it is acknowledged.
  void show_audit_fault(const std::string& fault);
  boost::asio::awaitable<Outcome> acknowledge_audit(boost::json::object command,
                                                    const control::Request& request);

  ControlServerParts& parts_;
  boost::asio::any_io_executor executor_;
  std::optional<AuditTrail> audit_;
  Presence presence_;
  bool has_pending_ = false;  ///< records to the audit trail
  std::string complaint_;  ///< why the trail could not be written when that was last said; empty: it can be
  ControlLease lease_;
  CommandMemory memory_;
};

}  // namespace truepose::daemon
