#include "config/table_reading.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "config/foreign_table.hpp"
#include "config/number_text.hpp"
#include "config/table_records.hpp"
#include "config/text_encoding.hpp"
#include "core/data/other_units.hpp"
#include "core/math/units.hpp"

namespace truepose::config {
namespace {

constexpr std::size_t kMostBeforeHeader = 60;  // rows of titles

bool is_known(const TableForm& form, std::string_view name) {
  return std::ranges::find(form.known, name) != form.known.end();
}

bool is_empty(const CsvRow& row) {
  return std::ranges::all_of(row.fields, [](const std::string& field) { return field.empty(); });
}

// ---- The header ----

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

std::vector<ColumnName> meanings_of(const std::vector<std::string>& headers, const TableReading& reading) {
  std::vector<ColumnName> meanings;
  for (std::size_t k = 0; k < headers.size(); ++k) meanings.push_back(meaning_of(headers[k], k, reading));
  return meanings;
}

/// How many of its fields name a column of the form.
std::size_t names_in(const CsvRow& row, const TableForm& form, const TableReading& reading) {
  return static_cast<std::size_t>(std::ranges::count_if(row.fields, [&](const std::string& field) {
    const auto chosen = [&](const ColumnChoice& choice) { return choice.header == field; };
    const std::string name = column_name(field).name;
    return is_known(form, name) || name == "q0" || std::ranges::any_of(reading.columns, chosen);
  }));
}

bool is_of_numbers(const CsvRow& row) {
  return !is_empty(row) && std::ranges::all_of(row.fields, [](const auto& field) {
    return field.empty() || number_marks(field);
  });
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

/// A header, and how many records there are up to and with it.
struct HeaderPlace {
  CsvRow row;
  std::size_t end = 0;
};

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

/// The numbers of the columns in place of names, where the user has chosen by them.
HeaderPlace header_of_numbers(const std::vector<CsvRow>& records, const TableReading& reading) {
  const auto first = std::ranges::find_if(records, is_of_numbers);
  if (first == records.end() || reading.columns.empty()) return {};
  CsvRow row{.fields = {}, .line = first->line - 1};
  for (std::size_t k = 0; k < first->fields.size(); ++k) row.fields.push_back(std::to_string(k + 1));
  return {row, static_cast<std::size_t>(first - records.begin())};
}

std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 12;
  std::string list;
  for (std::size_t k = 0; k < std::min(names.size(), kMost); ++k)
    list += (k > 0 ? ", " : "") + (names[k].empty() ? "(no name)" : in_quotes(names[k]));
  return list + (names.size() > kMost ? ", ..." : "");
}

/// "q1=NAME,q2=NAME,.."
std::string choice_of(const std::vector<std::string>& names, bool by_number) {
  constexpr std::size_t kMost = 3;
  std::string choice;
  for (std::size_t k = 0; k < std::min(names.size(), kMost); ++k)
    choice += names[k] + "=" + (by_number ? std::to_string(k + 1) : "NAME") + ",";
  if (names.size() > kMost) return choice + "..";
  choice.pop_back();
  return choice;
}

[[noreturn]] void refuse_header(const std::vector<CsvRow>& records, const std::string& file,
                                const TableForm& form) {
  const std::vector<std::string>& needed = form.needed.front();
  if (is_of_numbers(records.front()))
    throw ConfigError(file + ": has no header: its first row (line " + std::to_string(records.front().line) +
                      ") is of numbers. Say what its " + std::to_string(records.front().fields.size()) +
                      " columns are: --columns " + choice_of(needed, true) + ", or write a header row");
  throw ConfigError(file + ": no column is known, found " + list_of(records.front().fields) +
                    ". Say which is which: --columns " + choice_of(needed, false));
}

// ---- The rows ----

/// Row numbers that a program has written in front without a name for their column.
bool counts_up(const std::vector<CsvRow>& rows, std::size_t column) {
  for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
    const auto one = parse_number(rows[k].fields[column]), next = parse_number(rows[k + 1].fields[column]);
    if (!one || !next || *next != *one + 1) return false;
  }
  return true;
}

/// Whether a record behind the header is a comment: a number is behind its mark, or it is no full row.
bool is_comment_of(const ForeignTable& table, const CsvRow& row) {
  if (!is_comment(row)) return false;
  if (row.fields.size() != table.headers.size()) return true;
  std::string_view first = row.fields.front();
  first.remove_prefix(std::min(first.find_first_not_of("#%/ \t"), first.size()));
  if (table.columns.front().name.empty() || holds_words(table.columns.front().name))
    throw ConfigError(table.file + ": line " + std::to_string(row.line) + ": " +
                      in_quotes(row.fields.front()) +
                      " may be a comment or a name: remove the row, or the mark in front of the name");
  return first.empty() || number_marks(first);
}

/// Fields that are empty throughout behind the header's last name, as trailing separators make them.
void drop_trailing_fields(ForeignTable& table) {
  while (table.headers.size() > 1 && table.headers.back().empty()) {
    const std::size_t last = table.headers.size() - 1;
    if (std::ranges::any_of(table.rows, [&](const CsvRow& row) {
          return row.fields.size() > last && !row.fields[last].empty();
        }))
      break;
    table.headers.pop_back();
  }
  for (CsvRow& row : table.rows)
    while (row.fields.size() > table.headers.size() && row.fields.back().empty()) row.fields.pop_back();
}

/// A header of one name less than the rows have fields, where the first of them are the rows' numbers.
void name_row_numbers(ForeignTable& table) {
  const std::size_t width = table.headers.size() + 1;
  const auto is_longer = [&](const CsvRow& row) {
    return row.fields.size() == width && !row.fields.back().empty();
  };
  if (!std::ranges::all_of(table.rows, is_longer)) return;
  if (table.rows.size() > 1 && counts_up(table.rows, 0)) table.headers.insert(table.headers.begin(), "");
}

void expect_widths(const ForeignTable& table) {
  const std::size_t width = table.headers.size();
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const std::size_t found = table.rows[row].fields.size();
    if (found < width) table.fail(row, found, "missing, the row ends before it");
    if (found == width) continue;
    const std::string commas =
        found > width + 1
            ? ". Where decimal commas and separators are alike, save it with semicolons or points"
            : "";
    table.fail(row, width - 1,
               std::to_string(found) + " fields in a row of " + std::to_string(width) + " columns" + commas);
  }
}

