#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/threads/signal.hpp"
#include "drivers/clock.hpp"
#include "drivers/net/network.hpp"
#include "drivers/net/stream.hpp"

namespace truepose::drivers {

/// One end of a connection within the process.
class MemoryStream;
class MemoryListener;

/// Connections within the process in the time of a clock, which can be disturbed as those to devices are. A
/// device has one port or several. All machines share one address.
class MemoryNetwork {
 public:
  using Serve = std::function<boost::asio::awaitable<void>(std::shared_ptr<MemoryStream> client)>;
  using Ports = std::vector<std::uint16_t>;
  Duration latency{0};  ///< of what a device sends
  /// Bytes that a program's client has not read, from which on the program's writes wait.
  static constexpr std::size_t kWindow = 16'384;

  MemoryNetwork(boost::asio::io_context& io, Clock& clock) : io_{io}, clock_{clock} {}

  void listen(std::uint16_t port, Serve serve) { ports_[port].serve = std::move(serve); }
  /// What a driver is given in place of TCP.
  net::MakeStream streams();
  /// What a program is given in place of the system's network. Ports of one process end with its listeners;
  /// no client finds its Unix sockets.
  net::Network network();
  /// Called with all bytes of connections, as they are written.
  void on_bytes(std::function<void(std::uint16_t port, bool to_server, std::string_view bytes)> seen) {
    on_bytes_ = std::move(seen);
  }

  /// Its power is off: nobody takes or refuses connections, and those that were end without a word: the
  /// system's probes find that out after 5 s, and once it is on again what is sent over them is answered by a
  /// reset.
  void power(const Ports& device, bool on);
  /// It runs and receives, but its data do not arrive before the connection is restored.
  void silence(const Ports& device, bool silent);
  /// Whoever connects is thrown out at once.
  void storm(const Ports& device, bool stormy);
  void reset(const Ports& device);
  /// After so many bytes more that it sends the connection ends.
  void cut_after(const Ports& device, std::size_t bytes);

 private:
  friend class MemoryStream;
  friend class MemoryListener;
  struct Link;
  struct Port {
    Serve serve;
    MemoryListener* listener = nullptr;
    bool on = true, silent = false, stormy = false;
    std::vector<std::weak_ptr<Link>> links;
  };
  void each_link(const Ports& device, const std::function<void(Link&)>& act);
  std::uint16_t free_port() const;
  net::Result<std::shared_ptr<net::Listener>> listen(boost::asio::any_io_executor executor,
                                                     std::uint16_t port);

  boost::asio::io_context& io_;
  Clock& clock_;
  std::map<std::uint16_t, Port> ports_;
  std::function<void(std::uint16_t, bool, std::string_view)> on_bytes_ = [](auto&&...) {};
};

class MemoryStream final : public net::Stream {
 public:
  MemoryStream(MemoryNetwork& network, boost::asio::any_io_executor executor)
      : network_{network}, executor_{std::move(executor)} {}
  /// A server's end.
  MemoryStream(MemoryNetwork& network, boost::asio::any_io_executor executor,
               std::shared_ptr<MemoryNetwork::Link> link);
  ~MemoryStream() override { close(); }

  boost::asio::awaitable<boost::system::error_code> connect(std::string host, std::uint16_t port) override;
  boost::asio::awaitable<Received> read(std::span<char> into) override;
  boost::asio::awaitable<boost::system::error_code> write(std::string_view bytes) override;
  boost::asio::any_io_executor executor() override { return executor_; }
  boost::asio::awaitable<void> end_writing() override;
  void end_reading() override { close(); }
  void close() noexcept override;
  bool is_open() const override { return link_ != nullptr; }
  End local() const override;
  End remote() const override;
  /// Of a server's end: whether the client is still there.
  bool has_client() const;

 private:
  boost::asio::awaitable<Received> receive(std::span<char> into);
  boost::asio::awaitable<void> window();

  MemoryNetwork& network_;
  boost::asio::any_io_executor executor_;
  std::shared_ptr<daemon::Signal> changed_ = std::make_shared<daemon::Signal>();
  std::shared_ptr<MemoryNetwork::Link> link_;
  bool is_server_ = false;
};

}  // namespace truepose::drivers
