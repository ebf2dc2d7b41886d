#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <string>

#include "daemon/threads/signal.hpp"
#include "tests/world/cell.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// What shows a cell to others, as the OPC UA server does: hears all events, and asks for the status after
/// each that changes something. Judges that the status is that of the events before it.
class Mirror {
 public:
  Mirror(Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {}

  /// An event of its session.
  void take(const boost::json::object& event);
  boost::asio::awaitable<void> work();

  std::uint64_t compared = 0;  ///< statuses, with the last event

 private:
  boost::asio::awaitable<void> look();

  Cell& cell_;
  SoakLog& log_;
  Client& client_ = cell_.mirror;
  daemon::Signal changed_;
  bool has_changed_ = false;
  std::string state_;  // by the events of this session; empty: not known yet
};

}  // namespace truepose::world
