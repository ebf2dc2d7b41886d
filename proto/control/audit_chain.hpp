#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <expected>
#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <string_view>

namespace truepose::control {

/// Where an audit trail ends: how many records it has, and the SHA-256 of the last line.
struct AuditHead {
  std::uint64_t count = 0;
  std::string hash = std::string(64, '0');

  bool operator==(const AuditHead&) const = default;
};

/// The line of a record behind a trail's end, newline included: the record with `n`, its number from 1, and
/// `before`, the hash of the line before. Moves the end on.
std::string audit_line(AuditHead& end, boost::json::object record);

/// One line of a trail; an empty trail has none.
struct AuditLine {
  std::uint64_t end = 0;  ///< offset of the byte behind it
  boost::json::object record;
  AuditHead head;  ///< of the trail that ends with it
};

/// Where a file of a trail begins: behind which record its first line was written. None: it has no line, or
/// its first one is no record. Leaves the stream at its beginning.
std::optional<AuditHead> audit_base(std::istream& trail);

/// Reads a trail, or a file of it that begins behind `base`, line by line, and sees that each is the one that
/// was written behind the line before. A last line that does not end is none.
/// @return its end; else which record is not what was written: "record 17 was changed, or the one before it"
std::expected<AuditHead, std::string> follow_audit(std::istream& trail, AuditHead base,
                                                   const std::function<void(const AuditLine&)>& each = {});

/// The end of a trail, in a file of its own: only it shows that a trail lost its last lines.
std::string head_text(const AuditHead& head);
std::expected<AuditHead, std::string> read_head(std::string_view text);

}  // namespace truepose::control
