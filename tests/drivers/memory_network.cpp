#include "tests/drivers/memory_network.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/error.hpp>
#include <chrono>
#include <deque>

#include "daemon/threads/signal.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

constexpr std::chrono::seconds kProbed{5};  // what the options of net::tcp_stream() come to
constexpr const char* kAddress = "127.0.0.1";
constexpr std::uint16_t kFirstFree = 60'000;

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
  bool has_window = false;
  // Each end waits in its own process, and this may outlive that.
  std::weak_ptr<daemon::Signal> server, client;

  void notify() const {
    for (const auto& end : {server.lock(), client.lock()})
      if (end) end->notify();
  }
  void end_for_server() {
    to_server.ended = true;
    notify();
  }
  void reset() {
    broken = asio::error::connection_reset;
    end_for_server();
  }
};

net::MakeStream MemoryNetwork::streams() {
  return [this](const asio::any_io_executor& executor) {
    return std::make_unique<MemoryStream>(*this, executor);
  };
}

/// A port of a program. Its clients wait until they are accepted.
class MemoryListener final : public net::Listener {
 public:
  MemoryListener(MemoryNetwork& network, asio::any_io_executor executor, std::uint16_t port)
      : network_{network}, executor_{std::move(executor)}, port_{port} {
    network_.ports_[port_].listener = this;
  }
  ~MemoryListener() override { close(); }

  asio::any_io_executor executor() override { return executor_; }
  asio::awaitable<net::Result<std::unique_ptr<net::Stream>>> accept() override {
    while (open_ && waiting_.empty()) co_await changed_.wait();
    if (!open_) co_return std::unexpected(asio::error::operation_aborted);
    auto accepted = std::make_unique<MemoryStream>(network_, executor_, std::move(waiting_.front()));
    waiting_.pop_front();
    co_return accepted;
  }
  void close() noexcept override {
    if (!open_) return;
    open_ = false;
    network_.ports_[port_].listener = nullptr;
    for (const auto& link : waiting_) link->reset();
    changed_.notify();
  }
  bool is_open() const override { return open_; }
  net::Stream::End local() const override { return {kAddress, port_}; }

  void take(std::shared_ptr<MemoryNetwork::Link> link) {
    link->has_window = true;
    waiting_.push_back(std::move(link));
    changed_.notify();
  }

 private:
  MemoryNetwork& network_;
  asio::any_io_executor executor_;
  std::uint16_t port_;
  std::deque<std::shared_ptr<MemoryNetwork::Link>> waiting_;
  daemon::Signal changed_;
  bool open_ = true;
};

/// Nothing else in this process takes it.
class MemoryHeldPort final : public net::HeldPort {
 public:
  explicit MemoryHeldPort(std::uint16_t port) : port_{port} {}
  std::uint16_t port() const override { return port_; }

 private:
  std::uint16_t port_;
};

net::Network MemoryNetwork::network() {
  net::Network network;
  network.stream = streams();
  network.listen_tcp = [this](const asio::any_io_executor& executor, const std::string&, std::uint16_t port,
                              net::ListenOptions) { return listen(executor, port); };
  network.hold_tcp = [this](const asio::any_io_executor&, const std::string&,
                            std::uint16_t port) -> net::Result<std::unique_ptr<net::HeldPort>> {
    if (port != 0 && ports_[port].listener != nullptr) return std::unexpected(asio::error::address_in_use);
    return std::make_unique<MemoryHeldPort>(port == 0 ? free_port() : port);
  };
  network.listen_local = [this](const asio::any_io_executor& executor, const std::filesystem::path&,
                                unsigned) { return listen(executor, 0); };
  return network;
}

net::Result<std::shared_ptr<net::Listener>> MemoryNetwork::listen(asio::any_io_executor executor,
                                                                  std::uint16_t port) {
  if (port == 0) port = free_port();
  if (ports_[port].listener != nullptr) return std::unexpected(asio::error::address_in_use);
  return std::make_shared<MemoryListener>(*this, std::move(executor), port);
}