/// Takes the units of a row below the header. @return whether it was one
bool take_units_row(ForeignTable& table) {
  if (table.rows.empty()) return false;
  const std::vector<std::string>& fields = table.rows.front().fields;
  bool has_unit = false;
  for (const std::string& field : fields) {
    const bool is_unit = !unit_word(field).empty();
    if (!is_unit && !field.empty() && field != "-") return false;
    has_unit |= is_unit;
  }
  if (!has_unit) return false;
  for (std::size_t k = 0; k < std::min(fields.size(), table.columns.size()); ++k)
    if (std::string unit = unit_word(fields[k]); !unit.empty()) table.columns[k].unit = std::move(unit);
  table.rows.erase(table.rows.begin());
  return true;
}

// ---- The columns ----

/// joint_0 .. joint_5 as q1 .. q6. @return whether they were counted so
bool count_joints_from_one(std::vector<ColumnName>& columns) {
  const auto is_first = [](const ColumnName& each) { return each.name == "q0"; };
  if (std::ranges::none_of(columns, is_first)) return false;
  for (ColumnName& each : columns)
    if (each.name.size() > 1 && each.name[0] == 'q' && each.name[1] >= '0' && each.name[1] <= '9')
      each.name = "q" + std::to_string(std::stoi(each.name.substr(1)) + 1);
  return true;
}

void refuse_two_of_a_name(const ForeignTable& table, const TableForm& form) {
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    const std::string& name = table.columns[k].name;
    const std::size_t first = table.find(name);
    if (!is_known(form, name) || first == k) continue;
    table.fail("columns " + in_quotes(table.headers[first]) + " and " + in_quotes(table.headers[k]) +
               " may both be " + name + ". Say which: --columns " + name + "=" +
               (table.headers[first] == table.headers[k] ? std::to_string(first + 1)
                                                         : "\"" + table.headers[first] + "\""));
  }
}

/// Joints that the arm does not have, and external axes: left out where they stand still.
void expect_at_rest(const ForeignTable& table, std::size_t column) {
  for (std::size_t row = 1; row < table.rows.size(); ++row) {
    const auto first = parse_number(table.rows.front().fields[column]),
               here = parse_number(table.rows[row].fields[column]);
    if (table.rows[row].fields[column] == table.rows.front().fields[column] ||
        (first && here && *first == *here))
      continue;
    table.fail(row, column,
               "moves (" + in_quotes(table.rows.front().fields[column]) + " in row 1, here " +
                   in_quotes(table.rows[row].fields[column]) +
                   "), and the arm has no such axis: give the rows in which it stands still");
  }
}

bool is_axis_of_no_arm(const std::string& name) {
  return name.size() > 1 && (name[0] == 'q' || name[0] == 'e') && name[1] >= '0' && name[1] <= '9';
}

