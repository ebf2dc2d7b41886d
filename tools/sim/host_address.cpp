#include "tools/sim/host_address.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>

namespace truepose::sim {

std::expected<std::string, std::string> address_of(const std::string& host) {
  using boost::asio::ip::udp;
  boost::asio::io_context context;
  boost::system::error_code unknown;
  const auto found = udp::resolver{context}.resolve(udp::v4(), host, "0", unknown);
  if (unknown) return std::unexpected(unknown.message());
  return found.begin()->endpoint().address().to_string();
}

}  // namespace truepose::sim
