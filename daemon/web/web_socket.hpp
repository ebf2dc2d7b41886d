#pragma once

#include <memory>
#include <optional>
#include <string>

#include "daemon/control/connection.hpp"
#include "daemon/web/http_message.hpp"

namespace truepose::daemon {

/// A client over WebSocket: each of its text messages is a line for the reader, and each line that is written
/// a text message for it. A message longer than a line may be is passed on in parts, as it comes, so that the
/// limits of lines hold for it.
///
/// @param under    what carries it, opened
/// @param come     bytes of it that were read already, behind the upgrade
/// @param upgrade  what the client asked for the WebSocket by
/// @param shown    the client's certificate
std::unique_ptr<Connection> web_socket(std::shared_ptr<Connection> under, std::string come,
                                       HttpRequest upgrade, std::optional<control::Certificate> shown);

}  // namespace truepose::daemon
