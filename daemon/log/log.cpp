#include "daemon/log/log.hpp"

#include <spdlog/async.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <array>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace truepose::daemon {

namespace {

std::mutex reader_mutex;
std::function<void(LogLevel, std::string_view)> log_reader;

}  // namespace

void open_log(std::string_view level) {
  constexpr std::size_t kQueue = 4096;
  spdlog::init_thread_pool(kQueue, 1);
  // The oldest lines give way: a slow terminal must not hold up the event loop.
  auto logger = spdlog::create_async_nb<spdlog::sinks::stderr_sink_mt>("trueposed");
  logger->set_level(spdlog::level::from_str(std::string{level}));
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%eZ %l %v", spdlog::pattern_time_type::utc);
  logger->flush_on(spdlog::level::warn);
  spdlog::set_default_logger(logger);
  spdlog::flush_every(std::chrono::seconds{1});
}

bool close_log() {
  const auto written = std::make_shared<std::promise<void>>();
  auto done = written->get_future();
  std::thread{[written] {
    spdlog::shutdown();
    written->set_value();
  }}.detach();
  return done.wait_for(std::chrono::seconds{1}) == std::future_status::ready;
}

std::string_view name(LogLevel level) {
  switch (level) {
    case LogLevel::Info:
      return "info";
    case LogLevel::Warning:
      return "warning";
    case LogLevel::Error:
      return "error";
  }
  return "error";
}

void log(LogLevel level, std::string_view line) {
  constexpr std::array kLevels{spdlog::level::info, spdlog::level::warn, spdlog::level::err};
  spdlog::log(kLevels[static_cast<std::size_t>(level)], "{}", line);
  const std::lock_guard lock{reader_mutex};
  if (log_reader) log_reader(level, line);
}

void read_log(std::function<void(LogLevel, std::string_view)> reader) {
  const std::lock_guard lock{reader_mutex};
  log_reader = std::move(reader);
}

}  // namespace truepose::daemon
