#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/json/value.hpp>
#include <expected>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/control/admission.hpp"
#include "daemon/control/caller.hpp"
#include "daemon/control/commands.hpp"
#include "daemon/control/connection.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/control/jobs.hpp"
#include "daemon/control/served.hpp"
#include "daemon/control/tls_identity.hpp"
#include "drivers/condition.hpp"
#include "proto/control/line_splitter.hpp"
#include "proto/control/request.hpp"
#include "proto/control/session_proof.hpp"
#include "proto/rpc/control.hpp"
#include "proto/rpc/events.hpp"
#include "proto/rpc/session.hpp"

namespace truepose::daemon {

class Session;

/// What the sessions of one server share.
struct SessionContext {
  ControlServerParts parts;
  ControlLimits limits;
  std::string cell_name;
  std::optional<TlsIdentity> tls;
  std::set<std::string, std::less<>> cell_methods;
  drivers::TimePoint started;
  std::string started_text;
  std::vector<Session*> sessions{};       ///< those that live, in the order in which they connected
  std::uint64_t last_number = 0;          ///< given to a session
  drivers::TimePoint next_tls_warning{};  ///< not before
  std::unique_ptr<Admission> admission{};
  std::unique_ptr<Commands> commands{};
  std::unique_ptr<Jobs> jobs{};
  std::uint64_t requests = 0;         ///< answered so far
  control::Dropped dropped_events{};  ///< that clients read too slowly for

  /// Reads the access file again where it has changed, and closes sessions that it no longer lets in.
  void refresh_access();
  /// Whether a session of his is open.
  bool is_connected(const Caller& who) const;
  /// Says why TLS with a peer did not come about; not more often than once in hello_window.
  void warn_of_tls(const std::string& peer, const std::string& why);
};

/// One connection: a coroutine that reads and answers, and one that writes replies and events.
class Session : public std::enable_shared_from_this<Session> {
 public:
  /// How far it has come.
  enum class Stage {
    Silent,  ///< nothing was asked yet
    Wrong,   ///< it has shown that it does not know the token, and waits for the refusal
    Right,   ///< it has shown that it knows the token, or needs none
    Open,
    Closing,
  };
  using Result = std::expected<boost::json::value, control::RpcError>;

  /// Methods of the server: those that sessions answer themselves, and commands.
  static const std::set<std::string, std::less<>>& own_methods();

  Session(std::unique_ptr<Connection> connection, Peer peer, std::shared_ptr<SessionContext> context);
  ~Session();

  Stage stage() const { return finishing_ ? Stage::Closing : stage_; }
  const std::string& peer() const { return peer_.name; }
  const Caller& caller() const { return caller_; }  ///< once it is open
  std::uint64_t number() const { return number_; }  ///< rises from connection to connection

  void start();
  /// Says why instead of serving, and closes.
  void refuse(control::RpcError error);
  /// Closes at once and cancels the call under way.
  void stop();
  /// Closes, with the reason, where its caller is no longer let in as what he is.
  void check_access();

 private:
  void spawn_writer();
  /// @return whether the connection has come about
  boost::asio::awaitable<bool> open();
  boost::asio::awaitable<void> read_requests();
  boost::asio::awaitable<void> discard_input();
  boost::asio::awaitable<void> write_lines();
  /// One read with a deadline. @return bytes read; 0 when the client or the time is gone
  boost::asio::awaitable<std::size_t> read_some(std::optional<drivers::TimePoint> deadline);
  /// Whether a method is for before the session is open.
  static bool opens_session(std::string_view method);
  static const std::vector<Served<Session>>& answered();
  /// One of those; null: sessions do not answer it themselves.
  static const Served<Session>* answered(std::string_view method);
  boost::asio::awaitable<void> serve(std::string line);
  boost::asio::awaitable<Result> call(control::Request request);

  /// Says who serves, before anything is asked.
  void greet();
  Reply<rpc::SessionChallenge> challenge(rpc::SessionChallenge);
  Reply<rpc::SessionHello> hello(rpc::SessionHello request);
  /// Whose hello it is.
  Admission::Known caller_of(const rpc::SessionHello& hello) const;
  /// Why the caller may not call the method.
  std::optional<control::RpcError> forbidden(const std::string& method) const;
  /// What stands in the way of one more session of this peer.
  std::optional<control::RpcError> no_room() const;
  bool authenticated() const { return stage_ == Stage::Open; }
  Reply<rpc::SystemInfo> system_info(rpc::SystemInfo);
  Reply<rpc::SessionPing> ping(rpc::SessionPing);
  /// Answers with the number under which the call continues.
  Result begin_job(control::Request request);
  Reply<rpc::JobGet> job(rpc::JobGet request);
  Reply<rpc::Discover> discover(rpc::Discover request);
  Reply<rpc::ControlGet> who_has_control(rpc::ControlGet);
  Reply<rpc::AuditList> audit_records(rpc::AuditList request);
  Reply<rpc::EventsSubscribe> subscribe(rpc::EventsSubscribe request);
  boost::asio::awaitable<StoreResult<std::vector<EventGap>>> gaps_behind(std::uint64_t last_seen);
  Reply<rpc::EventsUnsubscribe> unsubscribe(rpc::EventsUnsubscribe);

  std::optional<drivers::TimePoint> deadline() const;
  void see_events();
  boost::asio::awaitable<std::string> next_batch();
  boost::asio::awaitable<std::string> read_missed();
  void send(std::string line);
  /// Sends an error that belongs to no request, and closes once it is written.
  void dismiss(control::RpcError error);
  void close();

  std::unique_ptr<Connection> connection_;
  Peer peer_;
  std::optional<control::Certificate> certificate_{};  ///< that the client showed
  std::shared_ptr<SessionContext> context_;
  std::uint64_t number_;
  Stage stage_ = Stage::Silent;
  Caller caller_{};                ///< once the session is open
  control::SessionTerms terms_{};  ///< of a proof, once a nonce was asked for
  drivers::Condition wake_;        ///< when there is something to write
  drivers::Condition drained_;     ///< when something was written, and when the writer ended
  boost::asio::cancellation_signal cancel_;
  control::LineSplitter lines_;
  std::array<char, 4096> input_{};
  std::string outgoing_;  ///< replies not yet written
  std::unique_ptr<EventBus::Subscription> subscription_;
  std::uint64_t subscriptions_ = 0;  ///< that there were
  drivers::TimePoint connected_;
  drivers::TimePoint last_request_;
  std::optional<std::chrono::seconds> heartbeat_{};  ///< within which the client says that it is there
  std::optional<drivers::TimePoint> line_started_;
  bool finishing_ = false;  ///< write what is left, then close
  bool written_ = false;    ///< the writer has ended
};

}  // namespace truepose::daemon
