#include "proto/recording/recording.hpp"

#include <algorithm>
#include <boost/json/value.hpp>
#include <charconv>
#include <optional>

#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::recording {
namespace {

constexpr std::uint32_t kNotes = static_cast<std::uint32_t>(Wire::Daemon);
constexpr std::string_view kHeader = "header ", kEnd = "end";
constexpr std::size_t kMostHeaderPart = 60'000;

constexpr std::array kEngagements{
    Named{"off", Commands::Engagement::Off}, Named{"leaving", Commands::Engagement::Leaving},
    Named{"on", Commands::Engagement::On}, Named{"armed", Commands::Engagement::Armed}};

std::string note_block(std::int64_t utc_ns, std::string_view text) {
  return packet_block({.interface = kNotes, .utc_ns = utc_ns, .bytes = text});
}

/// The JSON of the header, whose parts come before all else. Empty: there is none, or it is cut off.
std::string header_text(std::string_view bytes) {
  PacketReader packets{bytes};
  std::string text;
  for (;;) {
    const auto packet = packets.next();
    if (!packet || !*packet || (*packet)->interface != kNotes || !(*packet)->bytes.starts_with(kHeader))
      return text;
    text += (*packet)->bytes.substr(kHeader.size());
  }
}

/// "rsi commands on 0 1 1"
std::optional<Record> read_note(std::string_view text, std::int64_t time_ns) {
  const auto word = [&] {
    const std::size_t space = text.find(' ');
    const std::string_view taken = text.substr(0, space);
    text.remove_prefix(space == std::string_view::npos ? text.size() : space + 1);
    return taken;
  };
  const std::string_view wire = word(), kind = word();
  const auto is_named = [](const auto& table, std::string_view name) {
    const auto names = names_of(table);
    return std::ranges::find(names, name) != names.end();
  };
  if (!is_named(kWires, wire) || !is_named(kKinds, kind)) return std::nullopt;
  return Record{.time_ns = time_ns,
                .wire = value_of(kWires, wire),
                .kind = value_of(kKinds, kind),
                .bytes = std::string{text}};
}

/// Nothing of a packet that only makes a connection whole.
std::optional<Record> read_wire(const Packet& packet, std::int64_t time_ns) {
  const auto content = read_packet(packet.bytes);
  if (!content || packet.interface >= kNotes) return std::nullopt;
  const bool is_received = packet.direction == Direction::Inbound;
  Record record{.time_ns = time_ns,
                .wire = static_cast<Wire>(packet.interface),
                .kind = is_received ? Kind::Received : Kind::Sent,
                .bytes = std::string{content->payload}};
  if (!content->is_tcp) {
    if (is_received) record.peer = content->from;
    return record;
  }
  if (content->flags == kSyn) {
    record.kind = Kind::Connected;
    record.bytes = text(content->from) + ' ' + text(content->to);
  } else if (content->flags & kRst) {
    record.kind = Kind::Closed;
  } else if (content->payload.empty()) {
    return std::nullopt;
  }
  return record;
}

}  // namespace

void layout(record::Io& io, Device& x) {
  io("model", x.model);
  io("serial", x.serial);
  io("software", x.software);
}

void layout(record::Io& io, Model& x) {
  io("number", x.number);
  io("id", x.id);
  io("sha256", x.sha256);
  io("yaml", x.yaml);
}

void layout(record::Io& io, Header& x) {
  io("product", x.product);
  io("cell", x.cell);
  io("date", x.date);
  io("time_ns", x.time_ns, record::Whole{INT64_MIN, INT64_MAX});
  io("clock_origin_ns", x.clock_origin_ns, record::Whole{INT64_MIN, INT64_MAX});
  io("reason", x.reason);
  io("robot", x.robot);
  io("tracker", x.tracker);
  io("ethernet_xml", x.ethernet_xml);
  io("nominal_yaml", x.nominal_yaml);
  io("stream", x.stream);
  io("models", x.models);
}

std::string text(const Commands& commands) {
  return std::string{name_of(kEngagements, commands.engagement)} + ' ' +
         std::to_string(commands.acknowledged) + ' ' + std::to_string(commands.model) + ' ' +
         std::to_string(commands.models);
}

std::expected<Commands, std::string> read_commands(std::string_view text) {
  const std::string_view word = text.substr(0, text.find(' '));
  const char *at = word.data() + word.size(), *const end = text.data() + text.size();
  const auto number = [&](std::uint64_t& into) {
    if (at == end || *at != ' ') return false;
    const auto [rest, fault] = std::from_chars(at + 1, end, into);
    at = rest;
    return fault == std::errc{};
  };
  Commands commands;
  const auto names = names_of(kEngagements);
  if (std::ranges::find(names, word) == names.end() || !number(commands.acknowledged) ||
      !number(commands.model) || !number(commands.models) || at != end)
    return std::unexpected("commands that cannot be read: \"" + std::string{text} + "\"");
  commands.engagement = value_of(kEngagements, word);
  return commands;
}

std::string head(const Header& header, std::int64_t begin_ns) {
  std::string out = section_block("truepose " + header.product,
                                  "cell " + header.cell + ", " + header.date + ": " + header.reason);
  for (const auto& [name, wire] : kWires)
    out += interface_block(name, wire == Wire::Daemon ? LinkType::User0 : LinkType::Raw);
  const std::string json = control::json_text(record::to_json(header));
  for (std::size_t at = 0; at < json.size(); at += kMostHeaderPart)
    out += note_block(header.clock_origin_ns + begin_ns,
                      std::string{kHeader} + json.substr(at, kMostHeaderPart));
  return out;
}

