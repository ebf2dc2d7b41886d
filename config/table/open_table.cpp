#include <algorithm>
#include <array>
#include <exception>
#include <string_view>
#include <utility>

#include "config/table/csv_reader.hpp"
#include "config/table/table_join.hpp"
#include "config/table/table_reading.hpp"

namespace truepose::config {

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
  return header && std::ranges::all_of(header->fields, [&](const auto& name) { return form.knows(name); });
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
  const bool is_plain = reading->columns.empty() && !reading->units;
  if (is_pipe && is_plain && has_own_header(taken_, file, form)) return;
  std::string bytes = std::exchange(taken_, {}) + bytes_of(in, CsvTable::kMostBytes);
  if (in && !is_pipe && is_plain) {  // too much to look at
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

namespace {

/// Columns that only a file of points has.
constexpr std::array<std::string_view, 10> kOfPoint{"x", "y",         "z",     "a",      "b",
                                                    "c", "sigma_abc", "sigma", "excess", "smr"};

using TwoFiles = std::pair<std::filesystem::path, std::filesystem::path>;

/// "joints.csv" and "points.csv" of "joints.csv+points.csv", in the order given; nothing for a file.
std::optional<TwoFiles> two_files(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) return std::nullopt;
  for (auto plus = name.find('+'); plus != std::string::npos; plus = name.find('+', plus + 1)) {
    TwoFiles two{name.substr(0, plus), name.substr(plus + 1)};
    if (std::filesystem::exists(two.first, ignored) && std::filesystem::exists(two.second, ignored))
      return two;
  }
  return std::nullopt;
}

bool is_of_joint(const std::string& name) {
  return name.size() > 1 && name[0] == 'q' && name[1] >= '0' && name[1] <= '9';
}

/// Joints in the first file and points in the second.
CsvTable read_in_order(const TwoFiles& files, const TableForm& form, const TableReading& reading) {
  TableForm joints{.known = {}, .needed = {{}}, .robot = form.robot, .keeps_keys = true};
  TableForm points{.known = {}, .needed = {{"x", "y", "z"}}, .robot = form.robot, .keeps_keys = true};
  for (const std::string& name : form.known) {
    if (std::ranges::find(kOfPoint, name) == kOfPoint.end()) joints.known.push_back(name);
    if (!is_of_joint(name)) points.known.push_back(name);
  }
  for (const auto& needed : form.needed)
    if (joints.needed.front().empty())
      std::ranges::copy_if(needed, std::back_inserter(joints.needed.front()), is_of_joint);
  const CsvTable of_joints = read_table(files.first, joints, &reading);
  const CsvTable of_points = read_table(files.second, points, &reading);
  auto [table, how] = joined({of_joints, of_points, files.first.string(), files.second.string()});
  if (reading.report) reading.report(how);
  return std::move(table);
}

/// Joints in one file and points in the other.
CsvTable read_two(const TwoFiles& files, const TableForm& form, const TableReading& reading) {
  try {
    return read_in_order(files, form, reading);
  } catch (const ConfigError&) {
    const std::exception_ptr as_given = std::current_exception();
    try {
      return read_in_order({files.second, files.first}, form, reading);
    } catch (const ConfigError&) {
      std::rethrow_exception(as_given);
    }
  }
}

}  // namespace

CsvTable read_table(const std::filesystem::path& file, const TableForm& form, const TableReading* reading) {
  if (!reading) return CsvTable::read(file);
  if (const auto two = two_files(file)) return read_two(*two, form, *reading);
  const OwnForm own = own_form(read_bytes(file, CsvTable::kMostBytes), file.string(), form, *reading);
  report(own, file.string(), *reading);
  return CsvTable::parse(own.text, file.string(), own.first_line);
}

}  // namespace truepose::config
