#include "tools/truepose/online/recording_commands.hpp"

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>

#include "config/text_file.hpp"
#include "proto/control/base64.hpp"
#include "tools/truepose/online/rpc_client.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

/// Part by part, into a file that appears whole or not at all.
void copy_recording(RpcClient& client, const std::string& name, const std::filesystem::path& out) {
  config::UnfinishedFile file{out};
  for (std::uint64_t offset = 0;;) {
    const json::value answer =
        value_or_throw(client.call("recording.get", {{"name", name}, {"offset", offset}}));
    const auto part = control::from_base64(string_at(answer, "/data"));
    if (!part) throw CommandError{kFailed, "the daemon's recording " + name + " came damaged"};
    if (part->empty()) break;
    file.stream() << *part;
    offset += part->size();
  }
  file.close();
  file.take_place();
}

std::string written_text(const json::value& recording) {
  return "recording " + string_at(recording, "/name") + " written to " + string_at(recording, "/file") + "\n";
}

}  // namespace

int save_recording(const OnlineOptions& online, const std::filesystem::path& out) {
  RpcClient client = value_or_throw(RpcClient::connect(online));
  json::value saved = value_or_throw(client.call("recording.save", {}));
  if (!out.empty()) {
    copy_recording(client, string_at(saved, "/name"), out);
    saved.as_object()["file"] = out.string();
  }
  print(online, saved, written_text);
  return kDone;
}

int export_recording(const OnlineOptions& online, const std::string& name, const std::filesystem::path& out) {
  RpcClient client = value_or_throw(RpcClient::connect(online));
  copy_recording(client, name, out);
  print(online, {{"name", name}, {"file", out.string()}}, written_text);
  return kDone;
}

}  // namespace truepose::tools
