#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "tests/world/cell.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges whether cell.status, model.list, stream.status, the metrics and the events say the same, while
/// nothing changes.
class AgreementJudge {
 public:
  /// @param client  whose events it is given
  AgreementJudge(Cell& cell, Client& client, SoakLog& log) : cell_{cell}, client_{client}, log_{log} {}

  void take(const boost::json::object& event);
  void asks() { ++orders_, ++under_way_; }  ///< a client gives an order
  void answered() { --under_way_; }
  void sessions_change() { ++sessions_; }  ///< one begins or ends
  void restarted();                        ///< what stood before is over
  /// The store was replaced by a backup, whose active model no event names.
  void restored() { knows_model_ = false; }

  boost::asio::awaitable<void> look();
  std::uint64_t looks = 0;  ///< while nothing changed

 private:
  using Numbers = std::map<std::string, double>;

  std::uint64_t changes() const { return events_ + orders_ + sessions_; }
  void compare(const boost::json::object& status, const boost::json::array& models, const Numbers& metrics);
  void compare_sessions(const std::string& counted);
  void compare_with_events(const boost::json::object& status);
  void expect(const std::string& what, const std::string& one, const std::string& other);

  Cell& cell_;
  Client& client_;
  SoakLog& log_;
  std::uint64_t events_ = 0, orders_ = 0, sessions_ = 0;
  int under_way_ = 0;   // orders
  std::string stream_;  // its state, by the last event
  std::string state_;   // by the last event; empty: none since the daemon began
  std::string model_;   // that is active, by the events
  bool knows_model_ = false;
  std::set<std::string> faults_;  // that stand
  bool hears_ = true;             // the daemon that runs: what came late before was of one before it
  bool knows_faults_ = true;      // by its status, since the daemon began
};

}  // namespace truepose::world
