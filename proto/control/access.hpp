#pragma once

#include <array>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "core/named.hpp"

namespace truepose::control {

/// What a client may do. Each may do what the ones before may.
enum class Role {
  Viewer,    ///< sees everything but secrets
  Operator,  ///< moves the arm, starts and stops
  Engineer,  ///< chooses the model that corrects
  Admin,     ///< whatever there is, as who has the token file
};
inline constexpr std::array kRoles{Named{"viewer", Role::Viewer}, Named{"operator", Role::Operator},
                                   Named{"engineer", Role::Engineer}, Named{"admin", Role::Admin}};
inline std::string_view name(Role role) { return name_of(kRoles, role); }

/// A person or a panel that may open sessions: by a token, of which a salted hash is kept, or by the
/// certificate that it shows over TLS.
struct AccessEntry {
  std::string name;
  Role role = Role::Viewer;
  std::string salt, hash;     ///< hexadecimal; the hash is SHA-256 of the salt, a newline and the token
  std::string certificate{};  ///< its fingerprint

  bool operator==(const AccessEntry&) const = default;
};

/// Who may open sessions, each name once.
struct AccessEntries {
  std::vector<AccessEntry> entries;

  const AccessEntry* of_token(std::string_view token) const;
  const AccessEntry* of_certificate(std::string_view fingerprint) const;
  const AccessEntry* named(std::string_view name) const;
};

/// Tokens of entries begin with it: clients tell by it that the daemon knows the hash alone, which can check
/// no proof, so that they have to send the token.
inline constexpr std::string_view kAccessTokenStart = "access-";
std::string new_access_token();

/// The token in a token file: 16 to 1024 bytes without white space, which is dropped around them.
/// @return it, or one phrase
std::expected<std::string, std::string> token_in(std::string_view text);

// What the daemon calls itself and those who need no entry: no entry has such a name, in whatever case.
inline constexpr const char* kDaemonName = "trueposed";
inline constexpr const char* kTokenFileName = "token file";  ///< who shows the token file's token
inline constexpr const char* kLocalUserStart = "uid ";       ///< and a number: who comes over the Unix socket

/// Why this cannot be a user's name; empty: it can.
std::string access_name_fault(const std::string& name);

/// An entry for a token: a new salt, and the hash.
AccessEntry entry_for_token(std::string name, Role role, std::string_view token);

/// Compares in a time that depends on the length of `given` alone, so that a guess learns nothing from it.
bool same_secret(std::string_view given, std::string_view secret);

/// The access file (JSON). The error is one phrase.
std::expected<AccessEntries, std::string> read_access(std::string_view text);
std::string access_text(const AccessEntries& access);

}  // namespace truepose::control
