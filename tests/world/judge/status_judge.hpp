#pragma once

#include <boost/json/object.hpp>
#include <string>

#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges what the daemon says of its state: a stream that was armed before a restart, with a model, is armed
/// after it.
class StatusJudge {
 public:
  explicit StatusJudge(SoakLog& log) : log_{log} {}

  /// An event of the topic cell.
  void take(const boost::json::object& change);
  /// An event of the topic model.
  void take_model(const boost::json::object& change);
  /// Of the cell, by its last event since the daemon started; empty: there was none.
  const std::string& state() const { return state_; }
  /// The daemon starts again.
  /// @param order_lost  one that may have disarmed the stream
  void restarted(bool order_lost);
  /// An order is given, which may disarm the stream.
  void ordered() { armed_before_ = restored_ = false; }
  /// The store was replaced by a backup, whose stream is not armed whatever it was.
  void restored();
  /// The result of cell.status.
  void see(const boost::json::object& status);

 private:
  SoakLog& log_;
  std::string state_;          // of the cell, by its last event
  bool armed_before_ = false;  // as a restarted daemon has to be
  bool restored_ = false, without_model_ = false;
};

}  // namespace truepose::world
