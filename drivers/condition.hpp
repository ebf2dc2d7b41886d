#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <memory>

namespace truepose::drivers {

/// What coroutines of one thread wait for until it is notified.
class Condition {
 public:
  explicit Condition(const boost::asio::any_io_executor& executor);
  Condition(Condition&&) noexcept;
  ~Condition();

  /// Returns at the next notify(), and when cancelled.
  boost::asio::awaitable<void> wait();
  void notify();

 private:
  struct Channel;
  std::unique_ptr<Channel> channel_;  ///< nothing is ever sent
};

}  // namespace truepose::drivers
