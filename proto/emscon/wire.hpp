#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "proto/emscon/utf16.hpp"
#include "proto/text/device_text.hpp"

/// Little-endian fields of fixed width. Reader and Writer are called alike, so one layout serves both
/// directions.
namespace truepose::emscon {

template <class T>
concept Int32Like = std::same_as<T, std::int32_t> || std::is_enum_v<T>;

inline constexpr std::size_t kNameUnits = 32;  ///< UTF-16 units of a name on the wire

class Writer {
 public:
  template <class... Fields>
  void operator()(const Fields&... fields) {
    (put(fields), ...);
  }
  void skip(std::size_t size) { bytes_.resize(bytes_.size() + size); }
  void name(const std::string& text) {
    for (const char16_t unit : to_utf16<kNameUnits>(text)) put_bits(std::uint16_t{unit});
  }
  /// The packet, with its size written into its first field.
  std::vector<std::uint8_t> finish() && {
    const auto size = static_cast<std::uint32_t>(bytes_.size());
    for (std::size_t i = 0; i < 4; ++i) bytes_[i] = static_cast<std::uint8_t>(size >> (8 * i));
    return std::move(bytes_);
  }

 private:
  template <std::unsigned_integral U>
  void put_bits(U value) {
    for (std::size_t i = 0; i < sizeof(U); ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void put(Int32Like auto value) { put_bits(static_cast<std::uint32_t>(value)); }
  void put(std::same_as<bool> auto value) { put_bits(std::uint32_t{value}); }
  void put(std::same_as<double> auto value) { put_bits(std::bit_cast<std::uint64_t>(value)); }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& values) {
    for (const T& value : values) put(value);
  }

  std::vector<std::uint8_t> bytes_;
};

/// Reads zeros beyond the end and remembers that it did.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_{bytes} {}

  template <class... Fields>
  void operator()(Fields&... fields) {
    (get(fields), ...);
  }
  void skip(std::size_t size) { take(size); }
  void name(std::string& text) {
    std::array<char16_t, kNameUnits> units{};
    for (char16_t& unit : units) unit = get_bits<std::uint16_t>();
    text = text::device_text(to_utf8(units));
  }
  bool ok() const { return ok_; }
  std::size_t offset() const { return offset_; }
  std::size_t remaining() const { return bytes_.size() - offset_; }

 private:
  bool take(std::size_t size) {
    ok_ = ok_ && size <= remaining();
    if (ok_) offset_ += size;
    return ok_;
  }
  template <std::unsigned_integral U>
  U get_bits() {
    if (!take(sizeof(U))) return 0;
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(U); ++i)
      value |= std::uint64_t{bytes_[offset_ - sizeof(U) + i]} << (8 * i);
    return static_cast<U>(value);
  }
  void get(Int32Like auto& value) {
    value = static_cast<std::remove_reference_t<decltype(value)>>(
        static_cast<std::int32_t>(get_bits<std::uint32_t>()));
  }
  void get(std::same_as<bool> auto& value) { value = get_bits<std::uint32_t>() != 0; }
  void get(std::same_as<double> auto& value) { value = std::bit_cast<double>(get_bits<std::uint64_t>()); }
  template <class T, std::size_t N>
  void get(std::array<T, N>& values) {
    for (T& value : values) get(value);
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t offset_ = 0;
  bool ok_ = true;
};

}  // namespace truepose::emscon
