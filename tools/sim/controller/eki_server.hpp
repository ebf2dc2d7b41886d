#pragma once

#include <boost/system/error_code.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tools/sim/machine.hpp"

namespace truepose::sim {

/// A port that cannot be listened on. what() is the operator's line: which, why, and what to do.
class PortError : public std::runtime_error {
 public:
  PortError(const std::string& whose, std::uint16_t port, const boost::system::error_code& reason)
      : std::runtime_error{
            whose + " port " + std::to_string(port) + ": " + reason.message() +
            "; choose another, or see who holds it: ss -ltnp 'sport = :" + std::to_string(port) + "'"} {}
};

/// Who acts on what comes over the EKI channels. Called on the server's executor.
class EkiListener {
 public:
  virtual ~EkiListener() = default;
  /// @return false where the channel takes no client now, who is then closed
  virtual bool connected(const std::string& channel) = 0;
  virtual void lost(const std::string& channel) = 0;
  virtual void received(const std::string& channel, std::string_view document) = 0;
};

struct EkiPort {
  std::string channel;
  std::uint16_t port = 0;      ///< 0 picks a free one
  bool is_taken_late = false;  ///< only when a program opens the channel; else at once
};

/// The EKI channels of a simulated controller: TCP servers for one client each, cutting the stream into
/// documents.
///
/// A second client is closed at once. Where no program has opened the channel clients are refused, but its
/// port stays its own.
class EkiServer {
 public:
  /// Takes the ports. Throws PortError.
  /// @param machine   the server is destroyed on its executor, or when that does not run
  /// @param listener  outlives the server
  EkiServer(const Machine& machine, const std::string& address, const std::vector<EkiPort>& ports,
            EkiListener& listener);
  ~EkiServer();

  /// 0 where there is no such channel, or its port is not taken yet.
  std::uint16_t port(std::string_view channel) const;

  /// Sends where a client is connected; otherwise the document is lost, as on the controller.
  void send(std::string_view channel, std::string document);
  /// A port that cannot be taken then is reported on stderr, once for each opening.
  void listen(std::string_view channel, bool open);
  /// The program has deleted the channel: its client is closed.
  void close(std::string_view channel);

  /// Fault: all channels are cut, and closed to everybody for this long.
  void drop(std::chrono::milliseconds duration);

 private:
  class Channel;
  std::map<std::string, std::shared_ptr<Channel>, std::less<>> channels_;
};

}  // namespace truepose::sim
