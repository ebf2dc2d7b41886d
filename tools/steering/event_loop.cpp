#include "tools/steering/event_loop.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>

namespace truepose::steering {

struct EventLoop::Impl {
  boost::asio::io_context io{1};
  boost::asio::signal_set ends{io, SIGTERM, SIGINT};
};

EventLoop::EventLoop() : impl_{std::make_unique<Impl>()} {
  impl_->ends.async_wait([&io = impl_->io](boost::system::error_code, int) { io.stop(); });
}
EventLoop::~EventLoop() = default;

boost::asio::any_io_executor EventLoop::executor() const { return impl_->io.get_executor(); }
void EventLoop::run() { impl_->io.run(); }

}  // namespace truepose::steering
