#include "tools/truepose/online/backup_command.hpp"

#include <sys/stat.h>

#include <boost/json/value.hpp>

#include "config/text_file.hpp"
#include "proto/control/base64.hpp"
#include "proto/rpc/backup.hpp"
#include "tools/truepose/online/rpc_client.hpp"
#include "tools/truepose/progress_line.hpp"

namespace truepose::tools {
namespace {

struct WrittenBackup {
  std::string id;
  std::filesystem::path file;
  std::uint64_t bytes = 0;
};
void layout(record::Io& io, WrittenBackup& x) {
  io("id", x.id);
  io("file", x.file);
  io("bytes", x.bytes);
}

}  // namespace

int back_up(const OnlineOptions& online, const std::filesystem::path& out) {
  ::umask(S_IRWXG | S_IRWXO);  // what a store says is for its owner
  ProgressLine line{"backup"};
  RpcClient client = value_or_throw(RpcClient::connect(online));
  const rpc::StoreBackup::Result made = value_or_throw(client.call(rpc::StoreBackup{})).record;
  config::UnfinishedFile file{out};
  rpc::StoreGetBackup request{.id = made.id};
  while (request.offset < made.bytes) {
    const auto part = control::from_base64(value_or_throw(client.call(request)).record.data);
    if (!part || part->empty()) break;
    file.stream() << *part;
    request.offset += part->size();
    line.show(static_cast<double>(request.offset) / static_cast<double>(made.bytes));
  }
  if (request.offset != made.bytes)
    throw CommandError{kFailed, "the daemon's backup came in part; make it again"};
  file.close();
  file.take_place();
  print(online, record::to_json(WrittenBackup{made.id, out, made.bytes}),
        "backup written to " + out.string() + "\nnext: truepose restore " + out.string() +
            " --cell CELL.yaml, while no daemon runs\n");
  return kDone;
}

}  // namespace truepose::tools
