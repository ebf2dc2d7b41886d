#include "drivers/wire_reports.hpp"

#include <boost/asio/error.hpp>
#include <string>

#include "proto/text/host_port.hpp"

namespace truepose::drivers {

void report_connected(const WireTap& tap, const net::Stream& stream) {
  const net::Stream::End local = stream.local(), remote = stream.remote();
  const bool are_known = !local.host.empty() && !remote.host.empty();
  tap(recording::Kind::Connected,
      are_known ? text::host_port(local.host, local.port) + ' ' + text::host_port(remote.host, remote.port)
                : "");
}

void report_failure(const WireTap& tap, std::string_view operation, const boost::system::error_code& error) {
  if (!error || error == boost::asio::error::operation_aborted) return;
  tap(recording::Kind::Failed, std::string{operation} + ": " + error.message());
}

}  // namespace truepose::drivers
