#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace truepose::daemon {

/// Text of the dashboard's page (dashboard.html).
std::string_view dashboard_page();

/// Of an address in a URL or a header, without the port: "[::1]:7280" gives "[::1]".
std::string_view host_of(std::string_view host_and_port);

/// Whether a request in the clear was made for this machine by its own name. A page elsewhere may have its
/// name resolve to 127.0.0.1, and would then have the browser talk to us as to its own server: the name that
/// the browser asks for gives it away.
bool is_loopback_name(std::string_view host_and_port);

/// Whether a browser's page may speak the control protocol: one that was had from here, or of a listed
/// origin.
/// @param origin  empty: no browser asks
/// @param own     "https://10.0.0.5:7280", where the client found us
bool origin_may(std::string_view origin, std::string_view own, const std::vector<std::string>& allowed);

/// The token of "Bearer TOKEN"; empty: none.
std::string_view bearer_token(std::string_view authorization);

}  // namespace truepose::daemon
