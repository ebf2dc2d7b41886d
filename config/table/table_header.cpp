#include "config/table/table_header.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "config/number_text.hpp"
#include "config/table/table_records.hpp"

namespace truepose::config {
namespace {

constexpr std::size_t kMostBeforeHeader = 60;  // rows of titles
constexpr std::array kOfOtherFiles{".yaml", ".yml", ".json", ".xml", ".urdf", ".xacro", ".src", ".html"};

bool is_krl(const std::string& field) { return field.starts_with('{'); }

/// What a column is by the user's choice, or by its name.
ColumnName meaning_of(const std::string& header, std::size_t place, const TableReading& reading) {
  ColumnName meaning = column_name(header);
  for (const ColumnChoice& choice : reading.columns) {
    if (choice.header == header || choice.header == std::to_string(place + 1)) {
      meaning.name = choice.name;
      return meaning;
    }
    if (choice.name == meaning.name) meaning.name.clear();
  }
  return meaning;
}

/// How many of its fields name a column of the form.
std::size_t names_in(const CsvRow& row, const TableForm& form, const TableReading& reading) {
  return static_cast<std::size_t>(std::ranges::count_if(row.fields, [&](const std::string& field) {
    const auto chosen = [&](const ColumnChoice& choice) { return choice.header == field; };
    const std::string name = column_name(field).name;
    return form.knows(name) || name == "q0" || std::ranges::any_of(reading.columns, chosen);
  }));
}

/// A comment that names the columns, as numpy writes it.
CsvRow uncommented(const CsvRow& row, const std::string& file) {
  CsvRow plain = row;
  std::string& first = plain.fields.front();
  first.erase(0, std::min(first.find_first_not_of("#%/ \t"), first.size()));
  if (first.empty() && plain.fields.size() > 1) plain.fields.erase(plain.fields.begin());
  if (plain.fields.size() > 1) return plain;
  auto records = table_records(plain.fields.front(), file).rows;
  if (!records.empty()) plain.fields = std::move(records.front().fields);
  return plain;
}

}  // namespace

bool is_empty(const CsvRow& row) {
  return std::ranges::all_of(row.fields, [](const std::string& field) { return field.empty(); });
}

bool is_of_numbers(const CsvRow& row) {
  return !is_empty(row) && std::ranges::all_of(row.fields, [](const auto& field) {
    return field.empty() || number_marks(field);
  });
}

std::vector<ColumnName> meanings_of(const std::vector<std::string>& headers, const TableReading& reading) {
  std::vector<ColumnName> meanings;
  for (std::size_t k = 0; k < headers.size(); ++k) meanings.push_back(meaning_of(headers[k], k, reading));
  return meanings;
}

HeaderPlace header_in(const std::vector<CsvRow>& records, const std::string& file, const TableForm& form,
                      const TableReading& reading) {
  HeaderPlace best;
  std::size_t most = 0;
  for (std::size_t k = 0; k < std::min(records.size(), kMostBeforeHeader); ++k) {
    if (is_of_numbers(records[k])) break;
    const CsvRow row = is_comment(records[k]) ? uncommented(records[k], file) : records[k];
    const std::size_t names = names_in(row, form, reading);
    if (names <= most) continue;
    most = names;
    best = {row, k + 1};
  }
  return best;
}

HeaderPlace header_of_numbers(const std::vector<CsvRow>& records, const TableReading& reading) {
  const auto first = std::ranges::find_if(records, is_of_numbers);
  if (first == records.end() || reading.columns.empty()) return {};
  CsvRow row{.fields = {}, .line = first->line - 1};
  for (std::size_t k = 0; k < first->fields.size(); ++k) row.fields.push_back(std::to_string(k + 1));
  return {row, static_cast<std::size_t>(first - records.begin())};
}

bool has_krl_cells(const std::vector<CsvRow>& records) {
  return std::ranges::any_of(records.back().fields, is_krl);
}

HeaderPlace header_of_krl(const std::vector<CsvRow>& records) {
  const auto first = std::ranges::find_if(
      records, [](const CsvRow& row) { return std::ranges::any_of(row.fields, is_krl); });
  if (first == records.end()) return {};
  HeaderPlace header{.row = {}, .end = static_cast<std::size_t>(first - records.begin())};
  if (first != records.begin() && (first - 1)->fields.size() == first->fields.size()) {
    header.row = *(first - 1);
    return header;
  }
  header.row.line = first->line - 1;
  for (std::size_t k = 0; k < first->fields.size(); ++k) header.row.fields.push_back(std::to_string(k + 1));
  return header;
}

std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 12;
  std::string list;
  for (std::size_t k = 0; k < std::min(names.size(), kMost); ++k)
    list += (k > 0 ? ", " : "") + (names[k].empty() ? "(no name)" : in_quotes(names[k]));
  return list + (names.size() > kMost ? ", ..." : "");
}

