#include "proto/record/io.hpp"

#include <algorithm>
#include <cstdlib>

namespace truepose::record {
namespace {

/// Passes every member and notes its key.
class KeysIo final : public WriteIo {
 public:
  std::vector<std::string> keys;

 private:
  bool enter(Presence, std::string_view key, bool) override {
    keys.emplace_back(key);
    return false;
  }
  bool describes() const override { return true; }
};

}  // namespace

void Io::json(boost::json::value&) { std::abort(); }
void Io::json(boost::json::object&) { std::abort(); }
bool Io::null_element(bool) { std::abort(); }

std::size_t Io::characters(std::string_view text) {
  const auto begins_one = [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; };
  return static_cast<std::size_t>(std::ranges::count_if(text, begins_one));
}

void Io::refuse_size(std::size_t found, Size size, std::string_view what) const {
  if (found >= size.min && found <= size.max) return;
  constexpr Size kAnySize;
  std::string expected = std::to_string(size.min);
  if (size.max == kAnySize.max) expected += " or more";
  if (size.max != kAnySize.max && size.min == 0) expected = "at most " + std::to_string(size.max);
  if (size.max != kAnySize.max && size.min != 0 && size.min != size.max)
    expected += ".." + std::to_string(size.max);
  fail("expected " + expected + " " + std::string{what} + ", found " + std::to_string(found));
}

void WriteIo::fail(const std::string&) const { std::abort(); }
void WriteIo::fail_at(std::string_view, const std::string&) const { std::abort(); }
void WriteIo::fail_at(std::string_view, std::size_t, const std::string&) const { std::abort(); }
std::string WriteIo::read_word(const std::vector<std::string_view>&) { std::abort(); }

std::vector<std::string> keys_of(const std::function<void(Io&)>& layout) {
  KeysIo io;
  layout(io);
  return std::move(io.keys);
}

}  // namespace truepose::record
