#include "proto/rpc/backup.hpp"

namespace truepose::rpc {

void layout(Io& io, StoreBackup::Result& x) {
  io.about("By which store.get_backup knows it").format("uuid")("id", x.id);
  io.about("On the daemon's machine")("file", x.file);
  io.about("Its size")("bytes", x.bytes);
}
const Method& StoreBackup::method() {
  static const Method kMethod{
      .name = "store.backup",
      .role = Role::Engineer,
      .summary = "Copies the store while it is used: campaigns, points, models, events",
      .description =
          "The copy is checked and on the disk when the answer comes. The last one stays in the store's "
          "folder. Access list and audit log are separate files.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::Busy, ErrorCode::Store},
  };
  return kMethod;
}

void layout(Io& io, StoreGetBackup::Result& x) {
  io.about("Of the backup").format("uuid")("id", x.id);
  io.about("First byte of the part")("offset", x.offset);
  io.about("Base64 of at most 32 KiB; empty at the end")("data", x.data);
}
void layout(Io& io, StoreGetBackup& x) {
  io.about("Of the backup").format("uuid")("id", x.id, kIdSize);
  io.about("First byte of the part").defaulted("offset", x.offset);
}
const Method& StoreGetBackup::method() {
  static const Method kMethod{
      .name = "store.get_backup",
      .summary = "A part of the last backup; ask on behind it until none comes",
      .description =
          "With its id, which store.backup alone answers, it can be read until another is made or the "
          "daemon ends.",
      .errors = {ErrorCode::NotFound},
  };
  return kMethod;
}

std::vector<Described> backup_methods() { return {described<StoreBackup>(), described<StoreGetBackup>()}; }

}  // namespace truepose::rpc
