#include "proto/bridge/messages.hpp"

#include <algorithm>
#include <boost/json/value.hpp>
#include <cmath>
#include <utility>

#include "core/formatted.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::bridge {

namespace json = boost::json;

// ---- Layouts

/// By whole milliseconds.
constexpr record::Whole kMs{0, 86'400'000};
/// mm; no tracker reaches farther.
constexpr record::Range kReach{-1e6, 1e6};

void layout(record::Io&, Done&) {}
void layout(record::Io&, GetStatus&) {}
void layout(record::Io&, Initialise&) {}
void layout(record::Io&, Stop&) {}
void layout(record::Io&, Ping&) {}

void layout(record::Io& io, Hello& x) {
  io("protocol", x.protocol, record::kNumber);
  io("client", x.client, record::MayBeEmpty{});
}
void layout(record::Io& io, Greeting& x) {
  io("protocol", x.protocol, record::kNumber);
  io("bridge", x.bridge);
  io("model", x.model);
  io("serial", x.serial);
  io("firmware", x.firmware, record::MayBeEmpty{});
  io.optional("rehearses", x.rehearses, kRehearsals);
}
void layout(record::Io& io, Status& x) {
  io("state", x.state, kStates);
  io.optional("why", x.why);
  io("initialised", x.initialised);
  io("locked", x.locked);
  io("face", x.face, record::Whole{0, 2});
  io("reflector", x.reflector, record::MayBeEmpty{});
  io("reflectors", x.reflectors);
}
void check(const record::Io& io, const Status& x) {
  const bool silent = x.state == State::WarmingUp || x.state == State::NotReady;
  if (silent && x.why.empty()) io.fail("missing key 'why' with this state");
}
void layout(record::Io& io, SetReflector& x) { io("name", x.name); }
/// Without limits: drivers/plausible_point reports impossible values and what to do.
void layout_air(record::Io& io, Air& air) {
  io("temperature_c", air.temperature_c);
  io("pressure_mbar", air.pressure_mbar);
  io("humidity_percent", air.humidity_percent);
}
void layout(record::Io& io, SetAir& x) { layout_air(io, x.air); }
void layout(record::Io& io, DoAim& x) {
  record::layout_xyz(io, x.p_W_mm, kReach);
  io("search_mm", x.search_mm, record::Range{0, kReach.max});
  io("timeout_ms", x.timeout, kMs);
}
void layout(record::Io& io, DoMeasure& x) { io("time_ms", x.time, kMs); }
void layout(record::Io& io, Orientation& x) {
  io("w", x.w);
  io("x", x.x);
  io("y", x.y);
  io("z", x.z);
  io("std_deg", x.std_deg, record::kNotNegative);
}
void check(const record::Io& io, const Orientation& x) {
  if (const std::string fault = orientation_fault(x); !fault.empty()) io.fail(fault);
}
void layout(record::Io& io, Measured& x) {
  record::layout_xyz(io, x.p_W_mm, kReach);
  io.optional("std_mm", x.std_mm, record::Xyz{record::kNotNegative});
  io.optional("covariance_mm2", x.covariance_mm2);
  io.optional("orientation", x.orientation);
  io("averaged_ms", x.averaged, kMs);
  io("age_ms", x.age, kMs);
  layout_air(io, x.air);
}
void check(const record::Io& io, const Measured& x) {
  if (x.std_mm.has_value() == x.covariance_mm2.has_value())
    io.fail("expected one of std_mm and covariance_mm2");
  if (!x.covariance_mm2) return;
  if (const std::string fault = covariance_fault(*x.covariance_mm2); !fault.empty())
    io.fail_at("covariance_mm2", fault);
}
void layout(record::Io& io, SetFace& x) { io("face", x.face, record::Whole{1, 2}); }
void layout(record::Io& io, Rehearse& x) {
  io("what", x.what, kRehearsals);
  io("lasts_ms", x.lasts, kMs);
}
void layout(record::Io& io, Refusal& x) {
  io("code", x.code);
  io("text", x.text, record::MayBeEmpty{});
}
void layout(record::Io& io, Event& x) {
  io("event", x.event);
  io.optional("text", x.text);
}

