#include "daemon/control/control_server.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/cancellation_signal.hpp>
#include <optional>
#include <utility>

#include "daemon/control/acceptor.hpp"
#include "daemon/control/admission.hpp"
#include "daemon/control/connection.hpp"
#include "daemon/control/jobs.hpp"
#include "daemon/control/private_file.hpp"
#include "daemon/control/session.hpp"
#include "daemon/store/audit_witness.hpp"
#include "drivers/net/spawn.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::ErrorCode;
using drivers::StartFailure;

struct ControlServer::Impl {
  std::shared_ptr<SessionContext> context;
  std::shared_ptr<net::Listener> listener;
  std::shared_ptr<net::Listener> local_listener;  ///< null: none
  std::shared_ptr<net::Listener> tls_listener;    ///< null: none
  asio::cancellation_signal stop_looking{};
  drivers::TimePoint next_expiry_warning{};
  drivers::TimePoint next_witness{};

  void admit(std::unique_ptr<Connection> connection, Peer peer);
  bool make_room(const Peer& peer);
  /// Polls what may change without a request. Ends when cancelled.
  asio::awaitable<void> look_after();
  void look_at_certificate();
};

namespace {

/// Replaces the socket of the previous daemon: the caller has exclusive use of the folder.
std::expected<std::shared_ptr<net::Listener>, StartFailure> listen(const net::Network& network,
                                                                   const asio::any_io_executor& executor,
                                                                   const std::filesystem::path& path) {
  constexpr unsigned kMode = 0660;
  const auto failed = [&](const std::string& why) {
    return std::unexpected(StartFailure{"control socket " + path.string() + ": " + why});
  };
  if (path.native().size() >= sizeof(sockaddr_un::sun_path))
    return failed("the path is too long for a socket; name a shorter one with the cell file's key runtime");
  ::unlink(path.c_str());
  auto listener = network.listen_local(executor, path, kMode);
  if (!listener) return failed(listener.error().message());
  return *std::move(listener);
}

/// A client that could connect is root, our own user or of our group: the socket's mode excludes all others.
Peer peer_of_local(const net::Stream& stream) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (::getsockopt(stream.handle(), SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0)
    return {"unknown user", {}, false};
  return {control::kLocalUserStart + std::to_string(credentials.uid), {}, true};
}

}  // namespace

/// Closes the guest of this peer that has waited longest: a silent one, else one that was wrong.
/// @return false where each has shown that it knows the token
bool ControlServer::Impl::make_room(const Peer& peer) {
  std::size_t guests = 0;
  Session* out = nullptr;
  for (Session* session : context->sessions) {
    const Session::Stage stage = session->stage();
    if (session->peer() != peer.name || stage == Session::Stage::Open || stage == Session::Stage::Closing)
      continue;
    ++guests;
    if (stage == Session::Stage::Right) continue;
    const auto rank = [](const Session& of) {
      return std::pair{of.stage() == Session::Stage::Wrong, of.number()};
    };
    if (!out || rank(*session) < rank(*out)) out = session;
  }
  if (guests < context->limits.guests_of_peer) return true;
  if (out) out->shared_from_this()->stop();
  return out != nullptr;
}

void ControlServer::Impl::admit(std::unique_ptr<Connection> connection, Peer peer) {
  const ControlLimits& limits = context->limits;
  // Sessions that are being closed stay for a moment, to send the reason. Their number is limited, first for
  // each peer, then for all.
  const auto unopened = std::ranges::count_if(context->sessions, [&](const Session* session) {
    return session->peer() == peer.name && session->stage() != Session::Stage::Open;
  });
  if (static_cast<std::size_t>(unopened) >= 2 * limits.guests_of_peer) return;
  if (context->sessions.size() >= limits.sessions + 4 * limits.guests_of_peer) return;
  const bool room = make_room(peer);
  const auto session = std::make_shared<Session>(std::move(connection), std::move(peer), context);
  if (room) return session->start();
  session->refuse({ErrorCode::Busy, "closed: too many are opening a session; try again"});
}

asio::awaitable<void> ControlServer::Impl::look_after() {
  while (true) {
    // Control is taken for longer than from one look to the next, so each end of it is known at a look
    // before.
    drivers::TimePoint next = context->parts.clock.now() + context->limits.look;
    if (const auto end = context->commands->control_ends()) next = std::min(next, *end);
    co_await context->parts.clock.sleep_until(next);
    context->refresh_access();
    look_at_certificate();
    co_await context->commands->look();
    if (context->parts.clock.now() < next_witness) continue;
    next_witness = context->parts.clock.now() + context->limits.witness;
    co_await context->commands->bear_witness();
  }
}

