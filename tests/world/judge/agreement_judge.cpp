#include "tests/world/judge/agreement_judge.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <chrono>
#include <cmath>

#include "tests/world/answers.hpp"
#include "tests/world/judge/model_list.hpp"
#include "tests/world/web_client.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;

namespace {

std::string id_of(const json::value& model) {
  return model.is_null() ? std::string{"none"} : text_at(model.as_object(), "id");
}

std::string number_text(double number) { return std::to_string(std::llround(number)); }

std::string joined(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += name + ' ';
  return text;
}

}  // namespace

void AgreementJudge::take(const json::object& event) {
  const std::string topic = text_at(event, "topic");
  const json::object& data = event.at("data").as_object();
  if (!client_.is_late(event)) hears_ = true;
  if (topic == "cell" && hears_) state_ = text_at(data, "state");
  if (topic == "fault" && data.at("active").as_bool()) faults_.insert(text_at(data, "code"));
  if (topic == "fault" && !data.at("active").as_bool()) faults_.erase(text_at(data, "code"));
  if (topic == "model") {
    const std::string change = text_at(data, "change");
    const bool is_active = data.at("model").as_object().at("active").as_bool();
    if (change != "made" || is_active) {
      model_ = change == "deactivated" ? "none" : id_of(data.at("model"));
      knows_model_ = true;
    }
  }
  // While it corrects it says so every second.
  const bool says_the_same = topic == "stream" && text_at(data, "state") == stream_;
  if (topic == "stream") stream_ = text_at(data, "state");
  if (topic != "log" && !says_the_same) ++events_;
}

void AgreementJudge::restarted() {
  state_.clear();
  knows_faults_ = hears_ = false;
}

asio::awaitable<void> AgreementJudge::look() {
  constexpr std::chrono::seconds kUntilEventsCome{2};
  const std::uint64_t before = changes();
  if (under_way_ > 0) co_return;
  const json::value status = co_await client_.ask("cell.status");
  const auto models = co_await all_models(client_);
  const auto numbers = co_await metrics(cell_.world);
  co_await cell_.world.pass(kUntilEventsCome);
  if (changes() != before || !is_result(status) || !models || !cell_.pc.runs()) co_return;
  ++looks;
  compare(result_of(status), *models, numbers);
}

void AgreementJudge::compare(const json::object& status, const json::array& models, const Numbers& metrics) {
  compare_with_events(status);
  std::string active = "none";
  for (const json::value& model : models)
    if (model.as_object().at("active").as_bool()) active = id_of(model);
  expect("active model of status and list", id_of(status.at("model")), active);
  if (metrics.empty()) return log_.broken("the web port does not answer");
  const json::object& stream = status.at("stream").as_object();
  const auto number = [&](const std::string& name) {
    const auto found = metrics.find("truepose_" + name);
    return found == metrics.end() ? std::string{"none"} : number_text(found->second);
  };
  const auto number_of = [](bool is) { return std::string{is ? "1" : "0"}; };
  expect("state in the metrics", "1", number("cell_state{state=\"" + text_at(status, "state") + "\"}"));
  expect("model in the metrics", number_of(active != "none"), number("model_active"));
  expect("campaign in the metrics", number_of(!status.at("campaign").is_null()), number("campaign_running"));
  expect("armed stream in the metrics", number_of(stream.at("armed").as_bool()), number("stream_armed"));
  expect("sessions of the stream in the metrics", number_text(stream.at("sessions").to_number<double>()),
         number("stream_sessions_total"));
  compare_sessions(number("control_sessions"));
}

void AgreementJudge::compare_sessions(const std::string& counted) {
  std::set<std::string> possible;
  const auto clients = cell_.clients();
  const auto connected = std::ranges::count_if(clients, &Client::is_connected);
  // The daemon may have ended sessions of those that do not read.
  const auto sure = std::ranges::count_if(
      clients, [](const Client* client) { return client->is_connected() && client->reads(); });
  for (auto sessions = sure; sessions <= connected; ++sessions) possible.insert(std::to_string(sessions));
  if (!possible.contains(counted)) expect("sessions in the metrics", joined(possible), counted);
}

void AgreementJudge::compare_with_events(const json::object& status) {
  if (!state_.empty()) expect("state of status and events", text_at(status, "state"), state_);
  std::set<std::string> faults;
  for (const json::value& fault : status.at("faults").as_array())
    faults.insert(text_at(fault.as_object(), "code"));
  const bool is_refused = faults.contains("E_MODEL");
  if (knows_model_)
    expect("active model of status and events", id_of(status.at("model")), is_refused ? "none" : model_);
  if (knows_faults_) expect("faults of status and events", joined(faults), joined(faults_));
  faults_ = faults;
  knows_faults_ = true;
}

void AgreementJudge::expect(const std::string& what, const std::string& one, const std::string& other) {
  if (one != other) log_.broken(what + ": " + one + " is not " + other);
}

}  // namespace truepose::world