std::uint16_t MemoryNetwork::free_port() const {
  std::uint16_t port = kFirstFree;
  while (ports_.contains(port)) ++port;
  return port;
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
  each_link(device, [](Link& link) { link.notify(); });
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

MemoryStream::MemoryStream(MemoryNetwork& network, asio::any_io_executor executor,
                           std::shared_ptr<MemoryNetwork::Link> link)
    : network_{network}, executor_{std::move(executor)}, link_{std::move(link)}, is_server_{true} {
  link_->server = changed_;
}

net::Stream::End MemoryStream::local() const {
  return link_ && is_server_ ? End{kAddress, link_->port} : End{};
}
net::Stream::End MemoryStream::remote() const {
  return link_ ? End{kAddress, is_server_ ? std::uint16_t{0} : link_->port} : End{};
}

asio::awaitable<error_code> MemoryStream::connect(std::string, std::uint16_t number) {
  close();
  MemoryNetwork::Port& port = network_.ports_[number];
  if (!port.on) {  // whoever calls gives up
    daemon::Signal nobody;
    co_await nobody.wait();
  }
  if (!port.serve && port.listener == nullptr) co_return asio::error::connection_refused;
  auto link = std::make_shared<MemoryNetwork::Link>();
  link->port = number;
  link->client = changed_;
  port.links.push_back(link);
  link_ = link;
  if (port.stormy) {
    link->reset();
  } else if (port.listener != nullptr) {
    port.listener->take(link);
  } else {
    const asio::any_io_executor executor = network_.io_.get_executor();
    auto server = std::make_shared<MemoryStream>(network_, executor, link);
    asio::co_spawn(executor, port.serve(std::move(server)), asio::detached);
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
  const auto changed = changed_;
  MemoryNetwork::Link::Way& way = is_server_ ? link->to_server : link->to_client;
  for (;;) {
    if (!is_server_ && link->broken) co_return Received{link->broken, 0};
    if (link_ != link) co_return Received{asio::error::bad_descriptor, 0};
    const bool held = !is_server_ && (network_.ports_[link->port].silent || link->severed);
    if (!way.bytes.empty() && !held) {
      const std::size_t size = std::min(into.size(), way.bytes.size());
      std::copy_n(way.bytes.begin(), size, into.begin());
      way.bytes.erase(0, size);
      if (link->has_window) link->notify();
      co_return Received{{}, size};
    }
    if (way.ended && !held) co_return Received{asio::error::eof, 0};
    if (!is_server_ && link->severed) {
      const TimePoint found = *link->severed + kProbed;
      if (network_.clock_.now() >= found) co_return Received{asio::error::timed_out, 0};
      co_await changed->wait_until(network_.clock_, found);
    } else {
      co_await changed->wait();
    }
  }
}

asio::awaitable<error_code> MemoryStream::write(std::string_view bytes) {
  if (is_server_ && network_.latency > Duration{0}) {
    const TimePoint comes = network_.clock_.now() + network_.latency;
    co_await network_.clock_.sleep_until(comes);
  }
  try {
    co_await window();
  } catch (const boost::system::system_error& cancelled) {
    co_return cancelled.code();
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
  network_.on_bytes_(link.port, !is_server_, bytes);
  way.bytes += bytes;
  if (is_server_ && link.cut_after == 0U) {
    way.ended = true;
    link.end_for_server();
  }
  link.notify();
  co_return error_code{};
}

/// Until the client has read enough, or one end is closed.
asio::awaitable<void> MemoryStream::window() {
  const auto changed = changed_;
  while (is_server_ && link_ && link_->has_window && !link_->to_server.ended &&
         link_->to_client.bytes.size() >= MemoryNetwork::kWindow)
    co_await changed->wait();
}

asio::awaitable<void> MemoryStream::end_writing() {
  if (!link_) co_return;
  (is_server_ ? link_->to_client : link_->to_server).ended = true;
  link_->notify();
}

void MemoryStream::close() noexcept {
  if (!link_) return;
  (is_server_ ? link_->to_client : link_->to_server).ended = true;
  link_->notify();
  link_.reset();
}

bool MemoryStream::has_client() const { return link_ && !link_->to_server.ended; }

}  // namespace truepose::drivers
