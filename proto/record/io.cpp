#include "proto/record/io.hpp"

namespace truepose::record {
namespace {

/// Goes past every member and notes its key.
class KeysIo final : public Io {
 public:
  std::vector<std::string> keys;

  bool reads() const override { return false; }
  bool has(std::string_view, bool there) const override { return there; }
  [[noreturn]] void fail(const std::string&) const override { std::abort(); }
  [[noreturn]] void fail_at(std::string_view, const std::string&) const override { std::abort(); }
  [[noreturn]] void fail_at(std::string_view, std::size_t, const std::string&) const override {
    std::abort();
  }
  void require(std::string_view) const override {}

 private:
  bool enter(Presence, std::string_view key, bool) override {
    keys.emplace_back(key);
    return false;
  }
  void leave() override {}
  void begin_record(const std::function<void(Io&)>&) override {}
  void end_record() override {}
  std::size_t begin_list(std::size_t) override { return 0; }
  void enter_element(std::size_t) override {}
  void end_list() override {}
  std::size_t begin_members(std::size_t) override { return 0; }
  std::string enter_member(std::size_t, std::string_view) override { return {}; }
  void end_members() override {}
  void number(double&, Range) override {}
  void whole(std::int64_t&, Whole) override {}
  void seed(std::uint64_t&) override {}
  void boolean(bool&) override {}
  void text(std::string&, bool) override {}
  void file(std::filesystem::path&) override {}
  void write_word(std::string_view) override {}
  std::string read_word(const std::vector<std::string_view>&) override { return {}; }
};

}  // namespace

std::vector<std::string> keys_of(const std::function<void(Io&)>& layout) {
  KeysIo io;
  layout(io);
  return std::move(io.keys);
}

}  // namespace truepose::record
