#include "tools/truepose/bridge/conformance.hpp"

#include <algorithm>
#include <utility>

#include "core/formatted.hpp"
#include "drivers/plausible_point.hpp"
#include "tools/truepose/bridge/bridge_line.hpp"

namespace truepose::tools {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using bridge::ErrorCode, bridge::EventKind;
using drivers::Duration;

namespace {

constexpr Duration kAtOnce = 1s;
constexpr Duration kMotion = 60s;
constexpr Duration kInitialise = 120s;

/// What was seen of a promise: nothing that speaks against it, or what does.
struct Seen {
  std::string fault;
  bool skipped = false;

  static Seen kept() { return {}; }
  static Seen otherwise(std::string what) { return {std::move(what)}; }
  static Seen not_tried(std::string why) { return {std::move(why), true}; }
};
using Trial = asio::awaitable<Seen>;

/// Whether a reply refuses by this code.
Seen expect_refusal(const std::expected<bridge::Reply, std::string>& reply, ErrorCode code,
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

template <class T>
Seen kept_where(const std::expected<T, std::string>& outcome) {
  return outcome ? Seen::kept() : Seen::otherwise(outcome.error());
}

class Examination {
 public:
  Examination(const asio::any_io_executor& executor, drivers::Clock& clock, BridgeCheckOptions options)
      : options_{std::move(options)},
        executor_{executor},
        clock_{clock},
        line_{options_.stream(executor), clock} {}

  asio::awaitable<std::expected<std::vector<BridgeVerdict>, std::string>> run();

 private:
  struct Promise {
    const char* promise;
    Trial (Examination::*trial)();
    const char* next;
  };
  static const std::vector<Promise> kPromises;

  // Of the connection and its lines
  Trial hello_comes_first();
  Trial greets();
  Trial speaks_what_it_can();
  Trial lives();
  Trial tells_status();
  Trial refuses_no_json();
  Trial refuses_no_id();
  Trial refuses_unknown_request();
  Trial refuses_missing_member();
  Trial passes_over_unknown_member();
  Trial takes_lines_in_pieces();
  Trial takes_lines_together();
  Trial turns_second_client_away();
  // Of settings
  Trial refuses_unknown_reflector();
  Trial takes_reflector();
  Trial takes_air();
  // Of the tracker
  Trial initialises();
  Trial aims();
  Trial misses();
  Trial measures();
  Trial lives_while_it_measures();
  Trial is_busy_while_it_measures();
  Trial stops();
  Trial turns_over();
  Trial loses_beam();
  Trial comes_back();

  BridgeTask<void> aim_at(Eigen::Vector3d p_mm, double search_mm, std::chrono::milliseconds timeout);
  BridgeTask<bridge::Greeting> hello(int protocol);
  BridgeTask<void> reconnect();

  const BridgeCheckOptions options_;
  asio::any_io_executor executor_;
  drivers::Clock& clock_;
  BridgeLine line_;
  bridge::Greeting greeting_;
  bridge::Status status_;
  bool initialised_ = false, aimed_ = false;
};

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

// ---- The connection and its lines

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

Trial Examination::tells_status() {
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

// ---- Settings

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

// ---- The tracker

Trial Examination::initialises() {
  if (!options_.reflector_mm) co_return Seen::not_tried("it moves the tracker: give --at X,Y,Z");
  bridge::Initialise request;
  const auto done = co_await line_.ask(request, kInitialise);
  if (!done) co_return Seen::otherwise(done.error());
  bridge::GetStatus ask_status;
  const auto status = co_await line_.ask(ask_status, kBridgeLookUp);
  if (!status) co_return Seen::otherwise(status.error());
  if (!status->initialised) co_return Seen::otherwise("the status says that it is not initialised");
  initialised_ = true;
  co_return Seen::kept();
}

BridgeTask<void> Examination::aim_at(Eigen::Vector3d p_mm, double search_mm,
                                     std::chrono::milliseconds timeout) {
  bridge::DoAim request{p_mm, search_mm, timeout};
  const auto aimed = co_await line_.ask(request, kMotion);
  if (!aimed) co_return std::unexpected(aimed.error());
  co_return std::expected<void, std::string>{};
}

Trial Examination::aims() {
  if (!initialised_) co_return Seen::not_tried("the tracker is not initialised");
  const auto aimed = co_await aim_at(*options_.reflector_mm, options_.search_mm, 10s);
  if (!aimed) co_return Seen::otherwise(aimed.error());
  bridge::GetStatus ask_status;
  const auto status = co_await line_.ask(ask_status, kBridgeLookUp);
  if (!status) co_return Seen::otherwise(status.error());
  if (!status->locked) co_return Seen::otherwise("the status says that no reflector is locked");
  if (status->face == 2) co_return Seen::otherwise("the tracker is in face 2");
  aimed_ = true;
  co_return Seen::kept();
}

Trial Examination::misses() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  const Eigen::Vector3d beside_mm = *options_.reflector_mm + Eigen::Vector3d{0, 0, 500};
  bridge::DoAim request{beside_mm, 5, 2s};
  const auto id = co_await line_.send_request(request);
  if (!id) co_return Seen::otherwise(id.error());
  const auto reply = co_await line_.reply_to(*id, kMotion);
  const Seen seen = expect_refusal(reply, ErrorCode::NoTarget, *id);
  const auto back = co_await aim_at(*options_.reflector_mm, options_.search_mm, 10s);
  if (!seen.fault.empty()) co_return seen;
  co_return kept_where(back);
}

Trial Examination::measures() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  bridge::DoMeasure request{options_.measure};
  const auto result = co_await line_.ask(request, options_.measure + kMotion);
  if (!result) co_return Seen::otherwise(result.error());
  const double off_mm = (result->p_W_mm - *options_.reflector_mm).norm();
  if (off_mm > options_.search_mm)
    co_return Seen::otherwise(
        formatted("the point is %.1f mm from where it was to look: units, axes, frame?", off_mm));
  if (result->averaged < options_.measure)
    co_return Seen::otherwise("averaged_ms is less than time_ms asked for");
  if (result->age > 1s) co_return Seen::otherwise("age_ms says that the point is an old one");
  const drivers::SmrPoint point{.p_WS_mm = result->p_W_mm,
                                .std_mm = result->deviations_mm(),
                                .temperature_c = result->air.temperature_c,
                                .pressure_mbar = result->air.pressure_mbar,
                                .humidity_percent = result->air.humidity_percent};
  if (const auto why_not = drivers::implausible(point)) co_return Seen::otherwise(*why_not);
  co_return Seen::kept();
}

Trial Examination::lives_while_it_measures() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  bridge::DoMeasure request{2 * options_.measure};
  const auto measuring = co_await line_.send_request(request);
  if (!measuring) co_return Seen::otherwise(measuring.error());
  bridge::Ping ping;
  const auto pinged = co_await line_.send_request(ping);
  if (!pinged) co_return Seen::otherwise(pinged.error());
  const auto alive = co_await line_.reply_to(*pinged, kAtOnce);
  if (!alive) co_return Seen::otherwise(alive.error());
  const auto measured = co_await line_.reply_to(*measuring, 2 * options_.measure + kMotion);
  co_return kept_where(measured);
}

Trial Examination::is_busy_while_it_measures() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  bridge::DoMeasure request{2 * options_.measure};
  const auto measuring = co_await line_.send_request(request);
  if (!measuring) co_return Seen::otherwise(measuring.error());
  const auto second = co_await line_.send_request(request);
  if (!second) co_return Seen::otherwise(second.error());
  const auto refused = co_await line_.reply_to(*second, kBridgeLookUp);
  const Seen seen = expect_refusal(refused, ErrorCode::Busy, *second);
  if (!seen.fault.empty()) co_return seen;
  const auto measured = co_await line_.reply_to(*measuring, 2 * options_.measure + kMotion);
  co_return kept_where(measured);
}