std::string choice_of(const std::vector<std::string>& names, bool by_number) {
  constexpr std::size_t kMost = 3;
  std::string choice;
  for (std::size_t k = 0; k < std::min(names.size(), kMost); ++k)
    choice += names[k] + "=" + (by_number ? std::to_string(k + 1) : "NAME") + ",";
  if (names.size() > kMost) return choice + "..";
  choice.pop_back();
  return choice;
}

void refuse_rows_of_columns(const std::vector<CsvRow>& records, const std::string& file,
                            const TableForm& form, const TableReading& reading) {
  std::set<std::string> names;
  std::size_t most = 0;
  for (const CsvRow& row : records) {
    most = std::max(most, names_in(row, form, reading));
    if (names.size() > kMostCsvColumns || row.fields.size() < 2) continue;
    if (const std::string name = column_name(row.fields[0]).name; form.knows(name)) names.insert(name);
  }
  if (names.size() <= most) return;
  throw ConfigError(file + ": has a row for each of " + list_of({names.begin(), names.end()}) +
                    ". Transpose the table: a row for each pose, a column for each of these");
}

void refuse_header(const std::vector<CsvRow>& records, const std::string& file, const TableForm& form,
                   const std::string& encoding) {
  const std::vector<std::string>& needed = form.needed.front();
  const auto uncommented = std::ranges::find_if_not(records, is_comment);
  const CsvRow& first = uncommented == records.end() ? records.front() : *uncommented;
  if (is_of_numbers(first))
    throw ConfigError(file + ": has no header: its first row (line " + std::to_string(first.line) +
                      ") is of numbers. Say what its " + std::to_string(first.fields.size()) +
                      " columns are: --columns " + choice_of(needed, true) + ", or write a header row");
  if (std::ranges::any_of(kOfOtherFiles, [&](const char* end) { return file.ends_with(end); }))
    throw ConfigError(file + ": is no table. Give a CSV file");
  if (first.fields.size() == 1)
    throw ConfigError(file + ": line " + std::to_string(first.line) + " is one column, " +
                      list_of(first.fields) +
                      ". Separate columns by commas, semicolons, tabs or blanks, in every row alike");
  throw ConfigError(file + ": no column is known, found " + list_of(first.fields) +
                    ". Say which is which: --columns " + choice_of(needed, false) +
                    (encoding.empty() ? ""
                                      : ". The file was read as " + encoding +
                                            ": if its names are others, save it as UTF-8"));
}

bool has_faulty_own_names(const std::vector<std::string>& headers, const TableForm& form) {
  const auto is_own = [&](const std::string& header) { return form.knows(header); };
  const auto means_another = [&](const std::string& header) {
    const std::string name = column_name(header).name;
    return form.knows(name) && name != header;
  };
  if (std::ranges::any_of(headers, means_another)) return false;
  const bool has_needed = std::ranges::any_of(form.needed, [&](const auto& names) {
    return std::ranges::all_of(
        names, [&](const auto& name) { return std::ranges::find(headers, name) != headers.end(); });
  });
  for (auto name = headers.begin(); name != headers.end(); ++name) {
    if (!name->empty() && std::find(headers.begin(), name, *name) != name) return true;
    if (name->empty() || is_own(*name)) continue;
    const bool is_misspelt = column_name(*name).name.empty() && !suggestion(*name, form.known).empty();
    if (is_own_column_name(*name) || (is_misspelt && has_needed)) return true;
  }
  return false;
}

}  // namespace truepose::config
