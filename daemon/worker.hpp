#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

namespace truepose::daemon {

/// One thread that does jobs for coroutines of the event loop, one after the other. Ends before that loop is
/// destroyed.
class Worker {
 public:
  /// Returns on the caller's executor when the job is done. A cancelled caller still waits for its job.
  boost::asio::awaitable<void> run(std::function<void()> job);
  /// Waits for the jobs under way and takes no more.
  void join() { pool_.join(); }

  /// The same for a job with a result.
  template <typename Job>
  boost::asio::awaitable<std::invoke_result_t<Job>> ask(Job job) {
    auto result = std::make_shared<std::optional<std::invoke_result_t<Job>>>();
    std::function<void()> work = [result, job = std::move(job)]() mutable { result->emplace(job()); };
    co_await run(work);
    co_return std::move(**result);
  }

 private:
  boost::asio::thread_pool pool_{1};
};

}  // namespace truepose::daemon
