#include "daemon/process.hpp"

#include <signal.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <filesystem>

#include "daemon/daemon.hpp"
#include "daemon/log/log.hpp"
#include "daemon/machine.hpp"
#include "daemon/store/runtime_folder.hpp"
#include "drivers/net/spawn.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;

namespace {

/// Whether the daemon was started to outlive its terminal (nohup).
bool outlives_its_terminal() {
  struct sigaction hangup {};
  return ::sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler == SIG_IGN;
}

asio::awaitable<void> next_of(asio::signal_set& signals) {
  auto token = asio::use_awaitable;
  co_await signals.async_wait(token);
}

}  // namespace

void run(const config::CellConfig& config, const std::vector<std::string>& warnings) {
  const auto runtime = runtime_folder(config);
  if (!runtime && !config.runtime.empty()) throw StartError{runtime.error()};

  asio::io_context io{1};
  asio::signal_set signals{io, SIGTERM, SIGINT};
  drivers::SteadyClock clock;
  Worker store_thread, compute_thread, recorder_thread;
  const auto daemon = Daemon::start({io.get_executor(), clock, store_thread, compute_thread, recorder_thread,
                                     &std::chrono::system_clock::now},
                                    config, runtime.value_or(std::filesystem::path{}));
  if (!outlives_its_terminal()) signals.add(SIGHUP);
  for (const std::string& warning : warnings) log_warning(warning);
  if (!runtime) log_warning(runtime.error());
  net::spawn(io.get_executor(), daemon->live(next_of(signals)), net::rethrow);
  io.run();
  daemon->settle();
}

}  // namespace truepose::daemon
