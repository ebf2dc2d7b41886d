#include "daemon/cell/backup_service.hpp"

#include <cstdint>
#include <memory>
#include <system_error>
#include <utility>

#include "config/text_file.hpp"
#include "daemon/cell/busy.hpp"
#include "daemon/cell/file_part.hpp"
#include "daemon/log/log.hpp"
#include "proto/control/base64.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace fs = std::filesystem;
using control::ErrorCode;
using control::RpcError;

namespace {

/// A copy must not take the room that the store itself needs.
StoreResult<void> room_for_copy(const fs::path& store) {
  std::error_code unknown;
  const std::uintmax_t bytes = fs::file_size(store, unknown);
  const fs::space_info disk = fs::space(config::folder_of(store), unknown);
  if (unknown || disk.available / 2 >= bytes) return {};
  return std::unexpected(StoreError{"backup: " + store.string() + " has " + std::to_string(bytes) +
                                        " bytes, and its disk room for " + std::to_string(disk.available) +
                                        " more: twice as many are needed; make room on the disk",
                                    true});
}

}  // namespace

std::vector<Served<BackupService>> BackupService::methods() {
  return {&BackupService::backup, &BackupService::get};
}

asio::awaitable<StoreResult<std::uintmax_t>> BackupService::copy() {
  using Copy = std::shared_ptr<StoreBackup>;
  auto begin = [this]() -> StoreResult<Copy> {
    if (const auto room = room_for_copy(parts_.config.store); !room) return std::unexpected(room.error());
    auto begun = parts_.store.begin_backup(file());
    if (!begun) return std::unexpected(begun.error());
    return std::make_shared<StoreBackup>(*std::move(begun));
  };
  auto copy = co_await parts_.store_thread.ask(begin);
  if (!copy) co_return std::unexpected(copy.error());
  for (bool all = false; !all;) {
    // A job each: what was given to the thread meanwhile comes between.
    auto step = [copy = *copy] { return copy->step(); };
    auto done = co_await parts_.store_thread.ask(step);
    if (!done) co_return std::unexpected(done.error());
    all = *done;
  }
  auto finish = [copy = *copy] { return copy->finish(); };
  auto bytes = co_await parts_.compute_thread.ask(finish);
  co_return bytes;
}

Reply<rpc::StoreBackup> BackupService::backup(rpc::StoreBackup) {
  if (busy_) co_return std::unexpected(RpcError{ErrorCode::Busy, "another backup is under way"});
  const Busy busy{busy_};
  last_.clear();
  auto bytes = co_await copy();
  if (!bytes) co_return std::unexpected(store_unusable(bytes.error()));
  last_ = random_uuid(parts_.random);
  log_info("backup: " + file().string() + ", " + std::to_string(*bytes) + " bytes");
  co_return rpc::StoreBackup::Result{.id = last_, .file = file().string(), .bytes = *bytes};
}

Reply<rpc::StoreGetBackup> BackupService::get(rpc::StoreGetBackup request) {
  auto job = [file = file(), offset = request.offset] { return part_of(file, offset); };
  auto part = co_await parts_.store_thread.ask(job);
  // Asked last: another may have begun to take its place meanwhile.
  if (last_.empty() || request.id != last_)
    co_return std::unexpected(
        RpcError{ErrorCode::NotFound, "no such backup: another was made since, or none"});
  if (!part) co_return std::unexpected(RpcError{ErrorCode::Internal, part.error()});
  co_return rpc::StoreGetBackup::Result{
      .id = request.id, .offset = request.offset, .data = control::base64(*part)};
}

}  // namespace truepose::daemon
