#include "proto/record/io.hpp"

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
};

}  // namespace

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
