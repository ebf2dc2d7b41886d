#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace truepose::soak {

/// FNV-1a over all data that it gets: two runs that did the same have the same value.
class EventHash {
 public:
  void add(std::string_view text) {
    for (const char c : text) add_byte(static_cast<unsigned char>(c));
  }
  void add(double value) {
    unsigned char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    for (const unsigned char byte : bytes) add_byte(byte);
  }
  std::uint64_t value() const { return value_; }

 private:
  void add_byte(unsigned char byte) { value_ = (value_ ^ byte) * 0x100000001b3U; }

  std::uint64_t value_ = 0xcbf29ce484222325U;
};

}  // namespace truepose::soak
