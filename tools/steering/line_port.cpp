#include "tools/steering/line_port.hpp"

#include <array>
#include <utility>

#include "drivers/net/spawn.hpp"
#include "proto/control/line_splitter.hpp"
#include "tools/steering/accept_clients.hpp"

namespace truepose::steering {

namespace {

boost::asio::awaitable<void> serve(std::unique_ptr<net::Stream> stream,
                                   std::shared_ptr<const LinePort::Answer> answer) {
  control::LineSplitter lines{control::kMaxLine};
  std::array<char, 4096> buffer;
  while (!lines.overflowed()) {
    const auto [ended, size] = co_await stream->read(buffer);
    if (ended) co_return;
    lines.push({buffer.data(), size});
    while (const auto line = lines.next()) {
      const std::string reply = (*answer)(*line) + "\n";
      const auto lost = co_await stream->write(reply);
      if (lost) co_return;
    }
  }
}

}  // namespace

LinePort::LinePort(const boost::asio::any_io_executor& executor, std::uint16_t port, Answer answer)
    : listener_{listen_or_throw(executor, "127.0.0.1", port)} {
  const auto admit = [executor, shared = std::make_shared<const Answer>(std::move(answer))](
                         std::unique_ptr<net::Stream> stream) {
    net::spawn(executor, serve(std::move(stream), shared));
  };
  accept_clients(listener_, "admin", admit);
}

LinePort::~LinePort() { listener_->close(); }

}  // namespace truepose::steering
