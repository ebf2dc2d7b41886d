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

namespace truepose::daemon {

/// Runs a job where it may take long, and returns when it is done.
using RunJob = std::function<boost::asio::awaitable<void>(std::function<void()>)>;

/// The same for a job with a result, which no other thread refers to while the job is running.
template <typename Job>
boost::asio::awaitable<std::invoke_result_t<Job>> result_of(RunJob run, Job job) {
  auto result = std::make_shared<std::optional<std::invoke_result_t<Job>>>();
  std::function<void()> work = [result, job = std::move(job)]() mutable { result->emplace(job()); };
  co_await run(std::move(work));
  co_return std::move(**result);
}

/// What a thread shows of itself.
struct Pulse {
  std::uint64_t beats = 0;  ///< rises while it advances
  bool idle = false;        ///< it has nothing to do, so nothing has to rise
};

/// One thread that does jobs for coroutines of the event loop, one after the other. Ends before that loop is
/// destroyed.
class Worker {
 public:
  virtual ~Worker() = default;
  /// Returns on the caller's executor when the job is done. A cancelled caller still waits for its job.
  virtual boost::asio::awaitable<void> run(std::function<void()> job);
  /// The same for a job with a result.
  template <typename Job>
  boost::asio::awaitable<std::invoke_result_t<Job>> ask(Job job) {
    return result_of([this](std::function<void()> work) { return run(std::move(work)); }, std::move(job));
  }
  /// Waits for the jobs under way and takes no more.
  void join() { pool_.join(); }
  /// A job advances while it counts its steps (core/step_count.hpp); one that never does shows nothing until
  /// its end.
  Pulse pulse() const;
  /// Jobs that wait, or are under way.
  std::uint64_t waiting() const { return given_; }

 private:
  /// A job that was given and has not ended, counted for as long as its coroutine is there.
  class Given {
   public:
    explicit Given(std::atomic<std::uint64_t>& count) : count_{&count} { ++*count_; }
    Given(Given&& other) noexcept : count_{std::exchange(other.count_, nullptr)} {}
    Given& operator=(Given&&) = delete;
    ~Given() {
      if (count_) --*count_;
    }

   private:
    std::atomic<std::uint64_t>* count_;
  };
  boost::asio::awaitable<void> carry_out(std::function<void()> job, Given given);

  std::atomic<std::uint64_t> given_{0};  ///< jobs not yet ended, the one under way included
  std::atomic<std::uint64_t> beats_{0};
  boost::asio::thread_pool pool_{1};
};

}  // namespace truepose::daemon