void ControlServer::Impl::look_at_certificate() {
  constexpr std::chrono::days kNotice{30}, kAgain{1};
  if (!context->tls) return;
  const auto changed = context->tls->refresh();
  if (!changed) context->parts.warn(changed.error());
  const bool is_new = changed.value_or(false);
  const drivers::TimePoint now = context->parts.clock.now();
  if (!is_new && now < next_expiry_warning) return;
  const control::Certificate& ours = context->tls->certificate();
  if (context->parts.wall_clock() + kNotice < ours.until) return;
  next_expiry_warning = now + kAgain;
  const char* const ends = context->parts.wall_clock() > ours.until ? "expired on " : "ends on ";
  context->parts.warn("control.tls: the daemon's certificate " + std::string{ends} +
                      control::rfc3339(ours.until) +
                      "; put a new one in its place, it is taken without a restart");
}

namespace {

/// The audit trail, where one is kept.
std::expected<std::optional<AuditTrail>, StartFailure> open_audit(const ControlServerParts& parts) {
  if (parts.audit.empty()) return std::nullopt;
  std::vector<control::AuditHead> known;
  if (parts.witness) {
    auto heads = parts.witness->audit_heads();
    if (!heads) return std::unexpected(StartFailure{heads.error().detail, heads.error().may_pass});
    known = *std::move(heads);
  }
  auto opened = AuditTrail::open(parts.audit, control::rfc3339(parts.wall_clock()), known);
  if (!opened) return std::unexpected(opened.error());
  return *std::move(opened);
}

}  // namespace

std::expected<std::unique_ptr<ControlServer>, StartFailure> ControlServer::start(
    asio::any_io_executor executor, ControlServerParts parts, const config::ControlConfig& config,
    std::string cell_name, ControlLimits limits) {
  auto token = read_token(config.token_file);
  if (!token) return std::unexpected(token.error());
  AccessList access{parts.access};
  auto audit = open_audit(parts);
  if (!audit) return std::unexpected(audit.error());
  auto listener =
      listen(parts.network, executor, "control.listen", config.listen, control_address(config.listen));
  if (!listener) return std::unexpected(listener.error());
  std::optional<TlsIdentity> tls;
  std::shared_ptr<net::Listener> tls_listener;
  if (config.tls) {
    auto identity = TlsIdentity::load(*config.tls);
    if (!identity) return std::unexpected(identity.error());
    tls = *std::move(identity);
    auto listening = listen(parts.network, executor, "control.tls.listen", config.tls->listen,
                            tls_address(config.tls->listen));
    if (!listening) return std::unexpected(listening.error());
    tls_listener = *std::move(listening);
  }
  std::shared_ptr<net::Listener> local_listener;
  if (!parts.socket.empty()) {
    auto listening = listen(parts.network, executor, parts.socket);
    if (!listening) return std::unexpected(listening.error());
    local_listener = *std::move(listening);
  }

  auto context = std::make_shared<SessionContext>(
      SessionContext{std::move(parts), limits, std::move(cell_name), std::move(tls), {}, {}, {}});
  for (std::string& method : context->parts.cell.methods()) context->cell_methods.insert(std::move(method));
  context->admission =
      std::make_unique<Admission>(context->parts, limits, *std::move(token), std::move(access));
  context->jobs = std::make_unique<Jobs>(context->parts, executor);
  context->commands = std::make_unique<Commands>(
      context->parts, executor, *std::move(audit),
      Commands::Presence{
          .is_known = [&shared = *context](const Caller& who) { return shared.admission->still_known(who); },
          .is_connected = [&shared = *context](const Caller& who) { return shared.is_connected(who); }});
  context->refresh_access();
  context->started = context->parts.clock.now();
  context->started_text = control::rfc3339(context->parts.wall_clock());
  auto impl = std::make_shared<Impl>(std::move(context), *std::move(listener), std::move(local_listener),
                                     std::move(tls_listener));
  impl->look_at_certificate();

  const auto ended = [impl](std::exception_ptr) {};
  net::spawn(executor, impl->look_after(), ended, impl->stop_looking.slot());
  return std::unique_ptr<ControlServer>{new ControlServer{std::move(impl)}};
}

