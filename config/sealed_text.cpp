#include "config/sealed_text.hpp"

#include <string_view>

#include "proto/text/digest.hpp"

namespace truepose::config {

namespace {

constexpr std::string_view kKey = "sha256: ";

/// Where the last line begins, if it is a seal; else npos.
std::size_t seal_in(const std::string& text) {
  const std::size_t key = text.rfind(kKey);
  if (key == std::string::npos || (key > 0 && text[key - 1] != '\n')) return std::string::npos;
  return text.find('\n', key) + 1 == text.size() ? key : std::string::npos;
}

}  // namespace

std::string sealed(const std::string& text) {
  return text + std::string{kKey} + text::sha256_hex(text) + "\n";
}

bool has_its_seal(const std::string& text) {
  const std::size_t seal = seal_in(text);
  return seal != std::string::npos && text == sealed(text.substr(0, seal));
}

void check_seal(const std::string& text, const std::string& name, const std::string& remedy) {
  if (seal_in(text) == std::string::npos)
    throw ConfigError(
        name + ": its last line is no 'sha256: ...', which shows that the others are unchanged; " + remedy);
  if (!has_its_seal(text))
    throw ConfigError(
        name + ": its content is not what was written (another SHA-256): take the file as it was made, or " +
        remedy);
}

YamlValue parse_sealed(const std::string& text, const std::string& name, DocumentKind kind,
                       const std::string& remedy) {
  const YamlValue yaml = parse_yaml(text.substr(0, seal_in(text)), name);
  expect_kind(yaml, kind);
  check_seal(text, name, remedy);
  return yaml;
}

}  // namespace truepose::config
