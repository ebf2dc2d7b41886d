#include "daemon/daemon.hpp"

#include <boost/asio/cancellation_signal.hpp>
#include <expected>
#include <type_traits>
#include <utility>

#include "daemon/cell/daemon_cell.hpp"
#include "daemon/cell_tracker.hpp"
#include "daemon/control/access_list.hpp"
#include "daemon/control/audit_trail.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/control/event_keeper.hpp"
#include "daemon/log/log.hpp"
#include "daemon/realtime/stream_options.hpp"
#include "daemon/recorder/recorded_stream.hpp"
#include "daemon/recorder/recorder.hpp"
#include "daemon/service/service_manager.hpp"
#include "daemon/store/campaign_plan.hpp"
#include "daemon/store/correction_mark.hpp"
#include "daemon/store/runtime_folder.hpp"
#include "daemon/threads/signal.hpp"
#include "daemon/web/daemon_metrics.hpp"
#include "daemon/web/web_server.hpp"
#include "drivers/clock.hpp"
#include "drivers/kuka/eki_robot.hpp"
#include "drivers/kuka/rsi_link.hpp"
#include "drivers/net/spawn.hpp"
#include "proto/control/json_text.hpp"
#include "proto/rpc/events.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kEventNumbers = 100'000;

constexpr std::chrono::milliseconds kRsiPatience{2'000};  // its thread wakes every 30 ms
// A disk may take seconds for one commit, and one step of a large fit seconds on a busy PC.
constexpr std::chrono::milliseconds kWorkPatience{30'000};
constexpr std::chrono::milliseconds kLookAtThreads{500};  // where no service manager watches

/// The value, or the end of the start.
template <typename T>
T started(std::expected<T, std::string> result) {
  if (!result) throw StartError{result.error()};
  return *std::move(result);
}

template <typename T>
T started(std::expected<T, drivers::StartFailure> result) {
  if (!result) throw StartError{result.error().text, result.error().may_pass};
  return *std::move(result);
}

template <typename T>
T kept(StoreResult<T> result) {
  if (!result) throw StartError{"store: " + result.error().detail, result.error().may_pass};
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

/// The controller's address.
std::uint32_t rsi_peer(const config::RobotConfig& robot) {
  const auto peer = drivers::ipv4_of(robot.rsi_peer);
  // A name may be known only once the network is.
  if (!peer) throw StartError{"robot.rsi_peer: " + peer.error(), true};
  return *peer;
}

StreamOptions stream_options(const config::CellConfig& config, std::uint32_t peer, drivers::TimePoint now) {
  StreamOptions options = StreamOptions::of(config);
  options.peer = peer;
  options.listening_since = now;
  options.never_corrected = !may_have_corrected(config.store);
  return options;
}

/// What the process before this one knew of the controller, where there is a folder for it.
std::unique_ptr<StreamMemory> stream_memory(const fs::path& runtime) {
  if (runtime.empty()) return StreamMemory::in_process();
  return started(StreamMemory::open(runtime / "stream"));
}

drivers::RsiLinkOptions link_options(const config::StreamConfig& stream, std::uint32_t peer) {
  const bool off = stream.realtime == config::RealtimePolicy::Off;
  return {stream.listen.host,
          stream.listen.port,
          off ? 0 : stream.priority,
          stream.realtime == config::RealtimePolicy::Require,
          stream.cpu,
          peer};
}

/// The ring that is recorded into. A disk that has no room for it is no reason to let the arm stand.
std::unique_ptr<Ring> recording_ring(const config::RecordingConfig& config,
                                     std::chrono::system_clock::time_point now) {
  const RecordingFolder folder{config};
  const auto left = save_left_behind(folder, control::rfc3339(now));
  if (!left) log_warning("what the daemon before this one recorded is lost: " + left.error());
  if (left && !left->empty())
    log_warning("the daemon before this one was killed; what it had recorded is in " + left->string());
  const std::size_t bytes = config.ring_mb << 20U;
  auto ring = Ring::create(folder.ring(), bytes);
  if (ring) return *std::move(ring);
  log_warning(ring.error() + "; it is kept in memory");
  return Ring::in_process(bytes);
}

/// UTC of the clock's 0, ns since 1970.
std::int64_t clock_origin_ns(const Machine& machine) {
  const auto utc = machine.wall_clock().time_since_epoch();
  return std::chrono::nanoseconds{utc}.count() - drivers::nanoseconds_of(machine.clock.now());
}

recording::Endpoint listens_at(const config::StreamConfig& stream) {
  return recording::read_endpoint(stream.listen.host + ':' + std::to_string(stream.listen.port))
      .value_or(recording::Endpoint{});
}

/// Everything that runs, in the order in which it is started; taken down in the reverse order.
class CellDaemon final : public Daemon {
 public:
  CellDaemon(Machine machine, const config::CellConfig& config, const fs::path& runtime)
      : machine_{std::move(machine)},
        config_{config},
        store_lock_{
            started(LockFile::take(lock_of_store(config.store), "the store " + config.store.string()))},
        runtime_lock_{lock_of_runtime(runtime)},
        recording_lock_{lock_of_recordings(config.recording.folder)},
        store_{kept(Store::open(config.store))},
        events_{event_numbers(), machine_.wall_clock, &store_},
        peer_{rsi_peer(config.robot)},
        stream_memory_{stream_memory(runtime)},
        stream_{started(
            StreamCycle::create(config.robot.model, started(read_ethernet(config.stream.ethernet_xml)),
                                stream_options(config, peer_, machine_.clock.now()), stream_memory_.get()))},
        recorder_{recording_ring(config.recording, machine_.wall_clock()), machine_.clock,
                  clock_origin_ns(machine_), listens_at(config.stream)},
        recorded_stream_{*stream_, *stream_memory_, recorder_.exchanges()},
        robot_{machine_.io,
               machine_.clock,
               {config.robot.eki_motion.host, config.robot.eki_motion.port, config.robot.eki_state.port,
                config.robot.model.joint_count(), recorder_.tap(recording::Wire::EkiLink),
                recorder_.tap(recording::Wire::EkiState), machine_.network.stream, machine_.random}},
        tracker_{cell_tracker(config.tracker, machine_.io, machine_.clock,
                              recorder_.tap(recording::Wire::Tracker), machine_.network.stream)},
        cell_{{machine_.io, config_, robot_, *tracker_, machine_.clock, *stream_, store_,
               machine_.store_thread, machine_.compute_thread, events_, recorder_, machine_.recorder_thread,
               machine_.wall_clock, [this] { return link_->scheduling(); }, machine_.random}},
        link_{started(machine_.start_rsi_link(link_options(config.stream, peer_), recorded_stream_))},
        server_{started(ControlServer::start(
            machine_.io,
            {machine_.clock, machine_.wall_clock, cell_, events_,
             [](const std::string& sentence) { log_warning(sentence); }, machine_.store_thread,
             runtime.empty() ? fs::path{} : runtime / "control.sock", access_file_of(config.store),
             audit_file_of(config.store), &store_, [](const std::string& sentence) { log_info(sentence); },
             machine_.network, machine_.random},
            config.control, config.name))} {
    web_ = start_web();
    read_log([this](LogLevel level, std::string_view line) {
      events_.publish(rpc::LogLine{.level = std::string{name(level)}, .text = std::string{line}},
                      level == LogLevel::Info ? Keep::Passing : Keep::Lasting);
    });
  }
  ~CellDaemon() override {
    read_log({});
    join_workers();  // their jobs use the store and the recorder
  }

  asio::awaitable<void> live(asio::awaitable<void> end) override {
    // Only now that the ports are ours: a second daemon by mistake must not end the campaign of the first.
    kept(store_.plans().interrupt_running(control::rfc3339(machine_.wall_clock())));
    co_await load();
    // Only after the store is loaded: a waiting client would see a cell without a model.
    server_->serve();
    if (web_) web_->serve();
    bool watching = true;
    Signal watch_ended;
    const auto watched = [&](std::exception_ptr failed) {
      watching = false;
      watch_ended.notify();
      if (!stopping_) net::rethrow(failed);
    };
    net::spawn(machine_.io, cell_.watch(), watched, stop_watch_.slot());
    const std::string status = listening();
    log_info("ready: " + status);
    if (!link_->refused().empty()) log_warning("RSI thread: " + link_->refused());
    notify_ready(status);
    net::spawn(machine_.io, feed_watchdog(), {}, stop_feeding_.slot());
    net::spawn(machine_.io, keeper_.run(), {}, stop_keeping_.slot());

    co_await std::move(end);
    co_await stop();
    while (watching) co_await watch_ended.wait();
    link_.reset();
  }

  void settle() override {
    join_workers();
    keep_last_events();
    keep_audit_end();
    remove_ring(RecordingFolder{config_.recording});
  }

 private:
  /// Where the cell file names the port, it must be had; the usual one another program may have.
  std::unique_ptr<WebServer> start_web() {
    const config::WebConfig web = config_.web.value_or(config::WebConfig{});
    if (!web.listen) return nullptr;
    auto server =
        WebServer::start(machine_.io,
                         {machine_.clock, *server_, [this] { return health(); }, [this] { return metrics(); },
                          [](const std::string& sentence) { log_warning(sentence); }, machine_.network},
                         web);
    if (config_.web) return started(std::move(server));
    if (server) return *std::move(server);
    log_warning("no dashboard: " + server.error().text +
                "; choose a port by web.listen in the cell file, or off");
    return nullptr;
  }

  /// By what the watchdog sees. The io thread shows itself by answering.
  Health health() {
    Health health{.status = "ok", .threads = {}};
    for (const Watchdog::Seen& thread : watchdog_.look(machine_.clock.now())) {
      const auto still_for = std::chrono::duration_cast<std::chrono::milliseconds>(thread.still_for);
      const char* const state = thread.stuck ? "stuck" : thread.idle ? "idle" : "running";
      health.threads.emplace_back(thread.name, ThreadHealth{state, still_for});
      if (thread.stuck) health.status = "stuck";
    }
    if (stopping_) health.status = "stopping";
    return health;
  }

  std::string metrics() {
    std::size_t store_bytes = 0;
    for (const char* const behind : {"", "-wal"}) {
      std::error_code none;
      const auto bytes = fs::file_size(config_.store.string() + behind, none);
      if (!none) store_bytes += bytes;
    }
    return metrics_text({.cell = config_.name,
                         .snapshot = cell_.snapshot(),
                         .stream = *stream_,
                         .control = server_->load(),
                         .web_connections = web_ ? web_->connections() : 0,
                         .events = events_.next_seq(),
                         .store_bytes = store_bytes,
                         .store_jobs = machine_.store_thread.pulse().beats,
                         .store_waiting = machine_.store_thread.waiting(),
                         .uptime = machine_.clock.now() - begun_,
                         .now = machine_.clock.now()});
  }

  static std::optional<LockFile> lock_of_runtime(const fs::path& folder) {
    if (folder.empty()) return std::nullopt;
    return started(LockFile::take(folder / "lock", "the runtime folder " + folder.string()));
  }

  /// Where no file can be made there is none to share either.
  static std::optional<LockFile> lock_of_recordings(const fs::path& folder) {
    std::error_code failed;
    fs::create_directories(folder, failed);  // what is wrong is said where the ring is made
    auto lock = LockFile::take(folder / "lock", "the recordings folder " + folder.string());
    if (!lock && fs::exists(folder / "lock", failed))
      throw StartError{lock.error().text, lock.error().may_pass};
    return lock ? std::optional{*std::move(lock)} : std::nullopt;
  }

  EventNumbers event_numbers() {
    const std::uint64_t first = kept(store_.begin_events(kEventNumbers));
    return {first, first + kEventNumbers, [this] { ask_for_numbers(); }};
  }

  /// Nothing else uses the store any more.
  void keep_last_events() {
    const EventBatch all = events_.unwritten(EventBus::kMostUnwritten);
    const auto kept = store_.end_events(all);
    if (!kept) log_error("store: " + kept.error().detail);
  }

  void keep_audit_end() {
    const auto end = server_->audit_end();
    if (!end) return;
    const auto kept = store_.keep_audit_head(*end);
    if (!kept) log_error("store: " + kept.error().detail);
    log_info("audit trail: " + std::to_string(end->count) + " records, head " + end->hash);
  }

  void ask_for_numbers() { net::spawn(machine_.io, reserve_numbers(), net::rethrow); }
  asio::awaitable<void> reserve_numbers() {
    auto job = [this] { return store_.reserve_event_numbers(kEventNumbers); };
    auto first = co_await machine_.store_thread.ask(job);
    if (first) events_.extend(*first + kEventNumbers);
    if (!first) log_error("store: " + first.error().detail);
  }

  /// The cell takes from its store what was in effect when the daemon ended.
  asio::awaitable<void> load() {
    auto tools = co_await cell_.load_tools();
    if (!tools) log_error("the tools in use cannot be read: " + tools.error().detail);
    auto loaded = co_await cell_.load_active_model();
    if (!loaded) log_error("the active model cannot be used: " + loaded.error().detail);
    auto interrupted = co_await cell_.load_interrupted_campaigns();
    if (!interrupted) log_error("interrupted campaigns cannot be read: " + interrupted.error().detail);
    co_await cell_.arm_as_before();
  }

  /// "control port 7401, web port 7402, RSI port 49152, RSI thread .."
  std::string listening() const {
    const auto tls_port = server_->tls_port();
    return "control port " + std::to_string(server_->port()) +
           (tls_port ? ", TLS port " + std::to_string(*tls_port) : "") +
           (web_ ? ", web port " + std::to_string(web_->port()) : "") + ", RSI port " +
           std::to_string(link_->port()) + ", RSI thread " + drivers::describe(link_->scheduling());
  }

  asio::awaitable<void> stop() {
    stopping_ = true;
    notify_stopping();
    log_info("stopping");
    co_await cell_.shut_down();
    if (web_) web_->stop();
    server_->stop();
    stop_watch_.emit(asio::cancellation_type::terminal);
    stop_feeding_.emit(asio::cancellation_type::terminal);
    stop_keeping_.emit(asio::cancellation_type::terminal);
  }

  /// Tells the service manager that all is well while every thread advances. Done by the io thread, which so
  /// shows itself.
  asio::awaitable<void> feed_watchdog() {
    const auto period = watchdog_period();
    const std::chrono::microseconds pause = period ? *period / 4 : kLookAtThreads;
    bool reported = false;
    while (true) {
      const auto stuck = watchdog_.stuck(machine_.clock.now());
      if (!stuck && period)
        notify_watchdog();  // unasked it would fill the socket of a manager that does not read
      if (stuck && !reported)
        log_error("the " + *stuck + " thread stands still" +
                  (period ? "; unless it continues, systemd restarts the service" : ""));
      reported = stuck.has_value();
      const drivers::TimePoint next = machine_.clock.now() + pause;
      co_await machine_.clock.sleep_until(next);
    }
  }

  void join_workers() {
    for (Worker* const worker : {&machine_.compute_thread, &machine_.store_thread, &machine_.recorder_thread})
      worker->join();
  }

  const Machine machine_;
  const config::CellConfig& config_;
  LockFile store_lock_;
  std::optional<LockFile> runtime_lock_;
  std::optional<LockFile> recording_lock_;
  Store store_;
  EventBus events_;
  std::uint32_t peer_;
  std::unique_ptr<StreamMemory> stream_memory_;
  std::unique_ptr<StreamCycle> stream_;
  Recorder recorder_;
  RecordedStream recorded_stream_;
  drivers::KukaEkiRobot robot_;
  std::unique_ptr<drivers::TimedTracker> tracker_;
  DaemonCell cell_;
  EventKeeper keeper_{{events_, machine_.store_thread, machine_.clock, machine_.wall_clock,
                       [this](const StoreError& error) { cell_.store_failed(error); }}};
  std::unique_ptr<drivers::RsiLink> link_;
  std::unique_ptr<ControlServer> server_;
  drivers::TimePoint begun_ = machine_.clock.now();
  Watchdog watchdog_{{{"RSI", kRsiPatience,
                       [this] {
                         return link_ ? Pulse{link_->heartbeats(), false} : Pulse{.idle = true};
                       }},
                      {"store", kWorkPatience, [this] { return machine_.store_thread.pulse(); }},
                      {"compute", kWorkPatience, [this] { return machine_.compute_thread.pulse(); }}},
                     begun_};
  std::unique_ptr<WebServer> web_;
  asio::cancellation_signal stop_watch_;
  asio::cancellation_signal stop_feeding_;
  asio::cancellation_signal stop_keeping_;
  bool stopping_ = false;
};

}  // namespace

std::unique_ptr<Daemon> Daemon::start(Machine machine, const config::CellConfig& config,
                                      const std::filesystem::path& runtime) {
  return std::make_unique<CellDaemon>(std::move(machine), config, runtime);
}

}  // namespace truepose::daemon