void ControlServer::serve() {
  const auto accept = [this](net::Listener* from, auto admit) {
    if (!from) return;
    accept_who_stays({impl_, from}, impl_->context->parts.warn, "control",
                     [admit, server = impl_.get()](std::unique_ptr<net::Stream> stream) {
                       admit(*server, std::move(stream));
                     });
  };
  accept(impl_->listener.get(), [](Impl& server, std::unique_ptr<net::Stream> stream) {
    Peer peer = Peer::of(*stream);
    server.admit(plain_connection(std::move(stream)), std::move(peer));
  });
  accept(impl_->local_listener.get(), [](Impl& server, std::unique_ptr<net::Stream> stream) {
    Peer peer = peer_of_local(*stream);
    server.admit(plain_connection(std::move(stream)), std::move(peer));
  });
  accept(impl_->tls_listener.get(), [](Impl& server, std::unique_ptr<net::Stream> stream) {
    Peer peer = Peer::of(*stream);
    server.admit(tls_connection(std::move(stream), server.context->tls->context()), std::move(peer));
  });
}

std::expected<asio::ip::address, std::string> control_address(const config::Endpoint& listen) {
  boost::system::error_code error;
  const auto address = asio::ip::make_address(listen.host == "localhost" ? "127.0.0.1" : listen.host, error);
  if (error)
    return std::unexpected("control.listen: \"" + listen.host +
                           "\" is not an IP address: give 127.0.0.1 or ::1");
  if (!address.is_loopback())
    return std::unexpected(
        "control.listen: " + listen.host +
        " can be reached from other machines, which needs TLS: listen on 127.0.0.1 here, and for "
        "others by control.tls");
  return address;
}

std::expected<asio::ip::address, std::string> tls_address(const config::Endpoint& listen) {
  boost::system::error_code error;
  const auto address = asio::ip::make_address(listen.host, error);
  if (error)
    return std::unexpected("control.tls.listen: \"" + listen.host +
                           "\" is not an IP address: give one of this machine, or 0.0.0.0 for all");
  return address;
}

std::expected<std::string, std::string> read_token(const std::filesystem::path& file) {
  constexpr std::size_t kMostBytes = 2048;
  const auto bad = [&](const std::string& why) {
    return std::unexpected("token file " + file.string() + ": " + why);
  };
  const auto text = read_private_file(file, kMostBytes);
  std::error_code unknown;
  if (!text && !std::filesystem::exists(file, unknown) && !unknown)
    return bad("does not exist; make one with: (umask 077; openssl rand -hex 16 > " + file.string() + ")");
  if (!text) return bad(text.error());
  auto token = control::token_in(*text);
  if (!token) return bad(token.error());
  return token;
}

ControlServer::ControlServer(std::shared_ptr<Impl> impl) : impl_{std::move(impl)} {}

ControlServer::~ControlServer() { stop(); }

std::uint16_t ControlServer::port() const { return impl_->listener->local().port; }

std::optional<std::uint16_t> ControlServer::tls_port() const {
  if (!impl_->tls_listener) return std::nullopt;
  return impl_->tls_listener->local().port;
}

std::vector<std::string> ControlServer::methods() const {
  std::set<std::string, std::less<>> all = Session::own_methods();
  all.insert(impl_->context->cell_methods.begin(), impl_->context->cell_methods.end());
  return {all.begin(), all.end()};
}

std::optional<control::AuditHead> ControlServer::audit_end() const {
  return impl_->context->commands->audit_end();
}

ControlLoad ControlServer::load() const {
  const SessionContext& context = *impl_->context;
  const auto open = std::ranges::count(context.sessions, Session::Stage::Open, &Session::stage);
  return {context.sessions.size(), static_cast<std::size_t>(open), context.requests, context.dropped_events};
}

void ControlServer::admit(std::unique_ptr<Connection> connection, Peer peer) {
  impl_->admit(std::move(connection), std::move(peer));
}

asio::awaitable<std::expected<Caller, std::string>> ControlServer::caller_of(
    std::string peer, std::string token, std::optional<control::Certificate> shown) {
  const std::shared_ptr<SessionContext> context = impl_->context;
  context->refresh_access();
  Admission& admission = *context->admission;
  Admission::Known attempt =
      shown && token.empty() ? admission.by_certificate(*shown) : admission.by_token(token);
  auto caller = co_await admission.judge(std::move(peer), std::move(attempt));
  co_return caller;
}

const TlsIdentity* ControlServer::tls_identity() const {
  return impl_->context->tls ? &*impl_->context->tls : nullptr;
}

void ControlServer::stop() {
  impl_->listener->close();
  if (impl_->tls_listener) impl_->tls_listener->close();
  impl_->stop_looking.emit(asio::cancellation_type::terminal);
  if (impl_->local_listener && impl_->local_listener->is_open()) {
    impl_->local_listener->close();
    ::unlink(impl_->context->parts.socket.c_str());
  }
  const std::vector<Session*> sessions = impl_->context->sessions;
  for (Session* session : sessions) session->shared_from_this()->stop();
  impl_->context->jobs->stop();
}

}  // namespace truepose::daemon
