#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// Time (s) of a point-to-point motion with all joints starting and ending together: that of the joint that
/// needs longest, at its greatest speed, with its acceleration (trapezoidal profile).
double travel_time_s(const RobotModel& robot, const JointVector& from, const JointVector& to);

/// Told how much of what is done, 0 to 1: many poses take minutes. May be empty.
using PlanProgress = std::function<void(double share, std::string_view doing)>;

/// Time that the arm needs from one place to another.
using TravelTime = std::function<double(const JointVector& from, const JointVector& to)>;

struct TourOptions {
  JointVector start;      ///< where the arm is before the first pose
  std::size_t first = 0;  ///< so many poses of the list come before the others
  JointVector
      reference;  ///< measured again and again, so that drift shows; regarded where reference_every > 0
  int reference_every = 0;  ///< poses from one visit to the reference to the next; 0: none
  int kicks = 300;          ///< local optima that are left by a random change, to find a better one
  std::uint64_t seed = 0;   ///< of those changes
  PlanProgress progress = {};
};

/// An order of poses.
struct Tour {
  std::vector<std::size_t> order;  ///< indices of the poses
  double time_s = 0;  ///< of all motions from the start to the last pose, visits to the reference included
};

/// Times of all motions of which a tour may consist, taken to be the same both ways, each asked for once. The
/// reference is visited before the first pose, after every `reference_every` poses, and after the last.
class TourTimes {
 public:
  TourTimes(const TravelTime& time, std::span<const JointVector> poses, const TourOptions& options);

  std::size_t poses() const { return poses_; }
  std::size_t reference_every() const { return every_; }

  double between(std::size_t a, std::size_t b) const { return between_[a * poses_ + b]; }
  /// To a pose that is visited first.
  double from_start(std::size_t a) const { return from_start_[a]; }

  /// Time that an order takes, s.
  double total(std::span<const std::size_t> order) const {
    return order.empty() ? 0 : part(order, 0, order.size() + 1);
  }

  /// Time of the motions to places first .. end - 1 of an order; the last place is the reference at the end.
  double part(std::span<const std::size_t> order, std::size_t first, std::size_t end) const;

 private:
  double to(std::size_t place, std::span<const std::size_t> order) const;

  std::size_t poses_;
  std::size_t every_;
  std::vector<double> between_, from_start_, from_reference_;
};

/// An order that takes little time: nearest neighbours, then 2-opt and or-opt to a local optimum, again and
/// again after a double bridge (iterated local search). Source: Lourenco, Martin, Stutzle, Iterated Local
/// Search (2003); Or (1976).
///
/// @param options  those of the times
Tour shortest_tour(const TourTimes& times, const TourOptions& options);

}  // namespace truepose
