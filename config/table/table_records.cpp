#include "config/table/table_records.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "config/table/column_name.hpp"

namespace truepose::config {
namespace {

constexpr std::size_t kSampleBytes = std::size_t{64} << 10U;  // bytes by which the separator is chosen

/// A way to cut a line: at a character, or at as many blanks.
struct Cut {
  const char* name;
  char separator;
  int blanks = 0;
};
// Where two are as good the first one is taken: names may have single blanks in them.
constexpr std::array kCuts{Cut{"semicolons", ';'},    Cut{"tabs", '\t'},      Cut{"", ','},
                           Cut{"vertical bars", '|'}, Cut{"blanks", '\t', 2}, Cut{"blanks", '\t', 1}};

constexpr double kEnough = 0.5;  // of the fields are numbers: then blanks are parts of names

bool is_blank(char c) { return c == ' ' || c == '\t'; }

/// The lines of a text one by one, each with its end.
template <class Change>
std::string each_line(std::string_view text, Change change) {
  std::string changed;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    change(text.substr(at, end - at), changed);
    at = end;
  }
  return changed;
}

/// Runs of blanks outside quotes as tabs.
std::string with_tabs(std::string_view text, int least) {
  return each_line(text, [least](std::string_view line, std::string& out) {
    bool is_quoted = false, is_first = true;
    for (std::size_t at = 0; at < line.size();) {
      std::size_t end = at;
      while (!is_quoted && end < line.size() && is_blank(line[end])) ++end;
      if (end == at) {
        is_quoted ^= line[at] == '"';
        out += line[at++];
        is_first = false;
        continue;
      }
      const bool is_last = end == line.size() || line[end] == '\r' || line[end] == '\n';
      const std::string_view run = line.substr(at, end - at);
      const bool cuts = std::ssize(run) >= least || run.contains('\t');
      if (!is_first && !is_last) out += cuts ? '\t' : ' ';
      at = end;
    }
  });
}

/// Without separators in braces, and without quotes in comments, which open and close nothing.
std::string with_protected_parts(std::string_view text) {
  return each_line(text, [](std::string_view line, std::string& out) {
    const auto first = std::min(line.find_first_not_of(" \t"), line.size());
    const bool comment = is_comment({.fields = {std::string{line.substr(first, 2)}}});
    const bool closes = line.rfind('}') != std::string_view::npos;
    int depth = 0;
    for (const char c : line) {
      depth += c == '{' && closes ? 1 : c == '}' && depth > 0 ? -1 : 0;
      const bool separates = is_blank(c) || c == ',' || c == ';';
      out += comment && c == '"' ? '\'' : depth > 0 && separates ? kKrlBlank : c;
    }
  });
}

std::vector<CsvRow> records_by(const Cut& cut, std::string_view text, const std::string& file) {
  const std::string cut_text = cut.blanks > 0 ? with_tabs(text, cut.blanks) : std::string{};
  CsvScanner scanner{cut.blanks > 0 ? std::string_view{cut_text} : text, file, 1, cut.separator};
  std::vector<CsvRow> rows;
  while (auto row = scanner.next()) {
    if (rows.size() > CsvTable::kMostRows)
      throw ConfigError(file + ": more than " + std::to_string(CsvTable::kMostRows) + " rows");
    rows.push_back(*std::move(row));
  }
  return rows;
}

/// A line between the rows of a table in Markdown or of a database.
bool is_rule(const CsvRow& row) {
  return std::ranges::all_of(row.fields, [](const std::string& field) {
    return field.find_first_not_of("-:=+") == std::string::npos;
  });
}

/// Rows between bars: without the empty field in front of the first bar, and without rules.
void drop_frame(std::vector<CsvRow>& rows) {
  std::erase_if(rows, is_rule);
  const auto begins_with_bar = [](const CsvRow& row) {
    return row.fields.size() == 1 || row.fields.front().empty();
  };
  if (!std::ranges::all_of(rows, begins_with_bar)) return;
  for (CsvRow& row : rows)
    if (row.fields.size() > 1) row.fields.erase(row.fields.begin());
}

bool is_value(const std::string& field) {
  if (field.starts_with('{')) return true;
  const auto number = number_marks(without_unit(field).first);
  return number && !(number->has_groups && field.contains(' '));
}

/// Part of the fields that are numbers, over all records. One number alone is that of a title.
double share_of_numbers(const Cut& cut, std::string_view sample, const std::string& file) {
  double sum = 0, rows = 0;
  try {
    for (const CsvRow& row : records_by(cut, sample, file)) {
      const auto filled = std::ranges::count_if(row.fields, [](const auto& field) { return !field.empty(); });
      if (filled == 0 || is_comment(row)) continue;
      ++rows;
      const auto numbers = std::ranges::count_if(row.fields, is_value);
      if (numbers > 1) sum += static_cast<double>(numbers) / static_cast<double>(filled);
    }
  } catch (const ConfigError&) {
    return 0;  // by this separator a quote stays open
  }
  return rows > 0 ? sum / rows : 0;
}

/// Of a file without numbers: the one of which there are most in its first line.
const Cut* cut_of_names(std::string_view sample) {
  const std::string_view line = sample.substr(0, sample.find('\n'));
  return &*std::ranges::max_element(kCuts.begin(), kCuts.begin() + 4, {},
                                    [&](const Cut& cut) { return std::ranges::count(line, cut.separator); });
}

bool is_digit_of_number(char c) { return c >= '0' && c <= '9'; }

}  // namespace

