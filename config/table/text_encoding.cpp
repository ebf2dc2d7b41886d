#include "config/table/text_encoding.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "config/text_file.hpp"

namespace truepose::config {
namespace {

constexpr std::size_t kHeadBytes = 4096;  // bytes by which the kind of a file is seen

void append_utf8(std::string& text, std::uint32_t code) {
  if (code < 0x80) {
    text += static_cast<char>(code);
    return;
  }
  if (code < 0x800) {
    text += static_cast<char>(0xC0U | (code >> 6U));
  } else {
    if (code < 0x10000) {
      text += static_cast<char>(0xE0U | (code >> 12U));
    } else {
      text += static_cast<char>(0xF0U | (code >> 18U));
      text += static_cast<char>(0x80U | ((code >> 12U) & 0x3FU));
    }
    text += static_cast<char>(0x80U | ((code >> 6U) & 0x3FU));
  }
  text += static_cast<char>(0x80U | (code & 0x3FU));
}

bool is_utf8(std::string_view text) {
  std::size_t follow = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (follow > 0) {
      if ((byte & 0xC0U) != 0x80U) return false;
      --follow;
    } else if (byte >= 0x80) {
      if (byte < 0xC2 || byte > 0xF4) return false;
      follow = byte < 0xE0 ? 1 : byte < 0xF0 ? 2 : 3;
    }
  }
  return follow == 0;
}

std::string from_windows_1252(std::string_view bytes) {
  // 0x80 to 0x9F by the code page's table; all others are Latin-1, whose codes Unicode has taken over.
  constexpr std::array<std::uint16_t, 32> kHigh{
      0x20AC, 0x81,   0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
      0x2039, 0x0152, 0x8D,   0x017D, 0x8F,   0x90,   0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
      0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x9D,   0x017E, 0x0178};
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    append_utf8(text, byte >= 0x80 && byte < 0xA0 ? kHigh[byte - 0x80U] : byte);
  }
  return text;
}

std::string from_utf16(std::string_view bytes, bool is_little, const std::string& file) {
  if (bytes.size() % 2 != 0) throw ConfigError(file + ": is cut off: UTF-16 with an odd number of bytes");
  const auto unit = [&](std::size_t at) {
    const auto a = static_cast<unsigned char>(bytes[at]), b = static_cast<unsigned char>(bytes[at + 1]);
    return static_cast<std::uint32_t>(is_little ? a | (b << 8U) : (a << 8U) | b);
  };
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 2) {
    std::uint32_t code = unit(at);
    if (code >= 0xD800 && code < 0xDC00 && at + 2 < bytes.size()) {
      at += 2;
      code = 0x10000 + ((code - 0xD800) << 10U) + (unit(at) - 0xDC00);
    }
    append_utf8(text, code);
  }
  return text;
}

/// Of a UTF-16 text without a mark: whether it is little-endian. ASCII has a zero in every second byte.
std::optional<bool> is_little_utf16(std::string_view bytes) {
  const std::string_view sample = bytes.substr(0, kHeadBytes);
  std::array<std::size_t, 2> zeros{};
  for (std::size_t at = 0; at < sample.size(); ++at) zeros[at % 2] += sample[at] == '\0' ? 1U : 0U;
  const std::size_t enough = sample.size() * 2 / 5;
  if (sample.size() < 4) return std::nullopt;
  if (zeros[1] >= enough && zeros[0] == 0) return true;
  if (zeros[0] >= enough && zeros[1] == 0) return false;
  return std::nullopt;
}

void refuse_what_is_no_text(std::string_view bytes, const std::string& file) {
  constexpr const char* kSave =
      ": in Excel or LibreOffice save the sheet as CSV (File, Save As, CSV UTF-8) and give that file";
  constexpr std::array<std::pair<std::string_view, const char*>, 5> kNoText{
      {{"PK\x03\x04", "is an Excel workbook (.xlsx) or another zip file, not text"},
       {"\xD0\xCF\x11\xE0", "is an old Excel workbook (.xls), not text"},
       {"%PDF", "is a PDF file, not a table"},
       {"\x1F\x8B", "is compressed (gzip), not text"},
       {"\x89HDF", "is an HDF5 file, not text"}}};
  for (const auto& [mark, what] : kNoText)
    if (bytes.starts_with(mark)) throw ConfigError(file + ": " + what + kSave);
}

/// Of a text that is no table: what it is; empty: it may be one.
std::string_view other_kind_of(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n", kBinary{"\0\x01\x02\x03\x04\x05\x06\x07\x08", 9};
  constexpr std::size_t kHead = 512;
  constexpr std::ptrdiff_t kFewestBinary = 3;
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  const auto second = text.find_first_not_of(kBlanks, 1);
  const char next = second == std::string_view::npos ? ' ' : text[second];
  if ((text.starts_with('{') && next == '"') ||
      (text.starts_with('[') && std::string_view{"[{"}.contains(next)))
    return "is JSON";
  if (text.starts_with("<?xml") || text.starts_with("<!") || text.starts_with("<html") ||
      text.starts_with("<table"))
    return "is XML or HTML";
  const auto is_binary = [&](char c) { return kBinary.contains(c); };
  if (std::ranges::count_if(text.substr(0, kHead), is_binary) >= kFewestBinary)
    return "is binary, or in an encoding that is not known";
  return {};
}

/// Other programs' blanks and minus signs.
void make_plain(std::string& text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kPlain{{{"\xC2\xA0", " "},
                                                                                 {"\xE2\x80\xAF", " "},
                                                                                 {"\xE2\x80\x89", " "},
                                                                                 {"\xE2\x88\x92", "-"},
                                                                                 {"\xE2\x80\x93", "-"},
                                                                                 {"\xE2\x80\x99", "'"},
                                                                                 {"\xEF\xBB\xBF", ""}}};
  std::string plain;
  for (std::size_t at = 0; at < text.size();) {
    const auto* const found = std::ranges::find_if(kPlain, [&](const auto& each) {
      return text[at] == each.first[0] && std::string_view{text}.substr(at).starts_with(each.first);
    });
    if (found == kPlain.end()) {
      plain += text[at++];
    } else {
      plain += found->second;
      at += found->first.size();
    }
  }
  text = std::move(plain);
}

DecodedText decoded(std::string bytes, const std::string& file) {
  if (bytes.starts_with("\xEF\xBB\xBF")) return {std::move(bytes), ""};
  if (bytes.starts_with("\xFF\xFE")) return {from_utf16(bytes.substr(2), true, file), "UTF-16"};
  if (bytes.starts_with("\xFE\xFF")) return {from_utf16(bytes.substr(2), false, file), "UTF-16"};
  if (const auto little = is_little_utf16(bytes)) return {from_utf16(bytes, *little, file), "UTF-16"};
  if (is_utf8(bytes)) return {std::move(bytes), ""};
  return {from_windows_1252(bytes), "Windows-1252"};
}

}  // namespace

DecodedText decode_text(std::string bytes, const std::string& file) {
  refuse_what_is_no_text(bytes, file);
  DecodedText text = decoded(std::move(bytes), file);
  if (const std::string_view kind = other_kind_of(text.text); !kind.empty())
    throw ConfigError(file + ": " + std::string{kind} +
                      ", not a table. Export it as CSV (UTF-8), a row for each pose");
  if (std::ranges::any_of(text.text, [](char c) { return static_cast<unsigned char>(c) >= 0x80; }))
    make_plain(text.text);
  return text;
}

}  // namespace truepose::config
