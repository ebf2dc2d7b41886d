#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "daemon/service/watchdog.hpp"

namespace truepose::daemon {

/// One thread that does jobs for coroutines of the event loop, one after the other. Ends before that loop is
/// destroyed.
class Worker {
 public:
  /// Returns on the caller's executor when the job is done. A cancelled caller still waits for its job.
  boost::asio::awaitable<void> run(std::function<void()> job);
  /// Waits for the jobs under way and takes no more.
  void join() { pool_.join(); }
  /// A job advances while it counts its steps (core/step_count.hpp); one that never does shows nothing until
  /// its end.
  Pulse pulse() const;

  /// The same for a job with a result.
  template <typename Job>
  boost::asio::awaitable<std::invoke_result_t<Job>> ask(Job job) {
    auto result = std::make_shared<std::optional<std::invoke_result_t<Job>>>();
    std::function<void()> work = [result, job = std::move(job)]() mutable { result->emplace(job()); };
    co_await run(work);
    co_return std::move(**result);
  }

 private:
  void carry_out(const std::function<void()>& job);

  std::atomic<std::uint64_t> waiting_{0};  ///< jobs not yet ended, the one under way included
  std::atomic<std::uint64_t> beats_{0};
  boost::asio::thread_pool pool_{1};
};

}  // namespace truepose::daemon
