// Lines of a tracker's bridge, either way. An accepted line can be written and read again as the same; a
// rejected one has a reason.
#include <algorithm>
#include <boost/json/parse.hpp>
#include <cmath>
#include <string>
#include <variant>

#include "proto/bridge/messages.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/line_splitter.hpp"
#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {
namespace {

namespace json = boost::json;
using bridge::FromBridge, bridge::Reply, bridge::Request;

/// But for the last digit of a number, which Boost.JSON reads to within a unit of it.
bool alike(const json::value& a, const json::value& b) {
  if (a.is_double() && b.is_double())
    return std::abs(a.as_double() - b.as_double()) <= 1e-15 * std::abs(a.as_double());
  if (a.is_object() && b.is_object()) {
    return std::ranges::equal(a.as_object(), b.as_object(), [](const auto& one, const auto& other) {
      return one.key() == other.key() && alike(one.value(), other.value());
    });
  }
  if (a.is_array() && b.is_array()) return std::ranges::equal(a.as_array(), b.as_array(), alike);
  return a == b;
}

bool alike(const std::string& a, const std::string& b) { return alike(json::parse(a), json::parse(b)); }

std::string written(const bridge::Asked& asked) {
  return std::visit([&](const auto& request) { return bridge::encode(asked.id, request); }, asked.request);
}

void read_bridge_request(const std::string& line) {
  const auto asked = bridge::decode_request(line);
  if (!asked) {
    const std::string answer = bridge::encode_refusal(asked.error().id, asked.error().refusal);
    const auto refusal = bridge::decode_from_bridge(answer);
    expect(refusal && !std::get<Reply>(*refusal).outcome, "a refusal can be read: " + answer);
    const auto codes = names_of(bridge::kErrorCodes);
    expect(std::ranges::count(codes, asked.error().refusal.code) == 1, "a refusal has a code");
    return;
  }
  const std::string text = written(*asked);
  const auto again = bridge::decode_request(text);
  expect(again && alike(written(*again), text), "a request that is written is read again: " + text);
}

/// Read as the answer to every request, where it can be.
template <std::size_t kKind = 0>
void read_answer(const Reply& reply) {
  if constexpr (kKind < std::variant_size_v<Request>) {
    using Kind = std::variant_alternative_t<kKind, Request>;
    if (const auto answer = bridge::answer_of<Kind>(*reply.outcome)) {
      const std::string text = bridge::encode_answer(*reply.id, *answer);
      const auto again = bridge::decode_from_bridge(text);
      expect(again.has_value(), "an answer that is written is read again: " + text);
      const auto same = bridge::answer_of<Kind>(*std::get<Reply>(*again).outcome);
      expect(same && alike(bridge::encode_answer(*reply.id, *same), text), "and is the same: " + text);
    } else {
      expect(!answer.error().empty(), "a fault says what");
    }
    read_answer<kKind + 1>(reply);
  }
}

void read_from_bridge(const std::string& line) {
  const auto message = bridge::decode_from_bridge(line);
  if (!message) return expect(!message.error().empty(), "a fault says what");
  if (const auto* event = std::get_if<bridge::Event>(&*message)) {
    const auto again = bridge::decode_from_bridge(bridge::encode(*event));
    return expect(again && std::get<bridge::Event>(*again).event == event->event, "an event is read again");
  }
  const auto& reply = std::get<Reply>(*message);
  if (reply.outcome) return read_answer(reply);
  const auto again = bridge::decode_from_bridge(bridge::encode_refusal(reply.id, reply.outcome.error()));
  expect(again && std::get<Reply>(*again).id == reply.id, "a refusal is read again");
}

}  // namespace

void bridge(std::string_view input) {
  control::LineSplitter lines{bridge::kMaxLine};
  lines.push(input);
  while (const auto line = lines.next()) {
    read_bridge_request(*line);
    read_from_bridge(*line);
  }
}

}  // namespace truepose::fuzz
