#include "daemon/web/web_pages.hpp"

#include <algorithm>
#include <cctype>

namespace truepose::daemon {

namespace {

bool equal_but_for_case(std::string_view one, std::string_view other) {
  return std::ranges::equal(
      one, other, [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
}

}  // namespace

std::string_view host_of(std::string_view host_and_port) {
  const std::size_t bracket = host_and_port.find(']');
  const std::size_t from = bracket == std::string_view::npos ? 0 : bracket;
  return host_and_port.substr(0, host_and_port.find(':', from));
}

bool is_loopback_name(std::string_view host_and_port) {
  const std::string_view host = host_of(host_and_port);
  return equal_but_for_case(host, "localhost") || host == "[::1]" || host == "127.0.0.1";
}

bool origin_may(std::string_view origin, std::string_view own, const std::vector<std::string>& allowed) {
  if (origin.empty() || equal_but_for_case(origin, own)) return true;
  return std::ranges::any_of(allowed,
                             [&](const std::string& one) { return equal_but_for_case(origin, one); });
}

std::string_view bearer_token(std::string_view authorization) {
  constexpr std::string_view kScheme = "Bearer ";
  if (!equal_but_for_case(authorization.substr(0, kScheme.size()), kScheme)) return {};
  return authorization.substr(kScheme.size());
}

}  // namespace truepose::daemon
