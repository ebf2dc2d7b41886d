#include "tests/world/judge/model_judge.hpp"

#include <algorithm>
#include <boost/json/serialize.hpp>
#include <utility>

#include "tests/world/answers.hpp"
#include "tests/world/judge/model_list.hpp"
#include "tests/world/judge/truth_judge.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

// Of 12 poses, over a wide range.
constexpr double kBadModel_mm = 0.5;
constexpr double kWorseThanSaid = 2;

}  // namespace

void ModelJudge::take(const json::object& change) {
  if (text_at(change, "change") != "made") return;
  const json::object& model = change.at("model").as_object();
  if (model.at("active").as_bool()) trusted_.insert(text_at(model, "id"));
}

asio::awaitable<void> ModelJudge::look(Client& client) {
  const auto models = co_await all_models(client);
  if (!models) co_return;
  const auto active = std::ranges::count_if(
      *models, [](const json::value& model) { return model.as_object().at("active").as_bool(); });
  if (active > 1) log_.broken(std::to_string(active) + " models are active");
  if (active == 1) co_await compare_with_truth(client);
}

asio::awaitable<void> ModelJudge::compare_with_truth(Client& client) {
  const json::value status = co_await client.ask("cell.status");
  if (!is_result(status) || result_of(status).at("model").is_null()) co_return;
  const json::object& model = result_of(status).at("model").as_object();
  if (cell_.edited_models.contains(text_at(model, "id")))
    log_.broken("a model is active that was edited: " + json::serialize(model));
  json::object which{{"id", model.at("id")}};
  const json::value answer = co_await client.ask("model.get", std::move(which));
  if (!is_result(answer)) co_return;
  if (text_at(model, "robot_serial") != std::to_string(cell_.scenario.robot_serial)) co_return;
  const double error_mm = mean_error_mm(result_of(answer).at("parameters").as_array(), cell_.scenario);
  if (trusted_.erase(text_at(model, "id")) == 0) co_return;
  log_.trace("truth", text_at(model, "id") + ": " + std::to_string(error_mm) + " mm");
  largest_error_mm = std::max(largest_error_mm, error_mm);
  if (error_mm > kBadModel_mm)
    log_.broken("an active model is wrong by " + std::to_string(error_mm) + " mm: " + json::serialize(model));
  const json::value& said = model.at("validation_after_mm");
  const bool is_green = !model.contains("warning") && said.is_double();
  if (!is_green) co_return;
  const double ratio = error_mm / said.as_double();
  largest_ratio = std::max(largest_ratio, ratio);
  if (ratio > kWorseThanSaid)
    log_.broken("a green model is wrong by " + std::to_string(ratio) +
                " times what its validation says: " + json::serialize(model));
}

}  // namespace truepose::world
