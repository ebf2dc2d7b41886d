// Recordings. What is read can be written and read again; a file that is cut off gives the records before the
// cut. The same of the texts of what drivers were asked for.
#include "proto/recording/recording.hpp"

#include <vector>

#include "daemon/recorder/driver_call.hpp"
#include "daemon/recorder/made_driver.hpp"
#include "daemon/replay/same_outcome.hpp"
#include "drivers/wire_failure.hpp"
#include "proto/recording/block.hpp"
#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {
namespace {

using recording::Record;

std::vector<Record> records_of(std::string_view block) {
  std::vector<Record> records;
  recording::BlockReader reader{block};
  for (auto record = reader.next(); record && *record; record = reader.next()) records.push_back(**record);
  return records;
}

void expect_round_trip(std::string_view block) {
  const std::vector<Record> records = records_of(block);
  recording::BlockWriter writer;
  for (const Record& record : records) {
    expect(record.bytes.size() <= recording::kMostRecordBytes, "no record is longer than the longest");
    if (!writer.append(record)) return;
  }
  expect(records_of(writer.bytes()) == records, "what is written is read again");
}

/// A text that can be read is, once it has been written anew, its own.
void expect_same_text(std::string_view input, const auto& read, const auto& write) {
  const auto value = read(input);
  if (!value) return;
  const std::string written = write(*value);
  const auto again = read(written);
  expect(again && write(*again) == written, "what a driver was asked is read again");
}

void expect_driver_texts(std::string_view input) {
  const auto write = [](const auto& value) { return text(value); };
  expect_same_text(input, &daemon::read_call, write);
  expect_same_text(input, &daemon::read_robot, write);
  expect_same_text(input, &daemon::read_tracker, write);
  expect_same_text(input, &drivers::read_failure, write);
  expect_same_text(input, &daemon::read_air, [](const daemon::ToldAir& air) { return daemon::text(air); });
  static_cast<void>(daemon::read_outcome(input));
  static_cast<void>(daemon::same_outcome(input, input));
}

}  // namespace

void recording(std::string_view input) {
  expect_round_trip(input);
  // The fuzzer finds no checksum: its records are given one.
  const std::string whole = recording::first_block({}) + recording::block(input) + recording::last_block();
  std::vector<Record> records;
  const auto take = [&](const Record& record) { records.push_back(record); };
  recording::Recording::read(whole)->for_each(take);
  expect(records == records_of(input), "a file holds the records of its blocks");
  if (input.empty()) return;  // which would be the end
  const auto cut = recording::Recording::read(whole.substr(0, whole.size() - 1));
  expect(!cut->for_each([](const Record&) {}).empty(), "a file that is cut off is said to be");
  if (const auto read = recording::Recording::read(std::string{input})) read->for_each([](const Record&) {});
  static_cast<void>(recording::read_commands(input));
  expect_driver_texts(input);
}

}  // namespace truepose::fuzz