bool is_comment(const CsvRow& row) {
  const std::string& first = row.fields.front();
  return first.starts_with('#') || first.starts_with('%') || first.starts_with("//");
}

TableRecords table_records(std::string text, const std::string& file) {
  text = with_protected_parts(text);
  std::string_view sample = text;
  if (sample.size() > kSampleBytes) sample = sample.substr(0, sample.find('\n', kSampleBytes));
  const Cut* best = nullptr;
  double most = 1e-9;
  for (const Cut& cut : kCuts) {
    const double share = share_of_numbers(cut, sample, file);
    if (share <= most + 1e-9 || (cut.blanks > 0 && best && best->blanks == 0 && most > kEnough)) continue;
    most = share;
    best = &cut;
  }
  if (!best) best = cut_of_names(sample);
  TableRecords records{records_by(*best, text, file), best->name};
  if (best->separator == '|') drop_frame(records.rows);
  return records;
}

std::pair<std::string, std::string> without_unit(const std::string& field) {
  const auto last = field.find_last_of("0123456789.,");
  if (last == std::string::npos || last + 1 == field.size()) return {field, {}};
  std::string unit = unit_word(std::string_view{field}.substr(last + 1));
  std::string number = field.substr(0, last + 1);
  if (unit.empty() || !number_marks(number)) return {field, {}};
  return {std::move(number), std::move(unit)};
}

std::optional<NumberMarks> number_marks(std::string_view field) {
  NumberMarks marks;
  std::size_t at = field.find_first_not_of("+-") == std::string_view::npos ? field.size() : 0;
  if (at < field.size() && (field[at] == '+' || field[at] == '-')) ++at;
  const std::size_t first = at;
  std::size_t digits = 0, last_mark = std::string_view::npos;
  for (; at < field.size(); ++at) {
    const char c = field[at];
    if (is_digit_of_number(c)) {
      ++digits;
    } else if (c == '.' || c == ',') {
      ++(c == '.' ? marks.points : marks.commas);
      last_mark = at;
    } else if ((c == ' ' || c == '\'') && digits > 0 && at + 3 < field.size() &&
               is_digit_of_number(field[at + 1])) {
      marks.has_groups = true;
    } else {
      break;
    }
  }
  if (digits == 0) return std::nullopt;
  const std::size_t end = at;
  if (at < field.size() && std::string_view{"eEdD"}.contains(field[at])) {
    ++at;
    if (at < field.size() && (field[at] == '+' || field[at] == '-')) ++at;
    if (at == field.size()) return std::nullopt;
    while (at < field.size() && is_digit_of_number(field[at])) ++at;
  }
  if (at < field.size()) return std::nullopt;
  const int count = marks.points + marks.commas;
  marks.has_groups = marks.has_groups || count > 1;
  const std::size_t before = count == 1 ? last_mark - first : 0;
  marks.may_be_group = count == 1 && end == field.size() && end - last_mark == 4 && before >= 1 &&
                       before <= 3 && field[first] != '0';
  return marks;
}

}  // namespace truepose::config
