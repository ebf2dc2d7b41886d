#pragma once

#include <boost/asio/awaitable.hpp>
#include <functional>
#include <optional>
#include <utility>

#include "daemon/cell/cell_runner.hpp"
#include "daemon/cell/service.hpp"

namespace truepose::daemon {

/// Whether the store can be written to. From the first write that failed a fault stands, and nothing that
/// would need the store is begun, until somebody has made room, or mended the disk, and acknowledges it. What
/// goes on without the store does: a stream corrects.
class StoreWatch {
 public:
  StoreWatch(const CellParts& parts, CellRunner& runner) : parts_{parts}, runner_{runner} {}

  void failed(const StoreError& error);
  bool failing() const { return runner_.faults().stands(kStoreFault); }
  /// Why nothing may be begun; nothing where it may.
  std::optional<control::RpcError> refusal() const;
  /// Opens the store anew where that is needed, and writes to it. @return why it still cannot be used
  boost::asio::awaitable<std::optional<control::RpcError>> acknowledge();
  /// What is left to be done once the store can be written to again.
  void when_usable(std::function<boost::asio::awaitable<void>()> job) { when_usable_ = std::move(job); }

 private:
  CellParts parts_;
  CellRunner& runner_;
  std::function<boost::asio::awaitable<void>()> when_usable_;
};

}  // namespace truepose::daemon
