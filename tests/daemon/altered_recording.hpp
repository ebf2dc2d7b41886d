#pragma once

#include <functional>
#include <string>
#include <vector>

#include "proto/recording/block.hpp"
#include "proto/recording/recording.hpp"

namespace truepose::daemon {

inline std::vector<recording::Record> records_of(const recording::Recording& recording) {
  std::vector<recording::Record> records;
  recording.for_each([&](const recording::Record& record) { records.push_back(record); });
  return records;
}

inline std::string bytes_of(const recording::Header& header, const std::vector<recording::Record>& records) {
  recording::BlockWriter block;
  std::string bytes = recording::first_block(header);
  for (const recording::Record& record : records) {
    if (block.append(record)) continue;
    bytes += recording::block(block.bytes());
    block.clear();
    block.append(record);
  }
  if (!block.empty()) bytes += recording::block(block.bytes());
  return bytes + recording::last_block();
}

inline recording::Recording recording_of(const recording::Header& header,
                                         const std::vector<recording::Record>& records) {
  return recording::Recording::read(bytes_of(header, records)).value();
}

}  // namespace truepose::daemon
