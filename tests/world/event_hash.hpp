#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace truepose::world {

/// Over all data that it gets: two runs that did the same have the same value.
class EventHash {
 public:
  void add(std::string_view text) {
    std::uint64_t word = 0;
    for (; text.size() >= sizeof word; text.remove_prefix(sizeof word)) {
      std::memcpy(&word, text.data(), sizeof word);
      add_word(word);
    }
    for (const char c : text) add_word(static_cast<unsigned char>(c));
  }
  void add(double value) { add_word(std::bit_cast<std::uint64_t>(value)); }
  std::uint64_t value() const { return value_; }

 private:
  /// The rotation brings what the product has carried to the top back down.
  void add_word(std::uint64_t word) { value_ = std::rotr((value_ ^ word) * 0x9e3779b97f4a7c15U, 29); }

  std::uint64_t value_ = 0xcbf29ce484222325U;
};

}  // namespace truepose::world
