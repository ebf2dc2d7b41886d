#pragma once

#include <boost/asio/awaitable.hpp>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "daemon/cell/cell_runner.hpp"
#include "daemon/cell/service.hpp"

namespace truepose::daemon {

/// Whether the store can be written to, and is still where it was. The first failed write raises a fault.
/// Nothing that needs the store is started until an operator frees space or repairs the disk, and
/// acknowledges the fault. A stream continues: it does not need the store.
class StoreWatch {
 public:
  StoreWatch(const CellParts& parts, CellRunner& runner) : parts_{parts}, runner_{runner} {}

  void failed(const StoreError& error);
  bool failing() const { return runner_.faults().stands(FaultCode::Store); }
  /// Why a method is not carried out now.
  control::RpcError refusal() const;
  /// Writes to the store, before something is begun that it has to keep. @return why it cannot be
  boost::asio::awaitable<std::optional<control::RpcError>> try_it();
  /// Reopens the store if that is needed, and writes to it. @return why it still cannot be used
  boost::asio::awaitable<std::optional<control::RpcError>> acknowledge();
  /// Stores a change that has happened. If the write fails, the change is pending and retried every second.
  /// @param about  of several writes about the same only the last one is pending
  boost::asio::awaitable<void> keep(std::string about, std::function<StoreResult<void>()> write);
  /// Drops a pending write that a later, stored change replaces.
  void forget(const std::string& about) { pending_.erase(about); }
  /// Writes pending changes, and checks that the file is still there. Ends when cancelled.
  boost::asio::awaitable<void> watch();
  /// What is left to be done once the store can be written to again.
  void when_usable(std::function<boost::asio::awaitable<void>()> job) { when_usable_ = std::move(job); }

 private:
  boost::asio::awaitable<StoreResult<void>> try_again();
  boost::asio::awaitable<void> pay();
  boost::asio::awaitable<void> look();

  CellParts parts_;
  CellRunner& runner_;
  std::function<boost::asio::awaitable<void>()> when_usable_;
  using Write = std::function<StoreResult<void>()>;
  std::map<std::string, std::shared_ptr<const Write>> pending_;
};

}  // namespace truepose::daemon