Trial Examination::stops() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  bridge::DoMeasure request{10 * options_.measure};
  const auto measuring = co_await line_.send_request(request);
  if (!measuring) co_return Seen::otherwise(measuring.error());
  bridge::Stop stop;
  const auto stopping = co_await line_.send_request(stop);
  if (!stopping) co_return Seen::otherwise(stopping.error());
  const auto ended = co_await line_.reply_to(*measuring, kBridgeLookUp);
  const Seen seen = expect_refusal(ended, ErrorCode::Stopped, *measuring);
  if (!seen.fault.empty()) co_return seen;
  const auto stopped = co_await line_.reply_to(*stopping, kBridgeLookUp);
  co_return kept_where(stopped);
}

Trial Examination::turns_over() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  for (const int face : {2, 1}) {
    bridge::SetFace request{face};
    const auto turned = co_await line_.ask(request, kMotion);
    if (!turned) co_return Seen::otherwise(turned.error());
    bridge::GetStatus ask_status;
    const auto status = co_await line_.ask(ask_status, kBridgeLookUp);
    if (!status) co_return Seen::otherwise(status.error());
    if (status->face != face)
      co_return Seen::otherwise(
          formatted("the status says face %d after %d was asked for", status->face, face));
    if (!status->locked) co_return Seen::otherwise("no reflector is locked from the other face");
  }
  co_return Seen::kept();
}

