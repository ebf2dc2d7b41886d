#include "config/yaml_layout.hpp"

#include <algorithm>

#include "config/number_text.hpp"

namespace truepose::config {
namespace {

std::string indented(const std::string& text) {
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    result.append("  ").append(text, begin, end - begin);
    begin = end;
  }
  return result;
}

/// What a value becomes in YAML: maps and lists of plain values on one line, and what holds such ones line by
/// line.
struct YamlText {
  std::string text;
  bool is_plain = false;  ///< no list and no map
  bool is_block = false;  ///< of several lines
};

/// With JSON's escapes, which YAML reads too: any text comes back as it was.
YamlText quoted_text(std::string_view text) {
  constexpr char kHex[] = "0123456789abcdef";
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') result += '\\';
    if (byte < 0x20) {
      result += std::string("\\x") + kHex[byte >> 4U] + kHex[byte & 15U];
    } else {
      result += c;
    }
  }
  return {result + '"', true};
}

using Members = std::vector<std::pair<std::string, YamlText>>;

YamlText list_text(const Members& elements) {
  const bool is_block =
      !std::ranges::all_of(elements, [](const auto& element) { return element.second.is_plain; });
  std::string text;
  for (const auto& [none, element] : elements)
    text += is_block ? "- " + element.text + "\n" : (text.empty() ? "" : ", ") + element.text;
  return is_block ? YamlText{text, false, true} : YamlText{"[" + text + "]"};
}

YamlText record_text(const Members& members) {
  std::string text;
  if (std::ranges::none_of(members, [](const auto& member) { return member.second.is_block; })) {
    for (const auto& [key, value] : members) text += (text.empty() ? "" : ", ") + key + ": " + value.text;
    return {"{" + text + "}"};
  }
  for (const auto& [key, value] : members)
    text += key + (value.is_block ? ":\n" + indented(value.text) : ": " + value.text + "\n");
  return {text, false, true};
}

/// Writes a value of YAML. Each value under way collects what stands in it.
class YamlWriter final : public WriteIo {
 public:
  std::string text() const { return open_.front().value.text; }

 private:
  struct Open {
    std::string key;  ///< in the value around it
    Members members;
    YamlText value;
  };

  bool enter(Presence presence, std::string_view key, bool there) override {
    if (!there && presence != Presence::Nullable) return false;
    open_.push_back({std::string{key}, {}, {}});
    if (there) return true;
    top() = {"null", true};
    leave();
    return false;
  }
  void leave() override {
    Open done = std::move(open_.back());
    open_.pop_back();
    open_.back().members.emplace_back(std::move(done.key), std::move(done.value));
  }
  void end_record() override { top() = record_text(open_.back().members); }
  void enter_element(std::size_t) override { open_.emplace_back(); }
  void end_list() override { top() = list_text(open_.back().members); }
  std::string enter_member(std::size_t, std::string_view key) override {
    open_.push_back({std::string{key}, {}, {}});
    return {};
  }
  void end_members() override { end_record(); }

  void number(double& x, Range) override { top() = {format_number(x), true}; }
  void whole(std::int64_t& x, Whole) override { top() = {std::to_string(x), true}; }
  void seed(std::uint64_t& x) override { top() = {std::to_string(x), true}; }
  void boolean(bool& x) override { top() = {x ? "true" : "false", true}; }
  void text(std::string& x, bool) override { top() = quoted_text(x); }
  void file(std::filesystem::path& x) override { top() = quoted_text(x.string()); }
  void write_word(std::string_view word) override { top() = {std::string{word}, true}; }

  YamlText& top() { return open_.back().value; }

  std::vector<Open> open_ = std::vector<Open>(1);
};

/// Reads a value of YAML.
class YamlReader final : public Io {
 public:
  explicit YamlReader(const YamlValue& value) : path_{&value} {}
  const YamlValue& value() const { return *path_.back(); }

  bool reads() const override { return true; }
  bool has(std::string_view key, bool) const override { return value().find(key) != nullptr; }
  [[noreturn]] void fail(const std::string& what) const override { value().fail(what); }
  [[noreturn]] void fail_at(std::string_view key, const std::string& what) const override {
    value().at(key).fail(what);
  }
  [[noreturn]] void fail_at(std::string_view key, std::size_t element,
                            const std::string& what) const override {
    value().at(key).list()[element].fail(what);
  }
  void require(std::string_view key) const override { value().at(key); }

