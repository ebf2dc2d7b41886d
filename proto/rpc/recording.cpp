#include "proto/rpc/recording.hpp"

namespace truepose::rpc {

void layout(Io& io, RecordingSave::Result& x) {
  io.about("Of the recording")("name", x.name);
  io.about("Of its file")("bytes", x.bytes);
  io.about("Its path")("file", x.file);
}
const Method& RecordingSave::method() {
  static const Method kMethod{
      .name = "recording.save",
      .role = Role::Operator,
      .summary = "Writes what went over the wires in the last minutes to a file of the daemon's",
      .errors = {ErrorCode::Forbidden, ErrorCode::Store},
  };
  return kMethod;
}

void layout(Io& io, RecordingList::Result::Entry& x) {
  io.about("Of the recording")("name", x.name);
  io.about("Of its file")("bytes", x.bytes);
  io.about("When it was written; empty where that cannot be read")("date", x.date);
  io.about("A fault, that it was asked for, or why it cannot be read")("reason", x.reason);
}
void layout(Io& io, RecordingList::Result& x) { io("recordings", x.recordings); }
const Method& RecordingList::method() {
  static const Method kMethod{
      .name = "recording.list",
      .summary = "Recordings, newest first",
  };
  return kMethod;
}

void layout(Io& io, RecordingGet::Result& x) {
  io.about("Of the recording")("name", x.name);
  io.about("First byte of the part")("offset", x.offset);
  io.about("Base64 of at most 32 KiB; empty at the end")("data", x.data);
}
void layout(Io& io, RecordingGet& x) {
  io.about("Of the recording")("name", x.name);
  io.about("First byte of the part").defaulted("offset", x.offset);
}
const Method& RecordingGet::method() {
  static const Method kMethod{
      .name = "recording.get",
      .summary = "A part of a recording's file; ask on behind it until none comes",
      .errors = {ErrorCode::NotFound},
  };
  return kMethod;
}

std::vector<Described> recording_methods() {
  return {described<RecordingSave>(), described<RecordingList>(), described<RecordingGet>()};
}

}  // namespace truepose::rpc