bool is_angle(const TableForm& form, std::string_view name) {
  if (name.size() > 1 && name[0] == 'q') {
    const std::size_t joint = static_cast<std::size_t>(std::stoi(std::string{name.substr(1)})) - 1;
    return !form.robot || form.robot->joints.at(joint).type == JointType::Revolute;
  }
  constexpr std::array<std::string_view, 7> kAngles{"a", "b", "c", "ca", "cb", "cc", "sigma_abc"};
  return std::ranges::find(kAngles, name) != kAngles.end();
}

bool is_length(const TableForm& form, std::string_view name) {
  if (name.size() > 1 && name[0] == 'q') return !is_angle(form, name);
  constexpr std::array<std::string_view, 14> kLengths{"x",      "y",         "z",         "px",       "py",
                                                      "pz",     "cx",        "cy",        "cz",       "sigma",
                                                      "excess", "payload_x", "payload_y", "payload_z"};
  return std::ranges::find(kLengths, name) != kLengths.end();
}

/// Whether --units are its units: of standard deviations they are not.
bool takes_stated_units(std::string_view name) {
  return name != "sigma" && name != "sigma_abc" && name != "excess";
}

/// What one of a column's unit is in deg or mm.
double factor_of(const ForeignTable& table, std::size_t column, const TableForm& form,
                 const TableReading& reading) {
  const ColumnName& meaning = table.columns[column];
  const bool angle = is_angle(form, meaning.name), length = is_length(form, meaning.name);
  std::string unit = meaning.unit;
  if (reading.units && (angle || length) && takes_stated_units(meaning.name)) {
    const std::string& stated = angle ? reading.units->angle : reading.units->length;
    if (!unit.empty() && unit != stated)
      table.fail("column " + in_quotes(table.headers[column]) + " says " + unit + ", and --units says " +
                 stated);
    unit = stated;
  }
  if (unit.empty() || unit == "deg" || unit == "mm") {
    if ((unit == "deg" && length) || (unit == "mm" && angle))
      table.fail("column " + in_quotes(table.headers[column]) + " is in " + unit + ", and " + meaning.name +
                 (angle ? " is an angle" : " is a length"));
    return 1;
  }
  if (unit == "rad" ? !angle : !length)
    table.fail("column " + in_quotes(table.headers[column]) + " is in " + unit + ", and " + meaning.name +
               (angle    ? " is an angle"
                : length ? " is a length"
                         : " has no such unit"));
  return unit == "rad" ? kDegPerRad : unit == "m" ? kMmPerMetre : unit == "cm" ? 10 : kMmPerInch;
}

bool has_all(const ForeignTable& table, const std::vector<std::string>& names) {
  return std::ranges::all_of(names,
                             [&](const auto& name) { return table.find(name) < table.columns.size(); });
}

void expect_needed(const ForeignTable& table, const TableForm& form) {
  if (std::ranges::any_of(form.needed, [&](const auto& names) { return has_all(table, names); })) return;
  std::vector<std::string> missing;
  for (const std::string& name : form.needed.front())
    if (table.find(name) == table.columns.size()) missing.push_back(name);
  std::vector<std::string> unused;
  for (std::size_t k = 0; k < table.headers.size(); ++k)
    if (!is_known(form, table.columns[k].name) && !table.headers[k].empty())
      unused.push_back(table.headers[k]);
  const std::string found = unused.empty() ? "." : ", found " + list_of(unused) + ".";
  table.fail("missing column " + in_quotes(missing.front()) + found + " Say which it is: --columns " +
             choice_of(missing, false));
}

// ---- What was done, in words ----

class Notes {
 public:
  void add(const std::string& what) { text_ += (text_.empty() ? "" : "; ") + what; }
  void add_if(bool so, const std::string& what) {
    if (so) add(what);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// "q1..q6 from 'A1 (deg)' .. 'A6 (deg)'"
std::string renamed_columns(const ForeignTable& table, const TableForm& form) {
  std::string text;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    const std::string& name = table.columns[k].name;
    if (!is_known(form, name) || name == table.headers[k]) continue;
    std::size_t last = k;
    const auto is_joint = [&](std::size_t at) {
      return at < table.columns.size() && is_axis_of_no_arm(table.columns[at].name) &&
             is_known(form, table.columns[at].name);
    };
    while (is_joint(k) && is_joint(last + 1)) ++last;
    text += (text.empty() ? "" : ", ") + name;
    if (last > k) text += ".." + table.columns[last].name;
    text += " from " + in_quotes(table.headers[k]);
    if (last > k) text += ".." + in_quotes(table.headers[last]);
    k = last;
  }
  return text;
}

/// A text without line ends, as it is written into a row.
std::string on_one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  std::ranges::replace(text, '\r', ' ');
  return text;
}

