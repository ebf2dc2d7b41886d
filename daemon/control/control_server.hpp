#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/json/fwd.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/cell_config.hpp"
#include "daemon/control/caller.hpp"
#include "daemon/control/event_bus.hpp"
#include "daemon/fault_kinds.hpp"
#include "daemon/threads/worker.hpp"
#include "drivers/clock.hpp"
#include "drivers/net/network.hpp"
#include "drivers/start_failure.hpp"
#include "proto/control/audit_chain.hpp"
#include "proto/control/certificate.hpp"
#include "proto/control/request.hpp"
#include "proto/text/random_bytes.hpp"

namespace truepose::daemon {

class AuditWitness;
class Connection;
class TlsIdentity;
struct Peer;

/// What the control server serves: the cell's methods, as openrpc.json describes them.
class CellService {
 public:
  virtual ~CellService() = default;

  /// Every method that call() knows; the server answers "method not found" to others. session.hello,
  /// system.info, events.subscribe, events.unsubscribe and rpc.discover are the server's own.
  virtual std::vector<std::string> methods() const = 0;

  /// What the cell does, or waits for: one sentence, sent while a call takes long.
  virtual std::string doing() const { return {}; }

  /// A command cannot be put on record. One that takes motion, a correction or control away is carried out
  /// all the same.
  virtual void unrecorded(const std::string& /*why*/) {}

  /// A fault of the server's begins, or ends.
  virtual void stand(bool /*stands*/, const Fault& /*fault*/) {}

  /// Carries out one call, on the io thread. It may take long: other connections are served meanwhile, and
  /// calls of several connections overlap. A client that goes away does not cancel its call; the server's
  /// stop does (it then throws operation_aborted). Any other exception is answered as an internal error.
  /// @param by  the name of who calls, which events and campaigns carry
  virtual boost::asio::awaitable<std::expected<boost::json::value, control::RpcError>> call(
      std::string method, boost::json::object params, std::string by) = 0;

  /// Pauses what must not continue without a user in control; refused where there is nothing of that kind.
  /// @param why  one sentence, for the operator that finds it paused
  virtual boost::asio::awaitable<std::expected<boost::json::value, control::RpcError>> pause(
      std::string why, std::string by) = 0;
};

/// The address of control.listen. @return it, or why the control port cannot be there and what to do
std::expected<boost::asio::ip::address, std::string> control_address(const config::Endpoint& listen);
/// The same of control.tls.listen.
std::expected<boost::asio::ip::address, std::string> tls_address(const config::Endpoint& listen);

/// Reads the secret that clients must show. Nobody but its owner may write the file, and nobody but we
/// and our own primary group may read it (0600, or 0640 as root gives it to the service's group). What it
/// holds, control::token_in says. The error is one sentence.
std::expected<std::string, std::string> read_token(const std::filesystem::path& file);

/// What one client, or many, may take.
struct ControlLimits {
  std::size_t sessions = 32;     ///< open ones
  std::size_t of_one_peer = 24;  ///< of them; the rest is left to others
  std::size_t guests_of_peer =
      16;  ///< connections that have not opened a session: they take no session's place
  std::chrono::milliseconds hello{3'000};  ///< from connecting to session.hello
  std::chrono::milliseconds line{10'000};  ///< from a line's first byte to its last
  /// Without a request, unless events are subscribed to; a client may name another time at its hello.
  std::chrono::milliseconds idle{60'000};
  std::chrono::milliseconds write_stall{5'000};  ///< a client that takes nothing for so long is gone
  std::chrono::milliseconds farewell{2'000};     ///< to read the reason before the connection is torn down
  std::size_t hello_failures = 5;  ///< wrong tokens of one peer within hello_window; then it is answered late
  std::chrono::milliseconds hello_window{60'000};
  std::chrono::milliseconds hello_delay{1'000};  ///< by so much, also where the token is right
  std::chrono::milliseconds look{1'000};  ///< from one look at the files of access and audit to the next
  std::chrono::milliseconds witness{3'600'000};  ///< from one note of where the audit trail ends to the next
};

/// What the server works with. All of it outlives the server and the event loop that it runs on.
struct ControlServerParts {
  drivers::Clock& clock;
  drivers::WallClock wall_clock;
  CellService& cell;
  EventBus& events;
  std::function<void(const std::string&)> warn;  ///< logs one sentence
  Worker& worker;                   ///< writes the audit trail, and reads the events that are kept
  std::filesystem::path socket{};   ///< Unix socket for clients of this machine; empty: none
  std::filesystem::path access{};   ///< access file; empty: the token's holders alone
  std::filesystem::path audit{};    ///< audit trail; empty: nothing is kept on record
  AuditWitness* witness = nullptr;  ///< knows where the trail ends, in the worker's thread; null: none
  std::function<void(const std::string&)> note = [](const std::string&) {};  ///< logs what is no warning
  net::Network network{};                                                    ///< where it listens
  RandomBytes random = kernel_random;  ///< of nonces and of the numbers of jobs
};

/// How much the server has to do.
struct ControlLoad {
  std::size_t connections = 0;        ///< with those that have not opened a session
  std::size_t sessions = 0;           ///< open ones
  std::uint64_t requests = 0;         ///< answered so far
  control::Dropped dropped_events{};  ///< that clients read too slowly for
};

/// Serves the control protocol (proto/control/openrpc.json) to HMIs and the command line: over TCP to this
/// machine, over TLS 1.3 to any other, and over a Unix socket. Whoever may write to that one (our own user,
/// our group and root) needs no token, nor does over TLS whose certificate is in the access file.
///
/// Requests of one connection are answered in order; connections do not wait for each other. Runs on one
/// thread: the executor's.
class ControlServer {
 public:
  /// Binds and listens: who connects waits for serve(). Fails with one sentence: an address in the clear that
  /// is not loopback, a port in use (and by whom), a token file that is missing, readable by others or too
  /// short, a certificate or key that cannot be used.
  static std::expected<std::unique_ptr<ControlServer>, drivers::StartFailure> start(
      boost::asio::any_io_executor executor, ControlServerParts parts, const config::ControlConfig& config,
      std::string cell_name, ControlLimits limits = {});
  ~ControlServer();

  /// Starts to accept, once the cell can answer.
  void serve();
  std::uint16_t port() const;
  std::optional<std::uint16_t> tls_port() const;
  /// Methods that are answered, the server's own included, sorted. rpc.discover is not in the schema, which
  /// it returns in outline, and with {"method": NAME} of one method in full.
  std::vector<std::string> methods() const;
  /// Where the audit trail ends; none: none is kept. Once the worker has ended.
  std::optional<control::AuditHead> audit_end() const;
  /// The server's load, for monitoring.
  ControlLoad load() const;

  // For those that let clients in by other ports.

  /// Serves a client that has come by another way than the server's own ports, as if by one of these.
  void admit(std::unique_ptr<Connection> connection, Peer peer);
  /// Who shows this token, or else this certificate, as session.hello would have it; or why he is nobody.
  boost::asio::awaitable<std::expected<Caller, std::string>> caller_of(
      std::string peer, std::string token, std::optional<control::Certificate> shown);
  /// By what clients over TLS know the daemon; null: it has nothing to show.
  const TlsIdentity* tls_identity() const;

  /// Accepts no more, closes every connection and cancels the calls under way. They end within the loop's
  /// next turns.
  void stop();

 private:
  struct Impl;
  explicit ControlServer(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

}  // namespace truepose::daemon
