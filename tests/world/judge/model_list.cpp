#include "tests/world/judge/model_list.hpp"

#include <cstddef>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace json = boost::json;

boost::asio::awaitable<std::optional<json::array>> all_models(Client& client) {
  constexpr std::size_t kPage = 100;
  json::array models;
  for (std::size_t listed = kPage; listed == kPage;) {
    json::object page{{"limit", kPage}, {"offset", models.size()}};
    const json::value answer = co_await client.ask("model.list", std::move(page));
    if (!is_result(answer)) co_return std::nullopt;
    const json::array& more = result_of(answer).at("models").as_array();
    models.insert(models.end(), more.begin(), more.end());
    listed = more.size();
  }
  co_return models;
}

}  // namespace truepose::world
