#include "tools/truepose/online/backup_command.hpp"

#include <sys/stat.h>

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>

#include "config/text_file.hpp"
#include "proto/control/base64.hpp"
#include "tools/truepose/online/rpc_client.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

namespace json = boost::json;

int back_up(const OnlineOptions& online, const std::filesystem::path& out) {
  ::umask(S_IRWXG | S_IRWXO);  // what a store says is for its owner
  RpcClient client = value_or_throw(RpcClient::connect(online));
  const json::value made = value_or_throw(client.call("store.backup", {}));
  const std::string id = string_at(made, "/id");
  const auto bytes = made.at("bytes").to_number<std::uint64_t>();
  config::UnfinishedFile file{out};
  std::uint64_t offset = 0;
  while (offset < bytes) {
    const json::value answer =
        value_or_throw(client.call("store.get_backup", {{"id", id}, {"offset", offset}}));
    const auto part = control::from_base64(string_at(answer, "/data"));
    if (!part || part->empty()) break;
    file.stream() << *part;
    offset += part->size();
  }
  if (offset != bytes) throw CommandError{kFailed, "the daemon's backup came in part; make it again"};
  file.close();
  file.take_place();
  print(online, {{"id", id}, {"file", out.string()}, {"bytes", bytes}}, [](const json::value& written) {
    return "backup written to " + string_at(written, "/file") + "\nnext: truepose restore " +
           string_at(written, "/file") + " --cell CELL.yaml, while no daemon runs\n";
  });
  return kDone;
}

}  // namespace truepose::tools
