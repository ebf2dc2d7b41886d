#include "tests/world/reading.hpp"

#include <boost/json/array.hpp>
#include <boost/json/serialize.hpp>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;
using Wait = asio::awaitable<void>;

namespace {

const json::object& one_of(const json::array& list, Random& random) {
  return list.at(static_cast<std::size_t>(random.uniform() * static_cast<double>(list.size()))).as_object();
}

}  // namespace

Wait Reading::read_all() {
  co_await read("session.ping");
  co_await read("system.config");
  co_await read("tool.list");
  const json::value campaigns = co_await client_.ask("campaign.list");
  if (is_result(campaigns) && !result_of(campaigns).at("campaigns").as_array().empty()) {
    const json::object& one = one_of(result_of(campaigns).at("campaigns").as_array(), random_);
    std::string id = text_at(one, "id");
    co_await read_campaign(std::move(id));
  }
  co_await read_models();
  co_await read_recordings();
  co_await client_.subscribe_again();
}

Wait Reading::read_campaign(std::string id) {
  const json::object which{{"id", id}};
  json::object with_points{{"id", id}, {"points_limit", 50}};
  co_await read("campaign.get", std::move(with_points));
  co_await read_parts("campaign.export", which, "data");
  const json::value report = co_await client_.ask("report.get", which);
  if (is_result(report)) co_await read_parts("report.html", which, "html");
}

Wait Reading::read_models() {
  const json::value models = co_await client_.ask("model.list");
  if (!is_result(models) || result_of(models).at("models").as_array().empty()) co_return;
  const json::object& one = one_of(result_of(models).at("models").as_array(), random_);
  const json::object which{{"id", one.at("id")}};
  co_await read("model.export", which);
  if (cell_.edited_models.contains(text_at(one, "id"))) co_return;
  co_await read("model.get", which);
  json::array joints;
  joints.push_back(json::array{0, -90, 90, 0, 35, 0});
  json::object targets{{"joints", std::move(joints)}, {"model_id", one.at("id")}};
  co_await read("targets.compensate", std::move(targets));
}

Wait Reading::read_recordings() {
  const json::value recordings = co_await client_.ask("recording.list");
  if (!is_result(recordings) || result_of(recordings).at("recordings").as_array().empty()) co_return;
  const json::object& one = one_of(result_of(recordings).at("recordings").as_array(), random_);
  json::object which{{"name", one.at("name")}};
  co_await read_parts("recording.get", std::move(which), "data");
}

Wait Reading::read_parts(std::string method, json::object which, std::string part) {
  constexpr int kMostParts = 1000;
  constexpr std::size_t kBase64OfThree = 4;
  std::size_t offset = 0;
  for (int i = 0; i < kMostParts; ++i) {
    which["offset"] = offset;
    const json::value answer = co_await client_.ask(method, which);
    if (answer.is_null()) co_return;
    if (!is_result(answer)) co_return refused(method, answer);
    const json::object& result = result_of(answer);
    if (result.at("offset").to_number<std::size_t>() != offset)
      co_return log_.broken(method + " answers another part");
    const std::string text = text_at(result, part);
    if (text.empty() || (result.contains("next") && result.at("next").is_null())) co_return;
    offset += method == "recording.get" ? text.size() / kBase64OfThree * 3 : text.size();
    if (result.contains("next")) offset = result.at("next").to_number<std::size_t>();
  }
  log_.broken(method + " has no end");
}

Wait Reading::read(std::string method, json::object params) {
  const json::value answer = co_await client_.ask(method, std::move(params));
  if (!answer.is_null() && !is_result(answer)) refused(method, answer);
}

/// A store that cannot be read is one of the faults.
void Reading::refused(const std::string& method, const json::value& answer) {
  if (!log_.is_disturbed()) log_.broken(method + " is refused: " + json::serialize(answer));
}

}  // namespace truepose::world
