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

}  // namespace

YamlText::Value YamlText::number(double number) { return {format_number(number), true}; }

/// With JSON's escapes, which YAML reads too: any text comes back as it was.
YamlText::Value YamlText::text(std::string_view text) {
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

YamlText::Value YamlText::list(const std::vector<Value>& elements) {
  const bool is_block = !std::ranges::all_of(elements, &Value::is_plain);
  std::string text;
  for (const Value& element : elements)
    text += is_block ? "- " + element.text + "\n" : (text.empty() ? "" : ", ") + element.text;
  return is_block ? Value{text, false, true} : Value{"[" + text + "]"};
}

YamlText::Value YamlText::record(const std::vector<std::pair<std::string, Value>>& members) {
  std::string text;
  if (std::ranges::none_of(members, [](const auto& member) { return member.second.is_block; })) {
    for (const auto& [key, value] : members) text += (text.empty() ? "" : ", ") + key + ": " + value.text;
    return {"{" + text + "}"};
  }
  for (const auto& [key, value] : members)
    text += key + (value.is_block ? ":\n" + indented(value.text) : ": " + value.text + "\n");
  return {text, false, true};
}

std::vector<std::vector<double>> Rows::form_of(const Eigen::MatrixXd& A) const {
  std::vector<std::vector<double>> rows;
  for (Eigen::Index i = 0; i < A.rows(); ++i) rows.emplace_back(A.row(i).begin(), A.row(i).end());
  return rows;
}

void Rows::read(const YamlValue& value, Eigen::MatrixXd& A) const {
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