std::string tail(const Header& header) { return note_block(header.clock_origin_ns + header.time_ns, kEnd); }

std::string_view RecordWriter::blocks(const Record& record) {
  blocks_.clear();
  const bool is_unanswered = record.wire == Wire::Rsi && record.bytes.empty();
  switch (record.kind) {
    case Kind::Received:
    case Kind::Sent:
      if (is_unanswered || record.wire == Wire::Daemon) {
        note(record);
      } else if (record.wire == Wire::Rsi) {
        datagram(record);
      } else {
        segments(record, record.kind == Kind::Received ? Direction::Inbound : Direction::Outbound);
      }
      break;
    case Kind::Connected:
      connected(record);
      break;
    case Kind::Closed:
      segment(record, Direction::Outbound, kRst | kAck);
      break;
    default:
      note(record);
  }
  return blocks_;
}

void RecordWriter::packet(const Record& record, Direction direction, std::string_view bytes) {
  blocks_ += packet_block({.interface = static_cast<std::uint32_t>(record.wire),
                           .utc_ns = clock_origin_ns_ + record.time_ns,
                           .direction = direction,
                           .bytes = bytes});
}

void RecordWriter::note(const Record& record) {
  blocks_ += note_block(clock_origin_ns_ + record.time_ns, std::string{name_of(kWires, record.wire)} + ' ' +
                                                               std::string{name_of(kKinds, record.kind)} +
                                                               ' ' + record.bytes);
}

void RecordWriter::datagram(const Record& record) {
  Connection& controller = connections_[static_cast<std::size_t>(record.wire)];
  const bool is_received = record.kind == Kind::Received;
  if (is_received) controller.remote = record.peer.value_or(Endpoint{});
  const IpPacket sent{.from = rsi_, .to = controller.remote, .payload = record.bytes};
  const IpPacket received{.from = controller.remote, .to = rsi_, .payload = record.bytes};
  packet(record, is_received ? Direction::Inbound : Direction::Outbound,
         bytes_of(is_received ? received : sent));
}

void RecordWriter::connected(const Record& record) {
  Connection& connection = connections_[static_cast<std::size_t>(record.wire)];
  const std::size_t space = record.bytes.find(' ');
  connection = {.local = read_endpoint(record.bytes.substr(0, space)).value_or(Endpoint{}),
                .remote = space == std::string::npos
                              ? Endpoint{}
                              : read_endpoint(record.bytes.substr(space + 1)).value_or(Endpoint{})};
  segment(record, Direction::Outbound, kSyn);
  ++connection.sent;
  segment(record, Direction::Inbound, kSyn | kAck);
  ++connection.received;
  segment(record, Direction::Outbound, kAck);
}

void RecordWriter::segments(const Record& record, Direction direction) {
  Connection& connection = connections_[static_cast<std::size_t>(record.wire)];
  for (std::string_view rest = record.bytes; !rest.empty();) {
    const std::string_view part = rest.substr(0, kMostPayload);
    segment(record, direction, kPsh | kAck, part);
    (direction == Direction::Inbound ? connection.received : connection.sent) +=
        static_cast<std::uint32_t>(part.size());
    rest.remove_prefix(part.size());
  }
}

void RecordWriter::segment(const Record& record, Direction direction, std::uint8_t flags,
                           std::string_view payload) {
  const Connection& connection = connections_[static_cast<std::size_t>(record.wire)];
  const bool is_received = direction == Direction::Inbound;
  packet(record, direction,
         bytes_of({.from = is_received ? connection.remote : connection.local,
                   .to = is_received ? connection.local : connection.remote,
                   .is_tcp = true,
                   .sequence = is_received ? connection.received : connection.sent,
                   .acknowledged = flags == kSyn ? 0
                                   : is_received ? connection.sent
                                                 : connection.received,
                   .flags = flags,
                   .payload = payload}));
}

std::expected<Header, std::string> Recording::read_header(std::string_view bytes) {
  if (!is_pcapng(bytes)) return std::unexpected("is no recording of truepose");
  const std::string text = header_text(bytes);
  if (text.empty()) return std::unexpected("is no recording of truepose, or cut off in its header");
  const auto document = control::parse_json(text);
  if (!document) return std::unexpected("is damaged, or cut off, in its header: " + document.error());
  return record::from_json<Header>(*document, "header");
}

std::expected<Recording, std::string> Recording::read(std::string bytes) {
  auto header = read_header(bytes);
  if (!header) return std::unexpected(header.error());
  Recording recording;
  recording.header_ = *std::move(header);
  recording.bytes_ = std::move(bytes);
  return recording;
}

std::string Recording::for_each(const std::function<void(const Record& record)>& take) const {
  PacketReader packets{bytes_};
  for (;;) {
    const std::size_t begin = packets.at();
    const auto packet = packets.next();
    const auto at = [&] {
      return " at byte " + std::to_string(begin) + " of " + std::to_string(bytes_.size());
    };
    if (!packet) return packet.error() + at();
    if (!*packet) return "cut off," + at();
    const std::int64_t time_ns = (*packet)->utc_ns - header_.clock_origin_ns;
    if ((*packet)->interface == kNotes && (*packet)->bytes == kEnd) return {};
    const auto record =
        (*packet)->interface == kNotes ? read_note((*packet)->bytes, time_ns) : read_wire(**packet, time_ns);
    if (record) take(*record);
  }
}

}  // namespace truepose::recording