/// The columns of the form, each row on its line.
OwnForm written(const ForeignTable& table, int header_line, const TableForm& form,
                const TableReading& reading, Notes& notes) {
  std::vector<std::size_t> kept;
  std::vector<double> factors;
  std::string header;
  bool converted = false;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    if (!is_known(form, table.columns[k].name)) continue;
    kept.push_back(k);
    factors.push_back(factor_of(table, k, form, reading));
    converted |= factors.back() != 1;
    header += (header.empty() ? "" : ",") + table.columns[k].name;
  }
  notes.add_if(converted, "units converted to deg and mm");
  OwnForm own{.text = {}, .first_line = std::min(header_line, 1)};
  int line = own.first_line;
  const auto go_to = [&](int next) {
    for (; line < next; ++line) own.text += '\n';
  };
  go_to(header_line);
  own.text += header;
  for (const CsvRow& row : table.rows) {
    go_to(row.line);
    for (std::size_t k = 0; k < kept.size(); ++k) {
      const std::string& field = row.fields[kept[k]];
      if (k > 0) own.text += ',';
      const auto number = factors[k] == 1 ? std::unexpected(std::string{}) : parse_number(field);
      own.text += number                ? format_number(*number * factors[k])
                  : number_marks(field) ? field
                                        : csv_field(on_one_line(field));
    }
  }
  own.text += '\n';
  own.note = notes.text();
  return own;
}

/// Whether a header has our names alone, so that what is wrong with the file is a fault of our own form.
bool has_faulty_own_names(const std::vector<std::string>& headers, const TableForm& form) {
  const auto is_own = [&](const std::string& header) { return is_known(form, header); };
  const auto means_another = [&](const std::string& header) {
    const std::string name = column_name(header).name;
    return is_known(form, name) && name != header;
  };
  if (std::ranges::any_of(headers, means_another)) return false;
  for (auto name = headers.begin(); name != headers.end(); ++name) {
    if (!name->empty() && std::find(headers.begin(), name, *name) != name) return true;
    if (name->empty() || is_own(*name)) continue;
    if (is_own_column_name(*name) || !suggestion(*name, form.known).empty()) return true;
  }
  return std::ranges::none_of(form.needed, [&](const auto& names) {
    return std::ranges::all_of(
        names, [&](const auto& name) { return std::ranges::find(headers, name) != headers.end(); });
  });
}

/// Whether a text is in our form, as far as its header, its first row and the beginnings of its lines say.
bool is_own_form(std::string_view text, const std::string& file, const TableForm& form) try {
  for (std::size_t at = 0; at < text.size(); at = std::min(text.find('\n', at), text.size() - 1) + 1)
    if (std::string_view{"#%,/"}.contains(text[at])) return false;
  CsvScanner scanner{text, file};
  const auto header = scanner.next(), first = scanner.next();
  if (!header || !first || first->fields.size() != header->fields.size()) return false;
  for (std::size_t k = 0; k < header->fields.size(); ++k) {
    const std::string &name = header->fields[k], &field = first->fields[k];
    if (!is_known(form, name)) return false;
    if (!holds_words(name) && !field.empty() && !parse_number(field)) return false;
  }
  return true;
} catch (const ConfigError&) {
  return false;
}

ForeignTable table_of(std::vector<CsvRow> records, const HeaderPlace& header, const std::string& file,
                      const TableReading& reading) {
  ForeignTable table{.file = file, .headers = header.row.fields, .columns = {}, .rows = {}};
  table.rows.assign(std::make_move_iterator(records.begin() + static_cast<std::ptrdiff_t>(header.end)),
                    std::make_move_iterator(records.end()));
  std::erase_if(table.rows, is_empty);
  table.columns = meanings_of(table.headers, reading);
  std::erase_if(table.rows, [&](const CsvRow& row) { return is_comment_of(table, row); });
  return table;
}

}  // namespace

