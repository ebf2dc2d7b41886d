#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

namespace truepose::steering {

/// The event loop of a program with one thread. SIGTERM and SIGINT end it.
class EventLoop {
 public:
  EventLoop();
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  boost::asio::any_io_executor executor() const;
  /// Returns at one of these signals, or when there is no more to do.
  void run();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace truepose::steering
