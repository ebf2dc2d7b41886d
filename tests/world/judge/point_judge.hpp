#pragma once

#include <Eigen/Core>
#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "tests/world/cell.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges measured points: they become more, each is where the reflector was, unless the tracker misled. What
/// was reported is in the store and all that is in the store was reported, each pose once.
class PointJudge {
 public:
  PointJudge(Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {}

  /// An event of the topic measurement.
  /// @param late  the arm may have moved since
  void take(const boost::json::object& measurement, bool late);
  /// An event of the topic campaign.
  void take_progress(const boost::json::object& progress);
  /// Reads the points of all campaigns, and compares them with those that were reported.
  boost::asio::awaitable<void> compare_with_store(Client& client);

  /// A backup was made, of what has been reported so far.
  void backed_up() { backed_up_ = campaigns_; }
  /// What was reported since that backup is gone.
  void restored() {
    campaigns_ = backed_up_;
    done_.clear();
  }

  std::uint64_t points = 0;     ///< reported
  double largest_error_mm = 0;  ///< of those that no fault explains
  std::uint64_t compared = 0;   ///< with where the reflector was

 private:
  struct Campaign {
    Eigen::Vector3d tracker_moved_mm{0, 0, 0};  // as it began
    std::set<std::string> reported;             // points
    std::string points_of{};                    // that measured its points; empty: itself
  };

  void compare_with_truth(const std::string& campaign, const boost::json::object& measurement);
  boost::asio::awaitable<void> compare(Client& client, std::string id);
  void judge_stored(const std::string& id, const boost::json::object& point);

  Cell& cell_;
  SoakLog& log_;
  std::map<std::string, Campaign> campaigns_, backed_up_;
  std::map<std::string, std::int64_t> done_;     // poses of campaigns, by their last event
  std::set<std::string> stored_, stored_poses_;  // of the campaign that is compared
};

}  // namespace truepose::world
