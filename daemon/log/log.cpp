#include "daemon/log/log.hpp"

#include <spdlog/async.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <string>

namespace truepose::daemon {

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

void close_log() { spdlog::shutdown(); }

void log_info(std::string_view line) { spdlog::info("{}", line); }
void log_warning(std::string_view line) { spdlog::warn("{}", line); }
void log_error(std::string_view line) { spdlog::error("{}", line); }

}  // namespace truepose::daemon
