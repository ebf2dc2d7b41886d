#include "tools/truepose/online/recording_commands.hpp"

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>

#include "config/text_file.hpp"
#include "proto/control/base64.hpp"
#include "proto/rpc/recording.hpp"
#include "tools/truepose/online/rpc_client.hpp"
#include "tools/truepose/progress_line.hpp"

namespace truepose::tools {
namespace {

/// Bytes of a recording; 0: not known.
std::uint64_t size_of(RpcClient& client, const std::string& name) {
  const auto list = client.call(rpc::RecordingList{});
  if (!list) return 0;
  const auto& entries = list->record.recordings;
  const auto found = std::ranges::find(entries, name, &rpc::RecordingList::Result::Entry::name);
  return found == entries.end() ? 0 : found->bytes;
}

/// Part by part, into a file that appears whole or not at all.
void copy_recording(RpcClient& client, const std::string& name, const std::filesystem::path& out) {
  ProgressLine line{"recording"};
  const std::uint64_t bytes = size_of(client, name);
  config::UnfinishedFile file{out};
  for (rpc::RecordingGet request{.name = name};;) {
    const auto part = control::from_base64(value_or_throw(client.call(request)).record.data);
    if (!part) throw CommandError{kFailed, "the daemon's recording " + name + " came damaged"};
    if (part->empty()) break;
    file.stream() << *part;
    request.offset += part->size();
    if (bytes > 0) line.show(std::min(1.0, static_cast<double>(request.offset) / static_cast<double>(bytes)));
  }
  file.close();
  file.take_place();
}

struct ExportedRecording {
  std::string name;
  std::filesystem::path file;
};
void layout(record::Io& io, ExportedRecording& x) {
  io("name", x.name);
  io("file", x.file);
}

std::string copied_text(const std::string& name, const std::string& file) {
  return "recording " + name + " written to " + file + "\n";
}

}  // namespace

int save_recording(const OnlineOptions& online, const std::filesystem::path& out) {
  RpcClient client = value_or_throw(RpcClient::connect(online));
  auto [json, saved] = value_or_throw(client.call(rpc::RecordingSave{}));
  if (!out.empty()) {
    copy_recording(client, saved.name, out);
    saved.file = out.string();
    json.as_object()["file"] = saved.file;
  }
  print(online, json, copied_text(saved.name, saved.file));
  return kDone;
}

int export_recording(const OnlineOptions& online, const std::string& name, const std::filesystem::path& out) {
  RpcClient client = value_or_throw(RpcClient::connect(online));
  copy_recording(client, name, out);
  print(online, record::to_json(ExportedRecording{name, out}), copied_text(name, out.string()));
  return kDone;
}

}  // namespace truepose::tools
