#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <boost/system/error_code.hpp>

namespace truepose::drivers {

/// What coroutines of one thread wait for until it is notified.
class Condition {
 public:
  explicit Condition(const boost::asio::any_io_executor& executor) : channel_{executor} {}

  /// Returns at the next notify(), and when cancelled.
  boost::asio::awaitable<void> wait();
  void notify() { channel_.cancel(); }

 private:
  boost::asio::experimental::channel<void(boost::system::error_code)> channel_;  ///< nothing is ever sent
};

}  // namespace truepose::drivers
