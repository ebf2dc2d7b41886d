#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <string>

#include "core/math/random.hpp"
#include "tests/world/cell.hpp"
#include "tests/world/orders.hpp"

namespace truepose::world {

/// Campaigns of other kinds than calibration and drift check, as people measure them.
class Measuring {
 public:
  Measuring(Cell& cell, SoakLog& log, Orders& orders, Random& random)
      : cell_{cell}, log_{log}, orders_{orders}, random_{random} {}

  /// Starts one of any kind. @return whether it runs
  boost::asio::awaitable<bool> start_one();
  /// Does with the last tool or campaign what is done once it is measured.
  boost::asio::awaitable<void> use_result();

 private:
  using Wait = boost::asio::awaitable<void>;

  boost::asio::awaitable<bool> start(boost::json::object what);
  boost::asio::awaitable<bool> touch_base();
  void turn_key(config::ScenarioFault::Mode mode);

  Cell& cell_;
  SoakLog& log_;
  Orders& orders_;
  Random& random_;
};

}  // namespace truepose::world