namespace {

template <class Value, std::size_t N>
std::optional<Value> find(const std::array<Named<Value>, N>& table, std::string_view name) {
  const auto found = std::ranges::find(table, name, &Named<Value>::name);
  return found == table.end() ? std::nullopt : std::optional{found->value};
}

BadRequestReply bad_request_reply(std::optional<std::int64_t> id, ErrorCode code, std::string text) {
  return {id, Refusal::of(code, std::move(text))};
}

/// How the line of a request begins.
struct RequestHead {
  std::int64_t id = 0;
  std::string name;
};
void layout(record::Io& io, RequestHead& x) {
  io("id", x.id, record::Whole{1, INT64_MAX});
  io("do", x.name);
}

/// The same of what a bridge sends.
struct BridgeHead {
  std::optional<std::int64_t> id;  ///< none in a refusal of what could not be read
  std::optional<bool> ok;
  std::optional<std::string> event{};
};
void layout(record::Io& io, BridgeHead& x) {
  io.nullable("id", x.id, record::Whole{1, INT64_MAX});
  io.optional("ok", x.ok);
  io.optional("event", x.event);
}

std::string line_of(const auto& head, const json::object& members) {
  json::object line = record::to_json(head);
  line.insert(members.begin(), members.end());
  return control::json_text(line);
}

/// The request of the kind at this place among all.
template <std::size_t kKind = 0>
std::expected<Asked, BadRequestReply> decode_kind(std::int64_t id, std::string_view name,
                                                  const json::value& line) {
  if constexpr (kKind == std::variant_size_v<Request>) {
    return std::unexpected(
        bad_request_reply(id, ErrorCode::NotOffered, "there is no request \"" + std::string{name} + "\""));
  } else {
    using Kind = std::variant_alternative_t<kKind, Request>;
    if (name != Kind::kName) return decode_kind<kKind + 1>(id, name, line);
    auto request = record::from_json<Kind>(line);
    if (!request)
      return std::unexpected(bad_request_reply(id, ErrorCode::BadRequest,
                                               std::string{name} + ": " + std::move(request.error())));
    return Asked{id, *std::move(request)};
  }
}

}  // namespace

Eigen::Vector3d Measured::deviations_mm() const {
  if (std_mm) return *std_mm;
  const Eigen::Matrix<double, 6, 1>& c = *covariance_mm2;
  return Eigen::Vector3d{c[0], c[3], c[5]}.cwiseSqrt();
}

std::string covariance_fault(const Eigen::Matrix<double, 6, 1>& c) {
  constexpr double kRounding = 1e-9;
  const double xx = c[0], xy = c[1], xz = c[2], yy = c[3], yz = c[4], zz = c[5];
  const auto at_most = [](double product, double of_squares) {
    return product * product <= of_squares * (1 + kRounding);
  };
  const double determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  const bool is_one = xx >= 0 && yy >= 0 && zz >= 0 && at_most(xy, xx * yy) && at_most(xz, xx * zz) &&
                      at_most(yz, yy * zz) && determinant >= -kRounding * xx * yy * zz;
  return is_one ? "" : "is the covariance of nothing: expected xx, xy, xz, yy, yz, zz";
}

std::string orientation_fault(const Orientation& o) {
  constexpr double kRounding = 1e-4;  // of a bridge that writes five digits
  const double norm = std::sqrt(o.w * o.w + o.x * o.x + o.y * o.y + o.z * o.z);
  if (std::abs(norm - 1) <= kRounding) return {};
  return formatted("is no unit quaternion: the length of w, x, y, z is %.4f", norm);
}

ErrorCode Refusal::meaning() const { return find(kErrorCodes, code).value_or(ErrorCode::Failed); }

std::optional<EventKind> Event::kind() const { return find(kEvents, event); }

std::string request_line(std::int64_t id, std::string_view name, json::object members) {
  return line_of(RequestHead{id, std::string{name}}, members);
}

std::string answer_line(std::int64_t id, json::object members) {
  return line_of(BridgeHead{id, true}, members);
}

std::string encode_refusal(std::optional<std::int64_t> id, const Refusal& refusal) {
  return line_of(BridgeHead{id, false}, record::to_json(refusal));
}

std::string encode(const Event& event) { return control::json_text(record::to_json(event)); }

std::expected<Asked, BadRequestReply> decode_request(std::string_view line) {
  const auto parsed = control::parse_json(line);
  if (!parsed) return std::unexpected(bad_request_reply(std::nullopt, ErrorCode::BadRequest, parsed.error()));
  RequestHead head;
  const auto read = record::read_json(*parsed, "", record::Others::Passed, [&](auto& io) { io.value(head); });
  if (read) return decode_kind(head.id, head.name, *parsed);
  const auto id = head.id > 0 ? std::optional{head.id} : std::nullopt;
  return std::unexpected(bad_request_reply(id, ErrorCode::BadRequest, read.error().text));
}

std::expected<FromBridge, std::string> decode_from_bridge(std::string_view line) {
  auto parsed = control::parse_json(line);
  if (!parsed) return std::unexpected(std::move(parsed.error()));
  const auto head = record::from_json<BridgeHead>(*parsed);
  if (!head) return std::unexpected(head.error());
  if (head->event) return record::from_json<Event>(*parsed);
  if (!head->ok) return std::unexpected("expected an event, or ok: true or false");
  if (*head->ok) {
    if (!head->id) return std::unexpected("id: expected that of the request");
    return Reply{head->id, std::move(parsed->as_object())};
  }
  auto refusal = record::from_json<Refusal>(*parsed);
  if (!refusal) return std::unexpected(std::move(refusal.error()));
  return Reply{head->id, std::unexpected(*std::move(refusal))};
}

}  // namespace truepose::bridge
