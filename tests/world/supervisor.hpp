#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <cstdint>

#include "core/math/random.hpp"
#include "tests/world/cell.hpp"
#include "tests/world/judge/agreement_judge.hpp"
#include "tests/world/orders.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// A second client of the cell, an operator in an office, who looks, gives orders that cross those of the
/// panel, and takes control for a while.
class Supervisor {
 public:
  Supervisor(Cell& cell, SoakLog& log, AgreementJudge& agreement, std::uint64_t seed)
      : cell_{cell}, log_{log}, agreement_{agreement}, random_{seed} {}

  /// An event of its session: orders cross control that the panel takes.
  void take(const boost::json::object& event);
  boost::asio::awaitable<void> work(drivers::TimePoint end);
  const Orders& orders() const { return orders_; }

 private:
  using Wait = boost::asio::awaitable<void>;

  Wait look();
  Wait cross();
  Wait connect_as_job();
  Wait take_control();
  boost::asio::awaitable<bool> connect();
  Wait pass(drivers::Duration shortest, drivers::Duration longest);

  Cell& cell_;
  SoakLog& log_;
  AgreementJudge& agreement_;
  Random random_;
  Orders orders_{cell_.supervisor, log_};
};

}  // namespace truepose::world
