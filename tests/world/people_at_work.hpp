#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/math/random.hpp"
#include "tests/world/cell.hpp"
#include "tests/world/judge/agreement_judge.hpp"
#include "tests/world/judge/correction_judge.hpp"
#include "tests/world/judge/event_judge.hpp"
#include "tests/world/judge/files_judge.hpp"
#include "tests/world/judge/model_judge.hpp"
#include "tests/world/judge/point_judge.hpp"
#include "tests/world/judge/station_judge.hpp"
#include "tests/world/judge/status_judge.hpp"
#include "tests/world/judge/tool_judge.hpp"
#include "tests/world/measuring.hpp"
#include "tests/world/orders.hpp"
#include "tests/world/reading.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// People at the panel of a cell, who calibrate, produce and repair.
class PeopleAtWork {
 public:
  struct Judges {
    StatusJudge& states;
    AgreementJudge& agreement;
    EventJudge& events;
    ModelJudge& models;
    ToolJudge& tools;
    StationJudge& stations;
    CorrectionJudge& corrections;
    PointJudge& points;
    FilesJudge& files;
  };
  PeopleAtWork(Cell& cell, SoakLog& log, const Judges& judges, std::uint64_t seed)
      : cell_{cell}, log_{log}, judges_{judges}, random_{seed} {}

  /// Works until then, and leaves the cell in order.
  /// @param production_h_per_day  at most, of programs under correction
  boost::asio::awaitable<void> work(drivers::TimePoint end, double production_h_per_day);
  const Orders& orders() const { return orders_; }

  int campaigns = 0, programs = 0;

 private:
  using Wait = boost::asio::awaitable<void>;

  Wait next_task(double production_h_per_day);
  Wait pause(drivers::Duration shortest, drivers::Duration longest);
  Wait calibrate();
  Wait check_drift();
  /// @return its id; empty where it did not begin
  boost::asio::awaitable<std::string> campaign(std::string method, boost::json::object params);
  Wait measure();
  Wait stream_once();
  Wait produce(double production_h_per_day);
  Wait run_program();
  Wait activate_a_model();
  Wait replace_model();
  Wait save_recording();
  Wait back_up();
  Wait restore();
  void select(const char* program);
  void keep_motion_program();
  boost::asio::awaitable<boost::json::object> status();
  Wait bring_to_order();
  Wait act_on(const boost::json::object& seen);

  Cell& cell_;
  SoakLog& log_;
  const Judges judges_;
  Random random_;
  std::filesystem::path backup_;  // the last
  int restores_ = 0;
  Orders orders_{cell_.panel, log_};
  Measuring measuring_{cell_, log_, orders_, random_};
  Reading reading_{cell_, log_, random_};
};

}  // namespace truepose::world
