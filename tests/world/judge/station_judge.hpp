#pragma once

#include <Eigen/Core>
#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <map>
#include <string>

#include "tests/world/cell.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges drift checks: each finds the tracker moved by what it has moved since the model was made, and
/// nothing else.
class StationJudge {
 public:
  StationJudge(Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {}

  /// An event of the topic campaign.
  void take_progress(const boost::json::object& progress);
  /// An event of the topic model.
  void take_change(const boost::json::object& change);
  /// Now and then: whether the tracker moves while a campaign measures.
  void look();
  bool is_measuring() const { return measures_; }

  /// Before a drift check: which model it judges.
  boost::asio::awaitable<void> before_check(Client& client);
  boost::asio::awaitable<void> after_check(Client& client, std::string campaign);

  std::uint64_t checks = 0;  ///< judged

 private:
  void judge(const boost::json::object& drift, const Eigen::Vector3d& moved_mm);

  Cell& cell_;
  SoakLog& log_;
  Eigen::Vector3d last_moved_mm_{0, 0, 0};  // of the tracker, at the last look
  std::string campaign_;                    // the last
  drivers::TimePoint campaign_began_{};
  bool measures_ = false;                    // it does
  Eigen::Vector3d measured_at_mm_{0, 0, 0};  // what the tracker had moved when it did last
  bool is_clear_ = false;                    // while it did, the tracker stood still
  // Models, and what the tracker had moved when they were made.
  std::map<std::string, Eigen::Vector3d> made_;
  std::string model_;           // that the drift check judges
  drivers::TimePoint began_{};  // it
};

}  // namespace truepose::world
