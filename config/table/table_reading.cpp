#include "config/table/table_reading.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "config/number_text.hpp"
#include "config/table/column_units.hpp"
#include "config/table/csv_reader.hpp"
#include "config/table/foreign_table.hpp"
#include "config/table/table_header.hpp"
#include "config/table/table_join.hpp"
#include "config/table/table_records.hpp"
#include "config/table/text_encoding.hpp"

namespace truepose::config {
namespace {

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
  for (std::size_t k = 0; k < fields.size(); ++k) {
    const bool is_unit = !unit_word(fields[k]).empty();
    const bool is_left_out = k < table.columns.size() && table.columns[k].name.empty();
    if (!is_unit && !fields[k].empty() && fields[k] != "-" && !is_left_out) return false;
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

[[noreturn]] void refuse_two(const ForeignTable& table, std::size_t first, std::size_t second,
                             const std::string& name) {
  const auto &one = table.headers[first], &other = table.headers[second];
  const auto choice = [&](std::size_t k) {
    return one == other ? std::to_string(k + 1) : "\"" + table.headers[k] + "\"";
  };
  table.fail("columns " + in_quotes(one) + " and " + in_quotes(other) + " may both be " + name +
             ". Say which: --columns " + name + "=" + choice(first) + " or " + name + "=" + choice(second));
}

void refuse_two_of_a_name(const ForeignTable& table, const TableForm& form) {
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    const std::string& name = table.columns[k].name;
    const std::size_t first = table.find(name);
    if (form.knows(name) && first != k) refuse_two(table, first, k, name);
  }
}

/// Refuses "X" next to "X_ist" or "X.1": the robot's own position must not pass for the tracker's reading.
void refuse_two_readings(const ForeignTable& table, const TableReading& reading) {
  for (const char axis : {'x', 'y', 'z'}) {
    const std::string name(1, axis);
    const std::size_t taken = table.find(name);
    if (taken == table.columns.size() || names_the_tracker(table.headers[taken]) ||
        std::ranges::find(reading.columns, name, &ColumnChoice::name) != reading.columns.end())
      continue;
    for (std::size_t k = 0; k < table.columns.size(); ++k)
      if (table.columns[k].name.empty() && may_be_coordinate(table.headers[k], axis))
        refuse_two(table, taken, k, name);
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

/// The first of a few rows without a number behind those that a column numbers; the number of rows: none.
std::size_t first_unnumbered(const std::vector<CsvRow>& rows, std::size_t column) {
  constexpr std::ptrdiff_t kMostSums = 6;
  const auto is_numbered = [&](const CsvRow& row) { return parse_number(row.fields[column]).has_value(); };
  const auto end = std::ranges::find_if_not(rows, is_numbered);
  const auto sums = rows.end() - end;
  const bool is_numbering = sums > 0 && sums <= kMostSums && end - rows.begin() > sums &&
                            std::none_of(end, rows.end(), is_numbered) &&
                            counts_up({rows.begin(), end}, column);
  return is_numbering ? static_cast<std::size_t>(end - rows.begin()) : rows.size();
}

/// Refuses rows of sums or means, which have a name of their own or no number.
void refuse_rows_of_sums(const ForeignTable& table, const TableForm& form) {
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    const std::string& name = table.columns[k].name;
    if (form.knows(name) && !holds_words(name)) continue;
    const auto has_name_of_sum = [&](const CsvRow& row) { return names_a_sum(row.fields[k]); };
    std::size_t sum = first_unnumbered(table.rows, k);
    if (sum == table.rows.size() && (table.headers[k].empty() || is_key_name(table.headers[k])))
      sum = static_cast<std::size_t>(std::ranges::find_if(table.rows, has_name_of_sum) - table.rows.begin());
    if (sum < table.rows.size())
      table.fail(
          sum, k,
          in_quotes(table.rows[sum].fields[k]) +
              " is not named as the other rows are. Remove the row if it is a sum or a mean, else name "
              "it as the others");
  }
}

/// Poses by names and not by numbers: a column that joins rows, and nothing else.
void leave_out_named_poses(ForeignTable& table) {
  const std::size_t pose = table.find("pose");
  if (pose == table.columns.size() || table.rows.empty()) return;
  const auto is_number = [&](const CsvRow& row) {
    return pose < row.fields.size() && number_marks(row.fields[pose]).has_value();
  };
  if (std::ranges::none_of(table.rows, is_number)) table.columns[pose] = {};
}

/// Columns by which rows are joined, where they are nothing else.
void name_keys(ForeignTable& table, const TableForm& form) {
  for (std::size_t k = 0; k < table.headers.size(); ++k)
    if (!form.knows(table.columns[k].name) && is_key_name(table.headers[k]))
      table.columns[k] = {kKeyPrefix + table.headers[k], {}};
}

bool is_axis_of_no_arm(const std::string& name) {
  return name.size() > 1 && (name[0] == 'q' || name[0] == 'e') && name[1] >= '0' && name[1] <= '9';
}

/// Whether it is a joint of the arm, which the form has no place for.
bool is_joint_of(const RobotModel* robot, const std::string& name) {
  return name[0] == 'q' && (!robot || std::stoul(name.substr(1)) <= robot->joints.size());
}

bool has_all(const ForeignTable& table, const std::vector<std::string>& names) {
  return std::ranges::all_of(names,
                             [&](const auto& name) { return table.find(name) < table.columns.size(); });
}

/// "(1.5, -2, 3)": how many numbers a cell has.
std::size_t numbers_in(std::string cell) {
  if (number_marks(cell)) return 1;
  std::ranges::replace_if(
      cell, [](char c) { return std::string_view{"()[]{},;|\t"}.contains(c); }, ' ');
  std::istringstream words{cell};
  std::size_t numbers = 0;
  for (std::string word; words >> word; ++numbers)
    if (!parse_number(word)) return 0;
  return numbers;
}

void expect_needed(const ForeignTable& table, const TableForm& form, const TableReading& reading) {
  if (std::ranges::any_of(form.needed, [&](const auto& names) { return has_all(table, names); })) return;
  std::vector<std::string> missing;
  for (const std::string& name : form.needed.front())
    if (table.find(name) == table.columns.size()) missing.push_back(name);
  std::vector<std::string> unused;
  for (std::size_t k = 0; k < table.headers.size(); ++k)
    if (!form.knows(table.columns[k].name) && !table.headers[k].empty()) unused.push_back(table.headers[k]);
  for (const ColumnChoice& choice : reading.columns)
    if (std::ranges::find(missing, choice.name) != missing.end())
      table.fail("has no column " + in_quotes(choice.header) + ", which --columns gives for " + choice.name +
                 ". It has " + std::to_string(table.headers.size()) + ": " + list_of(table.headers));
  if (unused.empty()) table.fail("missing column " + in_quotes(missing.front()));
  for (std::size_t k = 0; k < table.headers.size() && !table.rows.empty(); ++k)
    if (!is_axis_of_no_arm(table.columns[k].name) && numbers_in(table.rows[0].fields[k]) > 1)
      table.fail(0, k,
                 in_quotes(table.rows[0].fields[k]) +
                     " is several numbers in one cell. Give each a column of its own");
  const std::string found = ", found " + list_of(unused) + ".";
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
    if (!form.knows(name) || name == table.headers[k] || name.starts_with(kKeyPrefix)) continue;
    std::size_t last = k;
    const auto is_joint = [&](std::size_t at) {
      return at < table.columns.size() && is_axis_of_no_arm(table.columns[at].name) &&
             form.knows(table.columns[at].name);
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
  bool has_converted = false;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    if (!form.knows(table.columns[k].name)) continue;
    kept.push_back(k);
    factors.push_back(factor_of(table, k, form, reading));
    has_converted |= factors.back() != 1;
    header += (header.empty() ? "" : ",") + table.columns[k].name;
  }
  notes.add_if(has_converted, "units converted to deg and mm");
  OwnForm own{.text = {}, .first_line = std::min(header_line, 1)};
  int line = own.first_line;
  const auto go_to = [&](int next) {
    for (; line < next; ++line) own.text += '\n';
  };
  go_to(header_line);
  own.text += header;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    const CsvRow& row = table.rows[r];
    go_to(row.line);
    for (std::size_t k = 0; k < kept.size(); ++k) {
      const std::string& field = row.fields[kept[k]];
      if (k > 0) own.text += ',';
      const auto number = factors[k] == 1 ? std::unexpected(std::string{}) : parse_number(field);
      own.text += number ? format_number(converted(*number * factors[k], table, r, kept[k], form))
                  : number_marks(field) ? field
                                        : csv_field(on_one_line(field));
    }
  }
  own.text += '\n';
  own.note = notes.text();
  return own;
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
    if (!form.knows(name)) return false;
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

bool TableForm::knows(std::string_view name) const {
  return std::ranges::find(known, name) != known.end() || (keeps_keys && name.starts_with(kKeyPrefix));
}

OwnForm own_form(std::string bytes, const std::string& file, const TableForm& form,
                 const TableReading& reading) {
  const bool is_plain_read = reading.columns.empty() && !reading.units;
  const std::string_view unmarked = std::string_view{bytes}.substr(bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0);
  if (is_plain_read && is_own_form(unmarked, file, form)) return {std::string{unmarked}, 1, {}};
  if (unmarked.find_first_not_of(" \t\r\n") == std::string_view::npos) return {{}, 1, {}};

  const DecodedText decoded = decode_text(bytes, file);
  TableRecords records = table_records(decoded.text, file);
  if (records.rows.empty()) return {{}, 1, {}};
  refuse_rows_of_columns(records.rows, file, form, reading);
  HeaderPlace header = header_in(records.rows, file, form, reading);
  if (header.end == 0) header = header_of_numbers(records.rows, reading);
  if (header.row.fields.empty()) header = header_of_krl(records.rows);
  const bool has_header = !header.row.fields.empty();
  const CsvRow& names = has_header ? header.row : records.rows.front();
  const bool has_own_names =
      has_header ? header.end == 1 : std::ranges::any_of(names.fields, is_own_column_name);
  if (is_plain_read && !form.keeps_keys && records.separator.empty() && has_own_names &&
      !has_krl_cells(records.rows) && has_faulty_own_names(names.fields, form))
    return {std::string{unmarked}, 1, {}};
  if (!has_header) refuse_header(records.rows, file, form, decoded.encoding);

  Notes notes;
  ForeignTable table = table_of(std::move(records.rows), header, file, reading);
  notes.add_if(!decoded.encoding.empty(), decoded.encoding);
  notes.add_if(!records.separator.empty(), records.separator);
  notes.add_if(header.end > 1, "header in line " + std::to_string(header.row.line));
  name_row_numbers(table);
  table.columns = meanings_of(table.headers, reading);
  drop_trailing_fields(table);
  table.columns.resize(table.headers.size());
  leave_out_named_poses(table);
  if (form.keeps_keys) name_keys(table, form);
  notes.add_if(take_units_row(table), "units below the header");
  expect_widths(table);
  const std::string invalid = leave_out_invalid_rows(table);
  notes.add_if(!invalid.empty(), invalid);
  expand_krl_columns(table);
  refuse_two_of_a_name(table, form);
  refuse_two_readings(table, reading);
  refuse_rows_of_sums(table, form);
  notes.add_if(count_joints_from_one(table.columns), "joints counted from 0");
  notes.add_if(normalise_numbers(table), "decimal commas");
  // The orientation of a reading has a sigma, else it is none of the tracker's.
  if (form.knows("a") && (!form.knows("sigma_abc") || table.find("sigma_abc") < table.columns.size())) {
    const std::string how = convert_orientations(table, reading.units ? reading.units->angle : "");
    notes.add_if(!how.empty(), how);
  }
  expect_needed(table, form, reading);
  if (!reading.units) expect_units_of_all(table);
  std::vector<std::string> left_out, keys;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    if (table.columns[k].name.starts_with(kKeyPrefix)) keys.push_back(table.headers[k]);
    if (form.knows(table.columns[k].name)) continue;
    if (const std::string& name = table.columns[k].name;
        is_axis_of_no_arm(name) && !is_joint_of(form.robot, name))
      expect_at_rest(table, k);
    left_out.push_back(table.headers[k]);
  }
  const std::string renamed = renamed_columns(table, form);
  notes.add_if(!renamed.empty(), renamed);
  notes.add_if(!keys.empty(), "rows named by " + list_of(keys));
  notes.add_if(!left_out.empty(), "left out: " + list_of(left_out));
  const bool lacks_joints = form.knows("q1") && table.find("q1") == table.columns.size();
  notes.add_if(lacks_joints && std::ranges::any_of(left_out, may_be_joint),
               "no joints: if some of these are, say which: --columns " + choice_of({"q1", "q2"}, false));
  return written(table, header.row.line, form, reading, notes);
}

}  // namespace truepose::config
