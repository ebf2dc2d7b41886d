#include "tests/world/judge/status_judge.hpp"

#include <boost/json/array.hpp>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace json = boost::json;

void StatusJudge::take(const json::object& change) {
  state_ = text_at(change, "state");
  // Of a fault before the end a panel without connection hears afterwards.
  if (state_ == "fault") armed_before_ = false;
}

void StatusJudge::take_model(const json::object& change) {
  const std::string what = text_at(change, "change");
  if (what == "deactivated") without_model_ = true;
  if (what == "activated") without_model_ = false;
}

void StatusJudge::restarted(bool order_lost) {
  armed_before_ = (armed_before_ || state_ == "armed") && !order_lost && !without_model_;
  state_.clear();
}

void StatusJudge::restored() {
  state_.clear();
  armed_before_ = false;
  restored_ = true;
}

void StatusJudge::see(const json::object& status) {
  const std::string state = text_at(status, "state");
  if (std::exchange(armed_before_, false) && state != "armed" && status.at("faults").as_array().empty())
    log_.broken("the stream was armed before the daemon ended, and is " + state);
  if (std::exchange(restored_, false) && state == "armed")
    log_.broken("the stream is armed by a restored store");
}

}  // namespace truepose::world
