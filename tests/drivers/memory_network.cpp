#include "tests/drivers/memory_network.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/error.hpp>
#include <chrono>

#include "daemon/threads/signal.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

constexpr std::chrono::seconds kProbed{5};  // what the options of net::tcp_stream() come to

}  // namespace

struct MemoryNetwork::Link {
  struct Way {
    std::string bytes;
    bool ended = false;  ///< nothing comes after them
  };
  std::uint16_t port = 0;
  Way to_server, to_client;
  error_code broken;  ///< for the client, at once
  std::optional<TimePoint> severed;
  std::optional<std::size_t> cut_after;
  daemon::Signal changed;

  void end_for_server() {
    to_server.ended = true;
    changed.notify();
  }
  void reset() {
    broken = asio::error::connection_reset;
    end_for_server();
  }
};

net::MakeStream MemoryNetwork::streams() {
  return [this](const asio::any_io_executor&) { return std::make_unique<MemoryStream>(*this); };
}

void MemoryNetwork::each_link(const Ports& device, const std::function<void(Link&)>& act) {
  for (const std::uint16_t port : device) {
    for (const auto& weak : ports_[port].links)
      if (const auto link = weak.lock()) act(*link);
    std::erase_if(ports_[port].links, [](const auto& link) { return link.expired(); });
  }
}

void MemoryNetwork::power(const Ports& device, bool on) {
  for (const std::uint16_t port : device) ports_[port].on = on;
  if (on) return;
  each_link(device, [this](Link& link) {
    if (!link.severed) link.severed = clock_.now();
    link.end_for_server();
  });
}

void MemoryNetwork::silence(const Ports& device, bool silent) {
  for (const std::uint16_t port : device) ports_[port].silent = silent;
  each_link(device, [](Link& link) { link.changed.notify(); });
}

void MemoryNetwork::storm(const Ports& device, bool stormy) {
  for (const std::uint16_t port : device) ports_[port].stormy = stormy;
  if (stormy) reset(device);
}

void MemoryNetwork::reset(const Ports& device) {
  each_link(device, [](Link& link) { link.reset(); });
}

void MemoryNetwork::cut_after(const Ports& device, std::size_t bytes) {
  each_link(device, [bytes](Link& link) { link.cut_after = bytes; });
}

MemoryStream::MemoryStream(MemoryNetwork& network, std::shared_ptr<MemoryNetwork::Link> link)
    : network_{network}, link_{std::move(link)}, is_server_{true} {}

asio::awaitable<error_code> MemoryStream::connect(std::string, std::uint16_t number) {
  close();
  MemoryNetwork::Port& port = network_.ports_[number];
  if (!port.on) {  // whoever calls gives up
    daemon::Signal nobody;
    co_await nobody.wait();
  }
  auto link = std::make_shared<MemoryNetwork::Link>();
  link->port = number;
  port.links.push_back(link);
  link_ = link;
  if (port.stormy) {
    link->reset();
  } else {
    asio::co_spawn(network_.io_, port.serve(std::make_shared<MemoryStream>(network_, link)), asio::detached);
  }
  co_return error_code{};
}

asio::awaitable<net::Stream::Received> MemoryStream::read(std::span<char> into) {
  const auto link = link_;  // close() may come meanwhile
  if (!link) co_return Received{asio::error::bad_descriptor, 0};
  try {
    const Received received = co_await receive(into);
    co_return received;
  } catch (const boost::system::system_error& cancelled) {
    co_return Received{cancelled.code(), 0};
  }
}

asio::awaitable<net::Stream::Received> MemoryStream::receive(std::span<char> into) {
  const auto link = link_;
  MemoryNetwork::Link::Way& way = is_server_ ? link->to_server : link->to_client;
  for (;;) {
    if (!is_server_ && link->broken) co_return Received{link->broken, 0};
    if (link_ != link) co_return Received{asio::error::bad_descriptor, 0};
    const bool held = !is_server_ && (network_.ports_[link->port].silent || link->severed);
    if (!way.bytes.empty() && !held) {
      const std::size_t size = std::min(into.size(), way.bytes.size());
      std::copy_n(way.bytes.begin(), size, into.begin());
      way.bytes.erase(0, size);
      co_return Received{{}, size};
    }
    if (way.ended && !held) co_return Received{asio::error::eof, 0};
    if (!is_server_ && link->severed) {
      const TimePoint found = *link->severed + kProbed;
      if (network_.clock_.now() >= found) co_return Received{asio::error::timed_out, 0};
      co_await link->changed.wait_until(network_.clock_, found);
    } else {
      co_await link->changed.wait();
    }
  }
}

asio::awaitable<error_code> MemoryStream::write(std::string_view bytes) {
  if (is_server_ && network_.latency > Duration{0}) {
    const TimePoint comes = network_.clock_.now() + network_.latency;
    co_await network_.clock_.sleep_until(comes);
  }
  if (!link_) co_return asio::error::bad_descriptor;
  MemoryNetwork::Link& link = *link_;
  if (link.severed) {
    if (network_.ports_[link.port].on) link.reset();
    co_return error_code{};
  }
  MemoryNetwork::Link::Way& way = is_server_ ? link.to_client : link.to_server;
  if (is_server_ && link.cut_after) {
    bytes = bytes.substr(0, *link.cut_after);
    *link.cut_after -= bytes.size();
  }
  way.bytes += bytes;
  if (is_server_ && link.cut_after == 0U) {
    way.ended = true;
    link.end_for_server();
  }
  link.changed.notify();
  co_return error_code{};
}

asio::awaitable<void> MemoryStream::end_writing() {
  if (!link_) co_return;
  (is_server_ ? link_->to_client : link_->to_server).ended = true;
  link_->changed.notify();
}

void MemoryStream::close() noexcept {
  if (!link_) return;
  (is_server_ ? link_->to_client : link_->to_server).ended = true;
  link_->changed.notify();
  link_.reset();
}

bool MemoryStream::has_client() const { return link_ && !link_->to_server.ended; }

}  // namespace truepose::drivers
