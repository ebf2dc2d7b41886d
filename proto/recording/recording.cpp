#include "proto/recording/recording.hpp"

#include <boost/crc.hpp>
#include <boost/json/value.hpp>
#include <charconv>
#include <optional>

#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "proto/recording/block.hpp"

namespace truepose::recording {
namespace {

constexpr std::string_view kMagic = "truepose recording 2\n";
/// Without what was asked of the drivers: its kinds of records are among those of version 2.
constexpr std::string_view kMagicOfVersion1 = "truepose recording 1\n";
static_assert(kMagic.size() == kMagicOfVersion1.size());
constexpr std::size_t kBlockHead = 8;

constexpr std::array kEngagements{
    Named{"off", Commands::Engagement::Off}, Named{"leaving", Commands::Engagement::Leaving},
    Named{"on", Commands::Engagement::On}, Named{"armed", Commands::Engagement::Armed}};

std::uint32_t checksum(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

void append_u32(std::string& out, std::size_t number) {
  for (unsigned shift = 0; shift < 32; shift += 8) out += static_cast<char>(number >> shift);
}

std::uint32_t u32_at(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 4; i-- > 0;) number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

/// What follows; nothing where it is no whole block.
std::optional<std::string_view> block_at(std::string_view bytes, std::size_t begin) {
  const std::string_view rest = bytes.substr(begin);
  if (rest.size() < kBlockHead || rest.size() - kBlockHead < u32_at(rest, 0)) return std::nullopt;
  const std::string_view block = rest.substr(kBlockHead, u32_at(rest, 0));
  if (checksum(block) != u32_at(rest, 4)) return std::nullopt;
  return block;
}

std::string unreadable(const char* what, std::size_t at, std::size_t size) {
  return std::string{what} + " at byte " + std::to_string(at) + " of " + std::to_string(size);
}

}  // namespace

void layout(auto& io, record::Is<Device> auto& x) {
  io("model", x.model);
  io("serial", x.serial);
  io("software", x.software);
}

void layout(auto& io, record::Is<Model> auto& x) {
  io("number", x.number);
  io("id", x.id);
  io("sha256", x.sha256);
  io("yaml", x.yaml);
}

void layout(auto& io, record::Is<Header> auto& x) {
  io("product", x.product);
  io("cell", x.cell);
  io("date", x.date);
  io("time_ns", x.time_ns, record::Whole{INT64_MIN, INT64_MAX});
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

std::string block(std::string_view records) {
  std::string out;
  append_u32(out, records.size());
  append_u32(out, checksum(records));
  out += records;
  return out;
}

std::string first_block(const Header& header) {
  return std::string{kMagic} + block(control::json_text(record::to_json(header)));
}

std::string last_block() { return block({}); }

std::expected<Header, std::string> Recording::read_header(std::string_view bytes) {
  if (!bytes.starts_with(kMagic) && !bytes.starts_with(kMagicOfVersion1))
    return std::unexpected("is no recording of truepose, of this version");
  const auto header = block_at(bytes, kMagic.size());
  if (!header) return std::unexpected("is damaged, or cut off, in its header");
  const auto document = control::parse_json(*header);
  if (!document) return std::unexpected("header: " + document.error());
  auto read = record::from_json<Header>(*document, "header");
  if (!read) return std::unexpected(read.error());
  return read;
}

std::expected<Recording, std::string> Recording::read(std::string bytes) {
  auto header = read_header(bytes);
  if (!header) return std::unexpected(header.error());
  Recording recording;
  recording.header_ = *std::move(header);
  recording.begin_ = kMagic.size() + kBlockHead + u32_at(bytes, kMagic.size());
  recording.bytes_ = std::move(bytes);
  return recording;
}

std::string Recording::for_each(const std::function<void(const Record& record)>& take) const {
  for (std::size_t at = begin_;;) {
    const auto block = block_at(bytes_, at);
    if (!block) return unreadable("damaged, or cut off,", at, bytes_.size());
    if (block->empty()) return {};
    BlockReader reader{*block};
    auto record = reader.next();
    for (; record && *record; record = reader.next()) take(**record);
    if (!record) return unreadable(record.error().c_str(), at, bytes_.size());
    at += kBlockHead + block->size();
  }
}

}  // namespace truepose::recording
