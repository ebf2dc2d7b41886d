#pragma once

#include <filesystem>
#include <string>

#include "daemon/cell/service.hpp"
#include "proto/rpc/backup.hpp"

namespace truepose::daemon {

/// Copies of the store while it is used. The last one stays in the store's folder; clients read it part by
/// part.
class BackupService {
 public:
  explicit BackupService(const CellParts& parts) : parts_{parts} {}

  static std::vector<Served<BackupService>> methods();

 private:
  Reply<rpc::StoreBackup> backup(rpc::StoreBackup);
  Reply<rpc::StoreGetBackup> get(rpc::StoreGetBackup request);

  /// @return its size in bytes
  boost::asio::awaitable<StoreResult<std::uintmax_t>> copy();
  std::filesystem::path file() const { return parts_.config.store.string() + ".backup"; }

  CellParts parts_;
  std::string last_;  ///< name of the one that is there, by which no other is taken for it; empty: none since
                      ///< the start
  bool busy_ = false;
};

}  // namespace truepose::daemon
