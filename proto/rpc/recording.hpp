#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

/// recording.save
struct RecordingSave : NoParameters {
  struct Result {
    std::string name{};
    std::uint64_t bytes = 0;
    std::string file{};
  };
  static const Method& method();
};
void layout(Io& io, RecordingSave::Result& x);

/// recording.list
struct RecordingList : NoParameters {
  struct Result {
    struct Entry {
      std::string name{};
      std::uint64_t bytes = 0;
      std::string date{};
      std::string reason{};
    };
    std::vector<Entry> recordings{};
  };
  static const Method& method();
};
void layout(Io& io, RecordingList::Result& x);

/// recording.get
struct RecordingGet {
  struct Result {
    std::string name{};
    std::uint64_t offset = 0;
    std::string data{};
  };
  static const Method& method();

  std::string name{};
  std::uint64_t offset = 0;
};
void layout(Io& io, RecordingGet& x);
void layout(Io& io, RecordingGet::Result& x);

/// The methods of this file.
std::vector<Described> recording_methods();

}  // namespace truepose::rpc