OwnForm own_form(std::string bytes, const std::string& file, const TableForm& form,
                 const TableReading& reading) {
  const bool is_plain_read = reading.columns.empty() && !reading.units;
  const std::string_view unmarked = std::string_view{bytes}.substr(bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0);
  if (is_plain_read && is_own_form(unmarked, file, form)) return {std::string{unmarked}, 1, {}};
  if (unmarked.find_first_not_of(" \t\r\n") == std::string_view::npos) return {{}, 1, {}};

  const DecodedText decoded = decode_text(bytes, file);
  TableRecords records = table_records(decoded.text, file);
  if (records.rows.empty()) return {{}, 1, {}};
  HeaderPlace header = header_in(records.rows, file, form, reading);
  if (header.end == 0) header = header_of_numbers(records.rows, reading);
  const bool has_header = !header.row.fields.empty();
  const CsvRow& names = has_header ? header.row : records.rows.front();
  const bool has_own_names =
      has_header ? header.end == 1 : std::ranges::any_of(names.fields, is_own_column_name);
  if (is_plain_read && records.separator.empty() && has_own_names && has_faulty_own_names(names.fields, form))
    return {std::string{unmarked}, 1, {}};
  if (!has_header) refuse_header(records.rows, file, form);

  Notes notes;
  ForeignTable table = table_of(std::move(records.rows), header, file, reading);
  notes.add_if(!decoded.encoding.empty(), decoded.encoding);
  notes.add_if(!records.separator.empty(), records.separator);
  notes.add_if(header.end > 1, "header in line " + std::to_string(header.row.line));
  name_row_numbers(table);
  table.columns = meanings_of(table.headers, reading);
  drop_trailing_fields(table);
  table.columns.resize(table.headers.size());
  notes.add_if(take_units_row(table), "units below the header");
  expect_widths(table);
  expand_krl_columns(table);
  notes.add_if(count_joints_from_one(table.columns), "joints counted from 0");
  refuse_two_of_a_name(table, form);
  notes.add_if(normalise_numbers(table), "decimal commas");
  if (is_known(form, "a")) {
    const std::string how = convert_orientations(table, reading.units ? reading.units->angle : "");
    notes.add_if(!how.empty(), how);
  }
  expect_needed(table, form);
  std::vector<std::string> left_out;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    if (is_known(form, table.columns[k].name)) continue;
    if (is_axis_of_no_arm(table.columns[k].name)) expect_at_rest(table, k);
    left_out.push_back(table.headers[k]);
  }
  const std::string renamed = renamed_columns(table, form);
  notes.add_if(!renamed.empty(), renamed);
  notes.add_if(!left_out.empty(), "left out: " + list_of(left_out));
  return written(table, header.row.line, form, reading, notes);
}

namespace {

/// So many bytes of a stream, or all that there are.
std::string bytes_of(std::istream& in, std::size_t most) {
  std::string bytes(most, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(most));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return bytes;
}

bool has_own_header(const std::string& line, const std::string& file, const TableForm& form) try {
  const auto header = CsvScanner{line, file}.next();
  return header &&
         std::ranges::all_of(header->fields, [&](const auto& name) { return is_known(form, name); });
} catch (const ConfigError&) {
  return false;
}

void report(const OwnForm& own, const std::string& file, const TableReading& reading) {
  if (!own.note.empty() && reading.report) reading.report(file + ": read as: " + own.note);
}

}  // namespace

OpenTable::OpenTable(std::istream& in, const std::string& file, const TableForm& form,
                     const TableReading* reading)
    : in_(in) {
  if (!reading) return;
  std::getline(in, taken_);
  if (in) taken_ += '\n';
  if (taken_.starts_with("\xEF\xBB\xBF")) taken_.erase(0, 3);
  const bool is_pipe = in.tellg() < 0;
  in.clear(in.rdstate() & ~std::ios::failbit);
  if (is_pipe && has_own_header(taken_, file, form) && reading->columns.empty() && !reading->units) return;
  std::string bytes = std::exchange(taken_, {}) + bytes_of(in, CsvTable::kMostBytes);
  if (in && !is_pipe) {  // too much to look at
    in.seekg(0);
    return;
  }
  if (in)
    throw ConfigError(file + ": has more than " + std::to_string(CsvTable::kMostBytes >> 20U) +
                      " MiB, the most that is read of a file that is not in truepose's own form");
  translate(std::move(bytes), file, form, *reading);
}

void OpenTable::translate(std::string bytes, const std::string& file, const TableForm& form,
                          const TableReading& reading) {
  OwnForm own = own_form(std::move(bytes), file, form, reading);
  report(own, file, reading);
  is_own_ = false;
  first_line_ = own.first_line;
  translated_.str(std::move(own.text));
}

CsvTable read_table(const std::filesystem::path& file, const TableForm& form, const TableReading* reading) {
  if (!reading) return CsvTable::read(file);
  const OwnForm own = own_form(read_bytes(file, CsvTable::kMostBytes), file.string(), form, *reading);
  report(own, file.string(), *reading);
  return CsvTable::parse(own.text, file.string(), own.first_line);
}

}  // namespace truepose::config
