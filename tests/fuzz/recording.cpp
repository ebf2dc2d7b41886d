// Recordings. What is read can be written and read again; a file that is cut off gives the records before the
// cut.
#include "proto/recording/recording.hpp"

#include <vector>

#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {
namespace {

using recording::Record;

std::vector<Record> records_of(const std::string& file) {
  std::vector<Record> records;
  if (const auto read = recording::Recording::read(file))
    static_cast<void>(read->for_each([&](const Record& record) { records.push_back(record); }));
  return records;
}

std::string file_of(const std::vector<Record>& records) {
  recording::RecordWriter writer{{}, 0};
  std::string file = recording::head({}, 0);
  for (const Record& record : records) file += writer.blocks(record);
  return file + recording::tail({});
}

}  // namespace

void recording(std::string_view input) {
  // As a file, and as what comes behind the head of one.
  static_cast<void>(records_of(std::string{input}));
  const std::vector<Record> records = records_of(recording::head({}, 0) + std::string{input});
  const std::vector<Record> written = records_of(file_of(records));
  expect(records_of(file_of(written)) == written, "what is written is read again");
  static_cast<void>(recording::read_commands(input));
  static_cast<void>(recording::read_packet(input));
  static_cast<void>(recording::read_endpoint(input));
}

}  // namespace truepose::fuzz
