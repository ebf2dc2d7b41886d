#include "proto/text/host_port.hpp"

namespace truepose::text {

std::string host_port(std::string_view host, std::uint16_t port) {
  const bool is_v6 = host.find(':') != std::string_view::npos;
  std::string text = is_v6 ? "[" : "";
  text.append(host).append(is_v6 ? "]:" : ":");
  return text + std::to_string(port);
}

}  // namespace truepose::text
