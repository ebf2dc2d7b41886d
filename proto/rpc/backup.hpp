#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

/// store.backup
struct StoreBackup : NoParameters {
  struct Result {
    std::string id{};
    std::string file{};
    std::uint64_t bytes = 0;
  };
  static const Method& method();
};
void layout(Io& io, StoreBackup::Result& x);

/// store.get_backup
struct StoreGetBackup {
  struct Result {
    std::string id{};
    std::uint64_t offset = 0;
    std::string data{};
  };
  static const Method& method();

  std::string id{};
  std::uint64_t offset = 0;
};
void layout(Io& io, StoreGetBackup& x);
void layout(Io& io, StoreGetBackup::Result& x);

/// The methods of this file.
std::vector<Described> backup_methods();

}  // namespace truepose::rpc
