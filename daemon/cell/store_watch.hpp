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

/// Whether the store can be written to, and is still where it was. From the first write that failed a fault
/// stands, and nothing that would need the store is begun, until somebody has made room, or mended the disk,
/// and acknowledges it. What goes on without the store does: a stream corrects.
class StoreWatch {
 public:
  StoreWatch(const CellParts& parts, CellRunner& runner) : parts_{parts}, runner_{runner} {}

  void failed(const StoreError& error);
  bool failing() const { return runner_.faults().stands(FaultCode::Store); }
  /// Why a method is not carried out now.
  control::RpcError refusal() const;
  /// Writes to the store, before something is begun that it has to keep. @return why it cannot be
  boost::asio::awaitable<std::optional<control::RpcError>> try_it();
  /// Opens the store anew where that is needed, and writes to it. @return why it still cannot be used
  boost::asio::awaitable<std::optional<control::RpcError>> acknowledge();
  /// What has happened and stands, whether or not the store can be told of it: where it cannot, that is owed,
  /// and tried every second. @param about  of several about the same only the last one is owed
  boost::asio::awaitable<void> keep(std::string about, std::function<StoreResult<void>()> write);
  /// Something else has happened meanwhile, of which the store knows.
  void forget(const std::string& about) { owed_.erase(about); }
  /// Writes what is owed, and sees that the file is still there. Ends when cancelled.
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
  std::map<std::string, std::shared_ptr<const Write>> owed_;
};

}  // namespace truepose::daemon
