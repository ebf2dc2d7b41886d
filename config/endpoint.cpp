#include "config/endpoint.hpp"

#include <charconv>

#include "config/number_text.hpp"

namespace truepose::config {

std::expected<Endpoint, std::string> parse_endpoint(std::string_view text, std::uint16_t least_port) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0)
    return std::unexpected("expected host:port, found " + in_quotes(text));
  std::string_view host = text.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return std::unexpected("expected host:port, found " + in_quotes(text) +
                           ": an IPv6 address stands in brackets");
  }
  const std::string_view digits = text.substr(colon + 1);
  std::uint16_t port = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc() || stop != digits.data() + digits.size() || port < least_port) {
    return std::unexpected("expected a port of " + std::to_string(least_port) + "..65535, found " +
                           in_quotes(digits));
  }
  return Endpoint{std::string{host}, port};
}

}  // namespace truepose::config
