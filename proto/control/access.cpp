#include "proto/control/access.hpp"

#include <algorithm>

#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "proto/text/device_text.hpp"
#include "proto/text/digest.hpp"
#include "proto/text/random_bytes.hpp"

namespace truepose::control {

struct Sha256Digits {
  std::string fault(const std::string& text) const {
    const bool digits = text.find_first_not_of("0123456789abcdef") == std::string::npos;
    return text.size() == 64 && digits ? "" : "expected 64 digits, 0-9 and a-f";
  }
};

struct AccessName {
  std::string fault(const std::string& text) const { return access_name_fault(text); }
};

void layout(record::Io& io, AccessEntry& x) {
  io("name", x.name, AccessName{});
  io("role", x.role, kRoles);
  io.optional("salt", x.salt);
  io.optional("hash", x.hash, Sha256Digits{});
  io.optional("certificate", x.certificate, Sha256Digits{});
}
void check(const record::Io& io, const AccessEntry& x) {
  const bool by_token = !x.salt.empty() && !x.hash.empty(), nothing_of_it = x.salt.empty() && x.hash.empty();
  if (x.certificate.empty() ? !by_token : !nothing_of_it)
    io.fail("expected salt and hash of a token, or the fingerprint of a certificate");
}

void layout(record::Io& io, AccessEntries& x) { io("access", x.entries); }
void check(const record::Io& io, const AccessEntries& x) {
  for (const AccessEntry& entry : x.entries) {
    if (x.named(entry.name) != &entry) io.fail("\"" + entry.name + "\" stands there twice");
  }
}

namespace {

std::string token_hash(std::string_view salt, std::string_view token) {
  return text::sha256_hex(std::string{salt} + "\n" + std::string{token});
}

template <typename Fits>
const AccessEntry* first(const std::vector<AccessEntry>& entries, Fits fits) {
  const auto found = std::ranges::find_if(entries, fits);
  return found == entries.end() ? nullptr : &*found;
}

}  // namespace

const AccessEntry* AccessEntries::of_token(std::string_view token) const {
  return first(entries, [&](const AccessEntry& entry) {
    return entry.certificate.empty() && same_secret(token_hash(entry.salt, token), entry.hash);
  });
}

const AccessEntry* AccessEntries::of_certificate(std::string_view fingerprint) const {
  return first(entries, [&](const AccessEntry& entry) {
    return !fingerprint.empty() && entry.certificate == fingerprint;
  });
}

const AccessEntry* AccessEntries::named(std::string_view name) const {
  return first(entries, [&](const AccessEntry& entry) { return entry.name == name; });
}

std::string new_access_token() { return std::string{kAccessTokenStart} + random_hex(16, kernel_random); }

std::expected<std::string, std::string> token_in(std::string_view text) {
  constexpr std::size_t kShortest = 16, kLongest = 1024;
  constexpr std::string_view kSpace = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
  text = text.substr(0, text.find_last_not_of(kSpace) + 1);
  if (text.find_first_of(kSpace) != text.npos)
    return std::unexpected("the token must be one word, without blanks inside");
  if (text.size() < kShortest || text.size() > kLongest)
    return std::unexpected("the token must have " + std::to_string(kShortest) + ".." +
                           std::to_string(kLongest) + " characters");
  return std::string{text};
}

std::string access_name_fault(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  if (name.empty() || name.size() > kLongest || text::device_text(name) != name)
    return "expected 1 to 64 bytes of UTF-8 without control characters, and no blank at either end";
  std::string lower = name;
  std::ranges::transform(lower, lower.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
  });
  const bool reserved = lower == kTokenFileName || lower == kDaemonName || lower.starts_with(kLocalUserStart);
  return reserved ? "the daemon itself uses this name; take another" : "";
}

AccessEntry entry_for_token(std::string name, Role role, std::string_view token) {
  const std::string salt = random_hex(16, kernel_random);
  return {std::move(name), role, salt, token_hash(salt, token)};
}

bool same_secret(std::string_view given, std::string_view secret) {
  volatile unsigned difference = given.size() == secret.size() ? 0 : 1;
  for (std::size_t i = 0; i < given.size(); ++i)
    difference = difference | static_cast<unsigned>(given[i] ^ secret[i % secret.size()]);
  return difference == 0;
}

std::expected<AccessEntries, std::string> read_access(std::string_view text) {
  const auto document = parse_json(text);
  if (!document) return std::unexpected(document.error());
  return record::from_json<AccessEntries>(*document);
}

std::string access_text(const AccessEntries& access) { return json_text(record::to_json(access)) + "\n"; }

}  // namespace truepose::control
