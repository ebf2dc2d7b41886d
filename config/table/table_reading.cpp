#include "config/table/table_reading.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

#include "config/number_text.hpp"
#include "config/table/csv_reader.hpp"
#include "config/table/foreign_table.hpp"
#include "config/table/table_header.hpp"
#include "config/table/table_join.hpp"
#include "config/table/table_records.hpp"
#include "config/table/text_encoding.hpp"
#include "core/data/other_units.hpp"
#include "core/math/units.hpp"

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
    if (!form.knows(name) || first == k) continue;
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

/// Columns by which rows are joined, where they are nothing else.
void name_keys(ForeignTable& table, const TableForm& form) {
  for (std::size_t k = 0; k < table.headers.size(); ++k)
    if (!form.knows(table.columns[k].name) && is_key_name(table.headers[k]))
      table.columns[k] = {kKeyPrefix + table.headers[k], {}};
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

/// Refuses joints or coordinates of which some say another unit than deg and mm, and some say none.
void expect_units_of_all(const ForeignTable& table, bool (*is_of_kind)(const std::string& name)) {
  std::optional<std::size_t> stated, silent;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    const auto& [name, unit] = table.columns[k];
    if (!is_of_kind(name)) continue;
    if (unit.empty()) silent = silent.value_or(k);
    if (!unit.empty() && unit != "deg" && unit != "mm") stated = stated.value_or(k);
  }
  if (stated && silent)
    table.fail("column " + in_quotes(table.headers[*stated]) + " is in " + table.columns[*stated].unit +
               ", and " + in_quotes(table.headers[*silent]) + " says no unit: name the unit of all");
}

bool is_joint_column(const std::string& name) { return is_axis_of_no_arm(name) && name[0] == 'q'; }
bool is_coordinate(const std::string& name) { return name == "x" || name == "y" || name == "z"; }

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
    if (!form.knows(table.columns[k].name) && !table.headers[k].empty()) unused.push_back(table.headers[k]);
  if (unused.empty()) table.fail("missing column " + in_quotes(missing.front()));
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
  bool converted = false;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    if (!form.knows(table.columns[k].name)) continue;
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
  if (form.keeps_keys) name_keys(table, form);
  notes.add_if(take_units_row(table), "units below the header");
  expect_widths(table);
  expand_krl_columns(table);
  notes.add_if(count_joints_from_one(table.columns), "joints counted from 0");
  refuse_two_of_a_name(table, form);
  notes.add_if(normalise_numbers(table), "decimal commas");
  // The orientation of a reading has a sigma, else it is none of the tracker's.
  if (form.knows("a") && (!form.knows("sigma_abc") || table.find("sigma_abc") < table.columns.size())) {
    const std::string how = convert_orientations(table, reading.units ? reading.units->angle : "");
    notes.add_if(!how.empty(), how);
  }
  expect_needed(table, form);
  if (!reading.units) {
    expect_units_of_all(table, is_joint_column);
    expect_units_of_all(table, is_coordinate);
  }
  std::vector<std::string> left_out, keys;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    if (table.columns[k].name.starts_with(kKeyPrefix)) keys.push_back(table.headers[k]);
    if (form.knows(table.columns[k].name)) continue;
    if (is_axis_of_no_arm(table.columns[k].name)) expect_at_rest(table, k);
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
