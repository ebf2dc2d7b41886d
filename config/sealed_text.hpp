#pragma once

#include <string>

#include "config/document_kind.hpp"

namespace truepose::config {

/// The text with its own SHA-256 as the last line, `sha256: HEX`. Files that decide joint angles carry it:
/// one changed digit can lead an arm wrong by hundreds of millimetres.
std::string sealed(const std::string& text);

/// Whether a text is the one that sealed() wrote, from its first byte to the last.
bool has_its_seal(const std::string& text);

/// The same, for who reads a file.
///
/// @param name    of the text, in the message
/// @param remedy  how it is made again: "identify again"
/// Throws ConfigError.
void check_seal(const std::string& text, const std::string& name, const std::string& remedy);

/// What stands in such a text before the last line. Throws ConfigError, also where it is of another kind.
YamlValue parse_sealed(const std::string& text, const std::string& name, DocumentKind kind,
                       const std::string& remedy);

}  // namespace truepose::config
