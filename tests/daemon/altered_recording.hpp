#pragma once

#include <string>
#include <vector>

#include "proto/recording/recording.hpp"

namespace truepose::daemon {

inline std::vector<recording::Record> records_of(const recording::Recording& recording) {
  std::vector<recording::Record> records;
  recording.for_each([&](const recording::Record& record) { records.push_back(record); });
  return records;
}

inline std::string bytes_of(const recording::Header& header, const std::vector<recording::Record>& records) {
  recording::RecordWriter writer{{}, header.clock_origin_ns};
  std::string bytes = recording::head(header, header.time_ns);
  for (const recording::Record& record : records) bytes += writer.blocks(record);
  return bytes + recording::tail(header);
}

inline recording::Recording recording_of(const recording::Header& header,
                                         const std::vector<recording::Record>& records) {
  return recording::Recording::read(bytes_of(header, records)).value();
}

}  // namespace truepose::daemon