 private:
  bool enter(Presence presence, std::string_view key, bool) override {
    const YamlValue* const member = presence == Presence::Required ? &value().at(key) : value().find(key);
    if (member) path_.push_back(member);
    return member != nullptr;
  }
  void leave() override { path_.pop_back(); }
  void begin_record(const std::function<void(Io&)>& layout) override { value().expect_keys(keys_of(layout)); }
  void end_record() override {}
  std::size_t begin_list(std::size_t) override { return value().list().size(); }
  void enter_element(std::size_t i) override { path_.push_back(&value().list()[i]); }
  void end_list() override {}
  std::size_t begin_members(std::size_t) override { return value().keys().size(); }
  std::string enter_member(std::size_t i, std::string_view) override {
    const YamlValue& map = value();
    path_.push_back(&map.values()[i]);
    return map.keys()[i];
  }
  void end_members() override {}

  void number(double& x, Range range) override { x = value().number(range); }
  void whole(std::int64_t& x, Whole range) override { x = value().integer(range.min, range.max); }
  void seed(std::uint64_t& x) override { x = value().seed(); }
  void boolean(bool& x) override { x = value().boolean(); }
  void text(std::string& x, bool may_be_empty) override {
    x = may_be_empty ? value().text_or_empty() : value().text();
  }
  void file(std::filesystem::path& x) override { x = value().file(); }
  void write_word(std::string_view) override { std::abort(); }
  std::string read_word(const std::vector<std::string_view>& words) override {
    return std::string{value().word(words)};
  }

  std::vector<const YamlValue*> path_;
};

}  // namespace

std::string written_yaml(const std::function<void(Io&)>& write) {
  YamlWriter io;
  write(io);
  return io.text();
}

void read_yaml_value(const YamlValue& value, const std::function<void(Io&)>& read) {
  YamlReader io{value};
  read(io);
}

const YamlValue& yaml_value(const Io& io) { return dynamic_cast<const YamlReader&>(io).value(); }

std::vector<std::vector<double>> Rows::form_of(const Eigen::MatrixXd& A) const {
  std::vector<std::vector<double>> rows;
  for (Eigen::Index i = 0; i < A.rows(); ++i) rows.emplace_back(A.row(i).begin(), A.row(i).end());
  return rows;
}

void Rows::read(const Io& io, Eigen::MatrixXd& A) const {
  const YamlValue& value = yaml_value(io);
  const std::vector<YamlValue>& rows = value.list();
  if (rows.empty()) value.fail("expected at least one row");
  const std::size_t cols = rows.front().list().size();
  if (std::ranges::find(columns, static_cast<int>(cols)) == columns.end()) {
    std::string expected;
    for (const int count : columns) expected += (expected.empty() ? "" : " or ") + std::to_string(count);
    rows.front().fail("expected " + expected + " numbers, found " + std::to_string(cols));
  }
  A.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(cols));
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const YamlValue& row = rows[static_cast<std::size_t>(i)];
    if (row.list().size() != cols) {
      row.fail("expected " + std::to_string(cols) + " numbers as in the first row, found " +
               std::to_string(row.list().size()));
    }
    for (Eigen::Index k = 0; k < A.cols(); ++k)
      A(i, k) = row.list()[static_cast<std::size_t>(k)].number(kAny);
  }
}

}  // namespace truepose::config

namespace truepose::record {

void layout(Io& io, Air& x) {
  io("temperature_c", x.temperature_c, Range{-20, 60});
  io("pressure_mbar", x.pressure_mbar, Range{500, 1100});
  io("humidity_percent", x.humidity_percent, Range{0, 100});
}

void layout(Io& io, Capsule& x) {
  io("from", x.from_mm, kPoint);
  io.on_read(x, [](auto& sphere) { sphere.to_mm = sphere.from_mm; });
  io.optional("to", x.to_mm, kPoint);
  io("radius", x.radius_mm, Range{0, 10'000});
}

/// Either corner may be left out: no bound.
void layout(Io& io, Box& x) {
  io.optional("min", x.min_mm, kPoint);
  io.optional("max", x.max_mm, kPoint);
}
void check(const Io& io, const Box& x) {
  if ((x.min_mm.array() >= x.max_mm.array()).any()) io.fail("expected every min below its max");
}

}  // namespace truepose::record
