#include "tools/truepose/bridge/examination.hpp"

namespace truepose::tools {

using namespace std::chrono_literals;
using bridge::ErrorCode;

Trial Examination::hello_comes_first() {
  bridge::SetAir early;
  const auto id = co_await line_.send_request(early);
  if (!id) co_return Seen::otherwise(id.error());
  const auto reply = co_await line_.reply_to(*id, kBridgeLookUp);
  co_return expect_refusal(reply, ErrorCode::BadRequest, *id);
}

Trial Examination::greets() {
  const auto greeting = co_await hello(bridge::kProtocol);
  if (!greeting) co_return Seen::otherwise(greeting.error());
  greeting_ = *greeting;
  if (greeting_.protocol != bridge::kProtocol)
    co_return Seen::otherwise("it speaks version " + std::to_string(greeting_.protocol) + " of the protocol");
  co_return Seen::kept();
}

Trial Examination::speaks_what_it_can() {
  constexpr int kOfTheFuture = 1000;
  const auto greeting = co_await hello(kOfTheFuture);
  if (!greeting) co_return Seen::otherwise(greeting.error());
  if (greeting->protocol == kOfTheFuture)
    co_return Seen::otherwise("it claims to speak version 1000, which does not exist");
  co_return Seen::kept();
}

Trial Examination::lives() {
  bridge::Ping ping;
  const auto answer = co_await line_.ask(ping, kAtOnce);
  co_return kept_where(answer);
}

Trial Examination::answers_status() {
  bridge::GetStatus request;
  const auto status = co_await line_.ask(request, kBridgeLookUp);
  if (!status) co_return Seen::otherwise(status.error());
  status_ = *status;
  if (status_.reflectors.empty()) co_return Seen::otherwise("it lists no reflectors");
  co_return Seen::kept();
}

Trial Examination::refuses_no_json() {
  std::string broken = "{\"id\": 5, \"do\": \"pi\n";
  const auto sent = co_await line_.send(std::move(broken));
  if (!sent) co_return Seen::otherwise(sent.error());
  const auto reply = co_await line_.next_reply(kBridgeLookUp);
  co_return expect_refusal(reply, ErrorCode::BadRequest, std::nullopt);
}

Trial Examination::refuses_no_id() {
  std::string nameless = "{\"do\": \"ping\"}\n";
  const auto sent = co_await line_.send(std::move(nameless));
  if (!sent) co_return Seen::otherwise(sent.error());
  const auto reply = co_await line_.next_reply(kBridgeLookUp);
  co_return expect_refusal(reply, ErrorCode::BadRequest, std::nullopt);
}

Trial Examination::refuses_unknown_request() {
  const std::int64_t id = line_.new_id();
  std::string unknown = bridge::request_line(id, "dance", {}) + "\n";
  const auto sent = co_await line_.send(std::move(unknown));
  if (!sent) co_return Seen::otherwise(sent.error());
  const auto reply = co_await line_.next_reply(kBridgeLookUp);
  co_return expect_refusal(reply, ErrorCode::NotOffered, id);
}

Trial Examination::refuses_missing_member() {
  const std::int64_t id = line_.new_id();
  std::string half = bridge::request_line(id, bridge::DoAim::kName, {{"x", 1000.0}}) + "\n";
  const auto sent = co_await line_.send(std::move(half));
  if (!sent) co_return Seen::otherwise(sent.error());
  const auto reply = co_await line_.next_reply(kBridgeLookUp);
  co_return expect_refusal(reply, ErrorCode::BadRequest, id);
}

Trial Examination::passes_over_unknown_member() {
  const std::int64_t id = line_.new_id();
  std::string richer = bridge::request_line(id, bridge::Ping::kName, {{"of_a_newer_client", true}}) + "\n";
  const auto sent = co_await line_.send(std::move(richer));
  if (!sent) co_return Seen::otherwise(sent.error());
  const auto reply = co_await line_.reply_to(id, kBridgeLookUp);
  if (!reply) co_return Seen::otherwise(reply.error());
  const auto answer = BridgeLine::answer_in<bridge::Ping>(*reply);
  co_return kept_where(answer);
}

Trial Examination::takes_lines_in_pieces() {
  const std::int64_t id = line_.new_id();
  const std::string line = bridge::encode(id, bridge::Ping{}) + "\n";
  for (const char c : line) {
    std::string byte(1, c);
    const auto sent = co_await line_.send(std::move(byte));
    if (!sent) co_return Seen::otherwise(sent.error());
    const drivers::TimePoint next = clock_.now() + 2ms;
    co_await clock_.sleep_until(next);
  }
  const auto reply = co_await line_.reply_to(id, kBridgeLookUp);
  co_return kept_where(reply);
}

Trial Examination::takes_lines_together() {
  const std::int64_t first = line_.new_id(), second = line_.new_id();
  std::string both =
      bridge::encode(first, bridge::Ping{}) + "\n" + bridge::encode(second, bridge::Ping{}) + "\n";
  const auto sent = co_await line_.send(std::move(both));
  if (!sent) co_return Seen::otherwise(sent.error());
  for (const std::int64_t id : {first, second}) {
    const auto reply = co_await line_.reply_to(id, kBridgeLookUp);
    if (!reply) co_return Seen::otherwise(reply.error());
  }
  co_return Seen::kept();
}

Trial Examination::turns_second_client_away() {
  BridgeLine other{options_.stream(executor_), clock_};
  const auto opened = co_await other.open(options_.host, options_.port);
  if (!opened) co_return Seen::kept();  // not even taken
  bridge::Hello request{.client = "truepose bridge-check, a second client"};
  const auto greeting = co_await other.ask(std::move(request), kBridgeLookUp);
  if (greeting) co_return Seen::otherwise("a second client was greeted while the first is connected");
  const Seen still = co_await lives();
  co_return still;
}

Trial Examination::refuses_unknown_reflector() {
  bridge::SetReflector request{"no such reflector"};
  const auto id = co_await line_.send_request(std::move(request));
  if (!id) co_return Seen::otherwise(id.error());
  const auto reply = co_await line_.reply_to(*id, kBridgeLookUp);
  co_return expect_refusal(reply, ErrorCode::UnknownReflector, *id);
}

Trial Examination::takes_reflector() {
  if (status_.reflectors.empty()) co_return Seen::not_tried("it lists none");
  bridge::SetReflector request{status_.reflectors.front()};
  const auto set = co_await line_.ask(std::move(request), kBridgeLookUp);
  if (!set) co_return Seen::otherwise(set.error());
  bridge::GetStatus ask_status;
  const auto status = co_await line_.ask(ask_status, kBridgeLookUp);
  if (!status) co_return Seen::otherwise(status.error());
  if (status->reflector != status_.reflectors.front())
    co_return Seen::otherwise("the status says \"" + status->reflector + "\" after \"" +
                              status_.reflectors.front() + "\" was chosen");
  co_return Seen::kept();
}

Trial Examination::takes_air() {
  bridge::SetAir request;
  const auto set = co_await line_.ask(request, kBridgeLookUp);
  co_return kept_where(set);
}

}  // namespace truepose::tools
