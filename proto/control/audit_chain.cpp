#include "proto/control/audit_chain.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "proto/control/json_text.hpp"
#include "proto/text/digest.hpp"

namespace truepose::control {

namespace json = boost::json;

std::string audit_line(AuditHead& end, json::object record) {
  json::object line{{"n", ++end.count}, {"before", end.hash}};
  for (auto& [key, value] : record) line[key] = std::move(value);
  // Parentheses: braces around a value make it a list of one.
  const std::string text = json_text(json::value(std::move(line)));
  end.hash = text::sha256_hex(text);
  return text + "\n";
}

namespace {

/// The record in a line; none where it is not the one behind `end`.
std::optional<json::object> record_behind(const AuditHead& end, const std::string& line) {
  auto parsed = parse_json(line);
  if (!parsed || !parsed->is_object()) return std::nullopt;
  const json::object& record = parsed->get_object();
  const json::value *n = record.if_contains("n"), *before = record.if_contains("before");
  if (!n || !before || *n != end.count + 1 || *before != json::value(end.hash)) return std::nullopt;
  return record;
}

}  // namespace

std::optional<AuditHead> audit_base(std::istream& trail) {
  std::string line;
  const bool whole = std::getline(trail, line) && !trail.eof();
  trail.clear();
  trail.seekg(0);
  if (!whole) return std::nullopt;
  const auto parsed = parse_json(line);
  if (!parsed || !parsed->is_object()) return std::nullopt;
  const json::value *n = parsed->get_object().if_contains("n"),
                    *before = parsed->get_object().if_contains("before");
  if (!n || !n->is_int64() || n->get_int64() < 1 || !before || !before->is_string()) return std::nullopt;
  return AuditHead{static_cast<std::uint64_t>(n->get_int64()) - 1, std::string{before->get_string()}};
}

std::expected<AuditHead, std::string> follow_audit(std::istream& trail, AuditHead end,
                                                   const std::function<void(const AuditLine&)>& each) {
  std::uint64_t offset = 0;
  std::string line;
  while (std::getline(trail, line) && !trail.eof()) {
    const auto record = record_behind(end, line);
    if (!record)
      return std::unexpected("record " + std::to_string(end.count + 1) +
                             " was changed, or the one before it");
    end = {end.count + 1, text::sha256_hex(line)};
    offset += line.size() + 1;
    if (each) each({offset, *record, end});
  }
  return end;
}

std::string head_text(const AuditHead& head) {
  std::string number = std::to_string(head.count);
  number.insert(0, 20 - number.size(), '0');  // of one length, so that it is written over in place
  return number + " " + head.hash + "\n";
}

std::expected<AuditHead, std::string> read_head(std::string_view text) {
  constexpr std::size_t kNumber = 20, kHash = 64;
  AuditHead head;
  const auto read = std::from_chars(text.data(), text.data() + std::min(kNumber, text.size()), head.count);
  if (text.size() == kNumber + kHash + 2) head.hash = text.substr(kNumber + 1, kHash);
  if (read.ec != std::errc{} || head_text(head) != text)
    return std::unexpected("is not the end of an audit trail");
  return head;
}

}  // namespace truepose::control
