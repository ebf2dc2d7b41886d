#pragma once

#include <boost/json/object.hpp>
#include <map>
#include <optional>
#include <string>

#include "tests/world/client.hpp"
#include "tests/world/methods.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges roles and control of the clients: each order is refused where its client's role is too low, or
/// where another client surely has control, and by that error where no other client can have it.
class ControlJudge {
 public:
  ControlJudge(SoakLog& log, const Methods& methods) : log_{log}, methods_{methods} {}

  void asks(const Client& client, const Request& request);
  void answered(const Client& client, const Request& request);
  /// The session of a client began or ended.
  void sees(const Client& client, bool is_open);
  /// The daemon starts again, and knows of no control.
  void restarted();

 private:
  /// Of a user: from when until when it has control for certain, and until when it may have it.
  struct Control {
    drivers::TimePoint from = drivers::TimePoint::max(), until = drivers::TimePoint::min(),
                       latest = drivers::TimePoint::min();
    int asked_for = 0;  // requests without an answer
    std::optional<drivers::TimePoint> unconnected_since{};

    bool is_certain(const Request& during) const;
    bool is_possible(const Request& during) const;
  };

  void take_change(const Client& client, const Request& request);
  void judge_order(const Client& client, const Request& request);
  void judge_holder(const Request& request);
  std::string certain_holder(const Request& during, const std::string& but = {}) const;
  bool can_be_held(const Request& during, const std::string& but = {}) const;

  SoakLog& log_;
  const Methods& methods_;
  std::map<std::string, Control> controls_;  // by the users' names
};

}  // namespace truepose::world
