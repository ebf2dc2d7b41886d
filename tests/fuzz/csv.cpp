// Measurement files. Read at once or row by row they say the same; what is accepted comes back as it was
// written. The same text as targets and as points.
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "config/frame_file.hpp"
#include "config/measurement_file.hpp"
#include "config/table/csv_reader.hpp"
#include "config/table/table_reading.hpp"
#include "config/target_file.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::fuzz {
namespace {

constexpr const char* kName = "input.csv";

/// What becomes of `read`: its result, or why it was refused.
template <typename Read>
std::string outcome(Read read) {
  try {
    return read();
  } catch (const config::ConfigError& error) {
    expect(*error.what() != '\0', "a refusal says why");
    return std::string("refused: ") + error.what();
  }
}

std::string at_once(const std::filesystem::path& file) {
  const auto table = config::CsvTable::read(file);
  std::string x;
  for (std::size_t row = 0; row < table.row_count(); ++row)
    x += std::to_string(table.number(row, table.column("x"))) + " ";
  return x;
}

std::string row_by_row(const std::string& text) {
  std::istringstream in{text};
  config::CsvStream stream{in, kName};
  std::string x;
  while (stream.next()) x += std::to_string(stream.number(stream.header().column("x"))) + " ";
  return x;
}

std::string written(const MeasurementData& data, const RobotModel& robot) {
  std::ostringstream out;
  config::write_measurements(out, data, robot);
  return out.str();
}

std::string targets(const std::string& text, const config::TargetRules& rules) {
  std::istringstream in{text};
  config::TargetReader reader{in, kName, rules};
  std::size_t numbers = 0;
  while (const auto target = reader.next()) numbers += target->numbers.size();
  return std::to_string(numbers);
}

bool is_refused(const std::string& outcome) { return outcome.starts_with("refused: "); }

}  // namespace

void csv(std::string_view input) {
  static const TempFolder folder;
  static const RobotModel robot = published_arm();
  const std::string text{input};

  const std::filesystem::path file = folder.write(kName, text);

  // Of several faults each may name its first.
  const std::string whole = outcome([&] { return at_once(file); });
  const std::string rows = outcome([&] { return row_by_row(text); });
  expect(whole == rows || (is_refused(whole) && is_refused(rows)),
         "rows are those of the table: " + whole + " and " + rows);

  outcome([&] { return std::to_string(config::load_joints(file, robot).size()); });
  outcome([&] { return std::to_string(config::load_points(file).size()); });
  outcome([&] { return targets(text, {}); });
  outcome([&] { return targets(text, {.arm = &robot, .of_joints = false, .whole_poses_alone = false}); });
  const config::TableReading reading;  // of files that other programs wrote
  outcome([&] { return std::to_string(config::load_joints(file, robot, &reading).size()); });
  outcome([&] { return std::to_string(config::load_points(file, &reading).size()); });
  outcome([&] { return targets(text, {.reading = &reading}); });
  outcome([&] { return written(config::load_measurements(file, robot, &reading), robot); });
  const std::string once = outcome([&] { return written(config::load_measurements(file, robot), robot); });
  if (is_refused(once)) return;
  const std::filesystem::path again = folder.write("written.csv", once);
  const std::string twice = outcome([&] { return written(config::load_measurements(again, robot), robot); });
  expect(twice == once, "measurements come back as they were written: " + once + " and " + twice);
}

}  // namespace truepose::fuzz
