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

/// Times of all motions of which a tour may consist, taken to be the same both ways, each asked for at most
/// once, and only where the tour may take that motion. The reference is visited before the first pose, after
/// every `reference_every` poses, and after the last.
class TourTimes {
 public:
  /// @param at_least  quick to ask for, never more than `time`
  TourTimes(TravelTime time, const TravelTime& at_least, std::span<const JointVector> poses,
            const TourOptions& options);

  std::size_t poses() const { return poses_.size(); }
  std::size_t reference_every() const { return every_; }

  double between(std::size_t a, std::size_t b) const;
  /// The same where it is known by now, else a time that it does not fall below.
  double at_least(std::size_t a, std::size_t b) const { return times_[a * poses() + b].s; }
  /// To a pose that is visited first.
  double from_start(std::size_t a) const { return from_start_[a]; }
  double from_reference(std::size_t a) const { return from_reference_[a]; }
  /// Whether the arm comes to this place of an order, neither the first nor behind the last, by the
  /// reference.
  bool visits(std::size_t place) const { return every_ > 0 && place % every_ == 0; }

  /// Time that an order takes, s.
  double total(std::span<const std::size_t> order) const {
    return order.empty() ? 0 : part(order, 0, order.size() + 1);
  }

  /// Time of the motions to places first .. end - 1 of an order; the last place is the reference at the end.
  double part(std::span<const std::size_t> order, std::size_t first, std::size_t end) const;

 private:
  struct Known {
    double s;
    bool exact;
  };
  double to(std::size_t place, std::span<const std::size_t> order) const;

  std::vector<JointVector> poses_;
  TravelTime time_;
  std::size_t every_;
  mutable std::vector<Known> times_;
  std::vector<double> from_start_, from_reference_;
};

/// An order that takes little time: nearest neighbours, then 2-opt and or-opt to a local optimum, again and
/// again after a double bridge (iterated local search). Of many poses a change is tried only where it brings
/// near neighbours together, so that a pass is linear in them. Source: Lourenco, Martin, Stutzle, Iterated
/// Local Search (2003); Or (1976); Johnson, McGeoch, The traveling salesman problem: a case study (1997).
///
/// @param options  those of the times
Tour shortest_tour(const TourTimes& times, const TourOptions& options);

}  // namespace truepose
