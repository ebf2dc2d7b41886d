#include "config/path_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "config/csv_reader.hpp"
#include "config/number_text.hpp"

namespace truepose::config {
namespace {

constexpr std::size_t kMostSamples =
    60'000;  // 20 minutes; a report carries them in one array of at most 65,536
constexpr std::size_t kMostPrograms = 20;
constexpr double kFarthest_mm = 100'000;  // beyond is a slip of unit or of a digit

class PathColumns {
 public:
  explicit PathColumns(const CsvTable& table)
      : table_(table),
        time_(table.column("time_s")),
        program_(table.column("program")),
        point_(table.column("point")),
        gain_(table.column("gain_percent")),
        wanted_(position("wanted")),
        with_(position("with")),
        without_(position("without")) {}

  PathSample at(std::size_t row) const {
    return {.time_s = time_s(row),
            .at_point = at_point(row),
            .gain_percent = gain_percent(row),
            .wanted_mm = position_mm(row, wanted_),
            .with_mm = position_mm(row, with_),
            .without_mm = position_mm(row, without_)};
  }

  void add_program(std::size_t row, std::vector<std::string>& names) const {
    const std::string name{table_.text(row, program_)};
    if (name.empty()) table_.fail(row, program_, "missing, expected a name");
    if (std::ranges::find(names, name) != names.end()) return;
    if (names.size() == kMostPrograms)
      table_.fail(row, program_, "more than " + std::to_string(kMostPrograms) + " programs in one file");
    names.push_back(name);
  }

 private:
  using Position = std::array<std::size_t, 3>;

  Position position(const std::string& name) const {
    return {table_.column(name + "_x_mm"), table_.column(name + "_y_mm"), table_.column(name + "_z_mm")};
  }

  [[noreturn]] void fail(std::size_t row, std::size_t column, const std::string& expected) const {
    table_.fail(row, column, "expected " + expected + ", found " + in_quotes(table_.text(row, column)));
  }

  double time_s(std::size_t row) const {
    const double time_s = table_.number(row, time_);
    if (row > 0 && time_s < table_.number(row - 1, time_))
      fail(row, time_, "no time before that of the row above");
    return time_s;
  }

  bool at_point(std::size_t row) const {
    const std::string_view text = table_.text(row, point_);
    if (text != "0" && text != "1") fail(row, point_, "0 or 1");
    return text == "1";
  }

  double gain_percent(std::size_t row) const {
    const double gain = table_.number(row, gain_);
    if (gain > 100) fail(row, gain_, "100 at most");
    return gain;
  }

  Eigen::Vector3d position_mm(std::size_t row, const Position& columns) const {
    Eigen::Vector3d p_mm;
    for (std::size_t k = 0; k < 3; ++k) {
      const double mm = table_.number(row, columns[k]);
      if (std::abs(mm) > kFarthest_mm) fail(row, columns[k], "-100000..100000 mm");
      p_mm[static_cast<Eigen::Index>(k)] = mm;
    }
    return p_mm;
  }

  const CsvTable& table_;
  std::size_t time_, program_, point_, gain_;
  Position wanted_, with_, without_;
};

}  // namespace

ProductionPath load_production_path(const std::filesystem::path& file) {
  const CsvTable table = CsvTable::read(file);
  const PathColumns columns(table);
  if (table.row_count() > kMostSamples)
    table.fail("more than " + std::to_string(kMostSamples) +
               " rows of data, 20 minutes: record a shorter time");
  ProductionPath path;
  std::vector<std::string> programs;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    path.samples.push_back(columns.at(row));
    columns.add_program(row, programs);
  }
  for (const std::string& name : programs) path.program += (path.program.empty() ? "" : ", ") + name;
  return path;
}

}  // namespace truepose::config
