#include "drivers/wire_failure.hpp"

#include <boost/asio/error.hpp>
#include <string>

namespace truepose::drivers {

void report_failure(const WireTap& tap, std::string_view operation, const boost::system::error_code& error) {
  if (!error || error == boost::asio::error::operation_aborted) return;
  tap(recording::Kind::Failed, std::string{operation} + ": " + error.message());
}

}  // namespace truepose::drivers
