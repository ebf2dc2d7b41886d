#include "tools/truepose/bridge/conformance.hpp"

#include <utility>

#include "tools/truepose/bridge/examination.hpp"

namespace truepose::tools {

namespace asio = boost::asio;

Seen expect_refusal(const std::expected<bridge::Reply, std::string>& reply, bridge::ErrorCode code,
                    std::optional<std::int64_t> id) {
  const std::string wanted{name_of(bridge::kErrorCodes, code)};
  if (!reply) return Seen::otherwise(reply.error());
  if (reply->outcome) return Seen::otherwise("it was answered, expected the refusal " + wanted);
  if (reply->id != id)
    return Seen::otherwise("the refusal has " +
                           (reply->id ? "the id " + std::to_string(*reply->id) : "no id") + ", expected " +
                           (id ? std::to_string(*id) : "null"));
  const bridge::Refusal& refusal = reply->outcome.error();
  if (refusal.code != wanted)
    return Seen::otherwise("it was refused as " + refusal.code + ", expected " + wanted);
  if (refusal.text.empty()) return Seen::otherwise("the refusal has no text for the operator");
  return Seen::kept();
}

BridgeTask<bridge::Greeting> Examination::hello(int protocol) {
  bridge::Hello request{.protocol = protocol, .client = "truepose bridge-check"};
  auto greeting = co_await line_.ask(std::move(request), kBridgeLookUp);
  co_return greeting;
}

BridgeTask<void> Examination::reconnect() {
  auto opened = co_await line_.open(options_.host, options_.port);
  if (!opened) co_return opened;
  const auto greeted = co_await hello(bridge::kProtocol);
  if (!greeted) co_return std::unexpected(greeted.error());
  co_return std::expected<void, std::string>{};
}

const std::vector<Examination::Promise> Examination::kPromises{
    {"requests before hello are refused", &Examination::hello_comes_first,
     "answer bad-request to every request before hello"},
    {"hello is answered", &Examination::greets, "see hello in docs/trackers.md"},
    {"a newer client is answered in the version that the bridge speaks", &Examination::speaks_what_it_can,
     "answer hello with the lower of the client's protocol and the bridge's"},
    {"ping is answered within a second", &Examination::lives, "answer ping from the thread that reads"},
    {"status is answered", &Examination::answers_status, "see status in docs/trackers.md"},
    {"a line that is no JSON is refused, with id null", &Examination::refuses_no_json,
     "answer bad-request with id null, and read the next line"},
    {"a request without id is refused, with id null", &Examination::refuses_no_id,
     "answer bad-request with id null, and read the next line"},
    {"an unknown request is refused", &Examination::refuses_unknown_request,
     "answer not-offered with the request's id"},
    {"a request without one of its members is refused", &Examination::refuses_missing_member,
     "answer bad-request with the request's id, and name the member"},
    {"an unknown member is passed over", &Examination::passes_over_unknown_member,
     "ignore members that you do not know: newer clients send more"},
    {"a line may come in pieces", &Examination::takes_lines_in_pieces,
     "collect bytes until the newline: TCP keeps no messages apart"},
    {"several lines may come at once", &Examination::takes_lines_together,
     "split what was read at each newline, and answer all"},
    {"a second client is turned away", &Examination::turns_second_client_away,
     "refuse it as busy and close its connection, not the first one's"},
    {"an unknown reflector is refused", &Examination::refuses_unknown_reflector,
     "answer unknown-reflector, and keep the one that is selected"},
    {"a reflector is selected", &Examination::takes_reflector, "select it, and report it in status"},
    {"the air is taken", &Examination::takes_air,
     "hand it to the SDK, which corrects distances by it; where it cannot, correct them yourself"},
    {"the tracker is initialised", &Examination::initialises,
     "answer initialise once it is done, within two minutes, and report it in status"},
    {"a reflector is found where it stands", &Examination::aims,
     "see that one stands there: mm, right-handed, in the tracker's own frame"},
    {"a search away from it is refused", &Examination::misses,
     "search at most search_mm and at most timeout_ms, then answer no-target"},
    {"a point is measured", &Examination::measures, "see measure in docs/trackers.md"},
    {"ping is answered during a measurement", &Examination::lives_while_it_measures,
     "run the SDK's calls on a thread of their own"},
    {"a second measurement is refused as busy", &Examination::is_busy_while_it_measures,
     "refuse at once what the tracker cannot do meanwhile"},
    {"a measurement is stopped", &Examination::stops,
     "refuse what is under way as stopped, then answer stop"},
    {"the tracker turns over", &Examination::turns_over,
     "turn, lock the same reflector again, then answer; where the SDK cannot, refuse as not-offered"},
    {"a broken beam ends a measurement", &Examination::loses_beam,
     "send the event beam-lost, and refuse the measurement as beam-broken: never a part of an average"},
    {"a client that left is let in again", &Examination::comes_back,
     "see the end of the connection, end what is under way, and wait for the next client"},
};

asio::awaitable<std::expected<std::vector<BridgeVerdict>, std::string>> Examination::run() {
  const auto opened = co_await line_.open(options_.host, options_.port);
  if (!opened) co_return std::unexpected(opened.error());
  std::vector<BridgeVerdict> verdicts;
  for (const Promise& promise : kPromises) {
    Seen seen = co_await (this->*promise.trial)();
    BridgeVerdict verdict{.promise = promise.promise};
    const bool kept = seen.fault.empty();
    if (!kept) verdict.outcome = seen.skipped ? Conformance::Skipped : Conformance::Failed;
    verdict.found = std::move(seen.fault);
    if (verdict.outcome == Conformance::Failed) verdict.next = promise.next;
    verdicts.push_back(std::move(verdict));
    if (kept || seen.skipped) continue;
    // What is left of it on the wire must not be taken for what follows.
    const auto reconnected = co_await reconnect();
    if (reconnected) continue;
    verdicts.push_back({"a new connection after that", Conformance::Failed, reconnected.error(),
                        "restart the bridge, and see why it takes no client any more"});
    break;
  }
  co_return verdicts;
}

asio::awaitable<std::expected<std::vector<BridgeVerdict>, std::string>> check_bridge(
    asio::any_io_executor executor, drivers::Clock& clock, BridgeCheckOptions options) {
  Examination examination{executor, clock, std::move(options)};
  auto verdicts = co_await examination.run();
  co_return verdicts;
}

}  // namespace truepose::tools