Trial Examination::loses_beam() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  if (std::ranges::find(greeting_.rehearses, bridge::Rehearsal::BeamBreak) == greeting_.rehearses.end())
    co_return Seen::not_tried("the bridge does not offer to rehearse it: break the beam by hand");
  line_.events.clear();
  bridge::DoMeasure request{10 * options_.measure};
  const auto measuring = co_await line_.send_request(request);
  if (!measuring) co_return Seen::otherwise(measuring.error());
  bridge::Rehearse rehearse{.lasts = 300ms};
  const auto breaking = co_await line_.send_request(rehearse);
  if (!breaking) co_return Seen::otherwise(breaking.error());
  bool broken = false, told = false;
  for (int replies = 0; replies < 2; ++replies) {
    const auto reply = co_await line_.next_reply(kBridgeLookUp);
    if (!reply) co_return Seen::otherwise(reply.error());
    told = told || reply->id == *breaking;
    if (reply->id != *measuring) continue;
    const Seen seen = expect_refusal(reply, ErrorCode::BeamBroken, *measuring);
    if (!seen.fault.empty()) co_return seen;
    broken = true;
  }
  if (!broken || !told) co_return Seen::otherwise("not every request was answered");
  if (!line_.has_seen(EventKind::BeamLost)) co_return Seen::otherwise("no event beam-lost came");
  const drivers::TimePoint back = clock_.now() + rehearse.lasts + 200ms;
  co_await clock_.sleep_until(back);
  const auto found = co_await aim_at(*options_.reflector_mm, options_.search_mm, 10s);
  co_return kept_where(found);
}

Trial Examination::comes_back() {
  line_.close();
  const drivers::TimePoint again = clock_.now() + 200ms;
  co_await clock_.sleep_until(again);
  const auto back = co_await reconnect();
  if (!back) co_return Seen::otherwise(back.error());
  const Seen alive = co_await lives();
  co_return alive;
}

const std::vector<Examination::Promise> Examination::kPromises{
    {"requests before hello are refused", &Examination::hello_comes_first,
     "answer bad-request to whatever comes before hello"},
    {"hello is answered", &Examination::greets, "see hello in proto/bridge/README.md"},
    {"a newer client is answered in the version that the bridge speaks", &Examination::speaks_what_it_can,
     "answer hello with the lower of the client's protocol and the bridge's"},
    {"ping is answered within a second", &Examination::lives, "answer ping from the thread that reads"},
    {"status is told", &Examination::tells_status, "see status in proto/bridge/README.md"},
    {"a line that is no JSON is refused, with id null", &Examination::refuses_no_json,
     "answer bad-request with id null, and go on with the next line"},
    {"a request without id is refused, with id null", &Examination::refuses_no_id,
     "answer bad-request with id null, and go on with the next line"},
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
    {"a reflector is selected", &Examination::takes_reflector, "select it, and tell it in status"},
    {"the air is taken", &Examination::takes_air,
     "hand it to the SDK, which corrects distances by it; where it cannot, correct them yourself"},
    {"the tracker is initialised", &Examination::initialises,
     "answer initialise once it is done, within two minutes, and tell it in status"},
    {"a reflector is found where it stands", &Examination::aims,
     "see that one stands there: mm, right-handed, in the tracker's own frame"},
    {"a search beside it is refused", &Examination::misses,
     "search no farther than search_mm and no longer than timeout_ms, then answer no-target"},
    {"a point is measured", &Examination::measures, "see measure in proto/bridge/README.md"},
    {"ping is answered during a measurement", &Examination::lives_while_it_measures,
     "run the SDK's calls on a thread of their own"},
    {"a second measurement is refused as busy", &Examination::is_busy_while_it_measures,
     "refuse at once what the tracker cannot do beside what is under way"},
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
    const auto anew = co_await reconnect();
    if (anew) continue;
    verdicts.push_back({"a new connection after that", Conformance::Failed, anew.error(),
                        "restart the bridge, and see why it takes no client any more"});
    break;
  }
  co_return verdicts;
}

}  // namespace

asio::awaitable<std::expected<std::vector<BridgeVerdict>, std::string>> check_bridge(
    asio::any_io_executor executor, drivers::Clock& clock, BridgeCheckOptions options) {
  Examination examination{executor, clock, std::move(options)};
  auto verdicts = co_await examination.run();
  co_return verdicts;
}

}  // namespace truepose::tools
