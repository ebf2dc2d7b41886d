#pragma once

#include <Eigen/Core>
#include <array>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "core/named.hpp"
#include "drivers/net/stream.hpp"
#include "drivers/clock.hpp"

namespace truepose::tools {

enum class Conformance { Ok, Failed, Skipped };
inline constexpr std::array kConformances{Named{"ok", Conformance::Ok}, Named{"failed", Conformance::Failed},
                                          Named{"skipped", Conformance::Skipped}};

/// What became of one promise of the protocol.
struct BridgeVerdict {
  std::string promise;  ///< "an unknown request is refused"
  Conformance outcome = Conformance::Ok;
  std::string found;  ///< what was seen instead, or why it was not tried; empty where it is kept
  std::string next;   ///< what to do about it
};

struct BridgeCheckOptions {
  std::string host;
  std::uint16_t port = 0;
  std::optional<Eigen::Vector3d> reflector_mm;  ///< where one stands, roughly; none: nothing is moved
  double search_mm = 50;
  std::chrono::milliseconds measure{2000};
  net::MakeStream stream = net::tcp_stream;
};

/// Tries every promise of the bridge's protocol (docs/trackers.md), one after the other.
/// @return or why no bridge could be reached
boost::asio::awaitable<std::expected<std::vector<BridgeVerdict>, std::string>> check_bridge(
    boost::asio::any_io_executor executor, drivers::Clock& clock, BridgeCheckOptions options);

}  // namespace truepose::tools
