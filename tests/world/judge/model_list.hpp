#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/array.hpp>
#include <optional>

#include "tests/world/client.hpp"

namespace truepose::world {

/// All models, page by page. @return nothing where the daemon did not answer
boost::asio::awaitable<std::optional<boost::json::array>> all_models(Client& client);

}  // namespace truepose::world
