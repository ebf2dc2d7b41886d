#include "core/plan/tour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/math/random.hpp"
#include "core/step_count.hpp"

namespace truepose {
namespace {

// Below this a change is rounding, and would be made for ever.
constexpr double kLeastGain_s = 1e-9;
constexpr std::size_t kLongestMovedRun = 3;
constexpr std::size_t kNeighbours = 10;
// Places: a random change leaves the rest of a long order as good as it was.
constexpr std::size_t kWidestKick = 100;

double joint_time_s(const Joint& joint, double distance) {
  if (joint.acceleration <= 0) return distance / joint.speed;
  const double ramp_s = joint.speed / joint.acceleration;
  if (distance <= joint.speed * ramp_s) return 2 * std::sqrt(distance / joint.acceleration);
  return distance / joint.speed + ramp_s;
}

/// The time of a motion as exactly as it is needed.
using Time = double (TourTimes::*)(std::size_t, std::size_t) const;

/// The nearest of the poses at the places first .. end - 1, as seen from that before them. Exact times are
/// asked for by their least, until no other can be nearer.
std::size_t nearest(const TourTimes& times, const std::vector<std::size_t>& order, std::size_t first,
                    std::size_t end) {
  const auto least_s = [&](std::size_t place) {
    return first == 0 ? times.from_start(order[place]) : times.at_least(order[first - 1], order[place]);
  };
  for (;;) {
    std::size_t best = first;
    for (std::size_t place = first + 1; place < end; ++place)
      if (least_s(place) < least_s(best)) best = place;
    const double before_s = least_s(best);
    if (first == 0 || times.between(order[first - 1], order[best]) <= before_s) return best;
  }
}

std::vector<std::size_t> nearest_neighbours(const TourTimes& times, std::size_t first,
                                            const PlanProgress& progress) {
  std::vector<std::size_t> order(times.poses());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t next = 0; next < order.size(); ++next) {
    if (progress)
      progress(static_cast<double>(next) / static_cast<double>(order.size()), "motions between the poses");
    std::swap(order[next], order[nearest(times, order, next, next < first ? first : order.size())]);
  }
  return order;
}

/// Of each pose those that are nearest to it by the least that a motion takes.
std::vector<std::vector<std::size_t>> neighbours_of_each(const TourTimes& times) {
  std::vector<std::vector<std::size_t>> all;
  for (std::size_t pose = 0; pose < times.poses(); ++pose) {
    std::vector<std::size_t> others(times.poses());
    std::iota(others.begin(), others.end(), std::size_t{0});
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(pose));
    const auto count = static_cast<std::ptrdiff_t>(std::min(kNeighbours, others.size()));
    std::ranges::partial_sort(others, others.begin() + count, {},
                              [&](std::size_t other) { return times.at_least(pose, other); });
    others.resize(static_cast<std::size_t>(count));
    all.push_back(std::move(others));
  }
  return all;
}

/// Another order of the poses at the places first .. end - 1: by the place from which each comes.
struct Change {
  std::size_t first, end;
  std::size_t middle;  ///< that comes first; first: all are reversed

  bool reverses() const { return middle == first; }
  std::size_t from(std::size_t place) const {
    if (place < first || place >= end) return place;
    if (reverses()) return first + end - 1 - place;
    const std::size_t moved = place + (middle - first);
    return moved < end ? moved : moved - (end - first);
  }
};

/// Tries changes of an order, each between two places, and keeps those that save time.
class LocalSearch {
 public:
  /// @param neighbours  neighbours_of_each()
  /// @param first       places that only change among themselves
  LocalSearch(const TourTimes& times, const std::vector<std::vector<std::size_t>>& neighbours,
              std::size_t first, std::vector<std::size_t>& order)
      : times_{times},
        neighbours_{neighbours},
        first_{first},
        order_{order},
        place_(order.size()),
        to_look_at_(order.size()) {
    note_places(0, order_.size());
  }

  /// @param begin, end  places about which the order may be improved: elsewhere it was searched before
  void run(std::size_t begin, std::size_t end) {
    times_.total(order_);  // whose steps are known from now on
    look_about(begin, end);
    while (improve_once()) {
    }
  }

 private:
  bool improve_once() {
    bool improved = false;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      if (!to_look_at_[i]) continue;
      to_look_at_[i] = false;
      count_step();
      const std::size_t limit = i < first_ ? first_ : order_.size();
      if (times_.reference_every() > 0 || limit <= i + kFew) {
        for (std::size_t j = i + 2; j <= std::min(limit, i + reach()); ++j) {
          improved |= reverse_and_move(i, j);
          improved |= swap(i, j - 1);
        }
      } else {
        improved |= change_to_neighbours(i, limit);
      }
      improved |= swap_to_neighbours(i);
    }
    return improved;
  }

  // So many places all are tried.
  static constexpr std::size_t kFew = 50;
  /// Visits to the reference part the order into runs that hardly feel each other.
  std::size_t reach() const { return times_.reference_every() > 0 ? 2 * times_.reference_every() : kFew; }

  /// Changes that bring a neighbour to the place behind the one before i, or to that behind the one at i.
  bool change_to_neighbours(std::size_t i, std::size_t limit) {
    bool improved = false;
    const auto change_at = [&](std::size_t j) {
      if (j >= i + 2 && j <= limit) improved |= reverse_and_move(i, j);
    };
    if (i > 0)
      for (const std::size_t neighbour : neighbours_[order_[i - 1]])
        for (std::size_t run = 1; run <= kLongestMovedRun; ++run) change_at(place_[neighbour] + run);
    for (const std::size_t neighbour : neighbours_[order_[i]])
      for (std::size_t run = 0; run <= kLongestMovedRun; ++run) change_at(place_[neighbour] + run);
    return improved;
  }

  /// Swaps that bring a neighbour of those at its sides to place i.
  bool swap_to_neighbours(std::size_t i) {
    bool improved = false;
    const auto swap_in = [&](std::size_t side) {
      for (const std::size_t neighbour : neighbours_[order_[side]]) {
        const std::size_t k = place_[neighbour];
        if (k != i && (k < first_) == (i < first_)) improved |= swap(std::min(i, k), std::max(i, k));
      }
    };
    if (i > 0) swap_in(i - 1);
    if (i + 1 < order_.size()) swap_in(i + 1);
    return improved;
  }

  bool reverse_and_move(std::size_t i, std::size_t j) {
    bool improved = attempt({i, j, i});
    for (std::size_t run = 1; run <= kLongestMovedRun && run < j - i; ++run) {
      improved |= attempt({i, j, i + run});
      if (run < j - i - run) improved |= attempt({i, j, j - run});
    }
    return improved;
  }

  /// Of a motion to a place, where the poses of the order come from other places.
  template <typename From>
  double motion_s(std::size_t place, From from, Time time) const {
    if (place == 0) return times_.from_start(order_[from(0)]);
    const std::size_t a = order_[from(place - 1)];
    if (place == order_.size()) return times_.from_reference(a);
    return (times_.*time)(a, order_[from(place)]);
  }
  /// What a visit to the reference costs on the way to a place.
  template <typename From>
  double detour_s(std::size_t place, From from, Time time) const {
    const std::size_t a = order_[from(place - 1)], b = order_[from(place)];
    return times_.from_reference(a) + times_.from_reference(b) - (times_.*time)(a, b);
  }

  /// By how much an order gets longer: at the seams, and where visits part other poses than before.
  double longer_s(const Change& change, Time time) const {
    const auto before = [](std::size_t place) { return place; };
    const auto after = [&](std::size_t place) { return change.from(place); };
    double sum_s = 0;
    for (const std::size_t seam : {change.first, change.end})
      sum_s += motion_s(seam, after, time) - motion_s(seam, before, time);
    if (!change.reverses())
      sum_s += motion_s(change.first + change.end - change.middle, after, time) -
               motion_s(change.middle, before, time);
    const std::size_t every = times_.reference_every();
    if (every == 0) return sum_s;
    for (std::size_t place = std::max<std::size_t>(1, (change.first + every - 1) / every) * every;
         place <= change.end && place < order_.size(); place += every)
      sum_s += detour_s(place, after, time) - detour_s(place, before, time);
    return sum_s;
  }

  /// Makes the change if it saves time.
  bool attempt(const Change& change) {
    if (longer_s(change, &TourTimes::at_least) >= -kLeastGain_s) return false;
    if (longer_s(change, &TourTimes::between) >= -kLeastGain_s) return false;
    const auto at = [&](std::size_t place) { return order_.begin() + static_cast<std::ptrdiff_t>(place); };
    if (change.reverses()) {
      std::reverse(at(change.first), at(change.end));
    } else {
      std::rotate(at(change.first), at(change.middle), at(change.end));
    }
    note_places(change.first, change.end);
    if (times_.reference_every() > 0) {
      look_about(change.first, change.end);
    } else {
      look_about(change.first, change.first + 1);
      look_about(change.end - 1, change.end);
      const std::size_t seam = change.first + change.end - change.middle;
      if (!change.reverses()) look_about(seam - 1, seam);
    }
    return true;
  }

  double longer_by_swap_s(std::size_t i, std::size_t k, Time time) const {
    const auto before = [](std::size_t place) { return place; };
    const auto after = [=](std::size_t place) { return place == i ? k : place == k ? i : place; };
    double sum_s = 0;
    const auto add = [&](std::size_t place) {
      sum_s += motion_s(place, after, time) - motion_s(place, before, time);
      if (place > 0 && place < order_.size() && times_.visits(place))
        sum_s += detour_s(place, after, time) - detour_s(place, before, time);
    };
    add(i);
    add(i + 1);
    if (k > i + 1) add(k);
    add(k + 1);
    return sum_s;
  }

  bool swap(std::size_t i, std::size_t k) {
    if (longer_by_swap_s(i, k, &TourTimes::at_least) >= -kLeastGain_s) return false;
    if (longer_by_swap_s(i, k, &TourTimes::between) >= -kLeastGain_s) return false;
    std::swap(order_[i], order_[k]);
    place_[order_[i]] = i;
    place_[order_[k]] = k;
    look_about(i, i + 1);
    look_about(k, k + 1);
    return true;
  }

  /// Changes between two places may save time where one of them is about these.
  void look_about(std::size_t begin, std::size_t end) {
    const auto look_at = [this](std::size_t from, std::size_t to) {
      for (std::size_t place = from; place < std::min(to, order_.size()); ++place) to_look_at_[place] = true;
    };
    look_at(begin - std::min(begin, reach()), end + 1);
    for (std::size_t place = begin; place < end; ++place)
      for (const std::size_t neighbour : neighbours_[order_[place]])
        look_at(place_[neighbour], place_[neighbour] + 2);
  }

  void note_places(std::size_t first, std::size_t end) {
    for (std::size_t place = first; place < end; ++place) place_[order_[place]] = place;
  }

  const TourTimes& times_;
  const std::vector<std::vector<std::size_t>>& neighbours_;
  std::size_t first_;
  std::vector<std::size_t>& order_;
  std::vector<std::size_t> place_;  ///< of each pose
  std::vector<bool> to_look_at_;    ///< places, of which a change may begin at
};

/// Swaps two neighbouring runs: a change that no single step of the local search undoes.
/// @return the first of the places that changed, and that behind the last
std::pair<std::size_t, std::size_t> double_bridge(std::vector<std::size_t>& order, std::size_t first,
                                                  Random& random) {
  const bool leading = first > 0 && random.next() % order.size() < first;
  std::size_t begin = leading ? 0 : first;
  const std::size_t end = leading ? first : order.size();
  if (end - begin > kWidestKick) begin += random.next() % (end - begin - kWidestKick + 1);
  std::array<std::size_t, 3> cut;
  for (std::size_t& place : cut) place = begin + random.next() % (std::min(end - begin, kWidestKick) + 1);
  std::ranges::sort(cut);
  const auto at = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(cut[i]); };
  std::rotate(at(0), at(1), at(2));
  return {cut[0], cut[2]};
}

}  // namespace

double travel_time_s(const RobotModel& robot, const JointVector& from, const JointVector& to) {
  double longest = 0;
  for (int i = 0; i < robot.joint_count(); ++i) {
    longest =
        std::max(longest, joint_time_s(robot.joints[static_cast<std::size_t>(i)], std::abs(to[i] - from[i])));
  }
  return longest;
}

TourTimes::TourTimes(TravelTime time, const TravelTime& at_least, std::span<const JointVector> poses,
                     const TourOptions& options)
    : poses_{poses.begin(), poses.end()},
      time_{std::move(time)},
      every_{static_cast<std::size_t>(options.reference_every)},
      times_(poses.size() * poses.size()) {
  for (std::size_t a = 0; a < poses.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      times_[a * poses.size() + b] = times_[b * poses.size() + a] = {at_least(poses[a], poses[b]), false};
  const double to_reference = every_ > 0 ? time_(options.start, options.reference) : 0;
  for (const JointVector& q : poses) {
    count_step();
    from_reference_.push_back(every_ > 0 ? time_(options.reference, q) : 0);
    from_start_.push_back(every_ > 0 ? to_reference + from_reference_.back() : time_(options.start, q));
  }
}

double TourTimes::between(std::size_t a, std::size_t b) const {
  Known& known = times_[a * poses() + b];
  if (!known.exact) {
    count_step();
    known = times_[b * poses() + a] = {time_(poses_[std::max(a, b)], poses_[std::min(a, b)]), true};
  }
  return known.s;
}

double TourTimes::part(std::span<const std::size_t> order, std::size_t first, std::size_t end) const {
  double sum = 0;
  for (std::size_t place = first; place < end; ++place) sum += to(place, order);
  return sum;
}

double TourTimes::to(std::size_t place, std::span<const std::size_t> order) const {
  if (place == order.size()) return from_reference_[order.back()];
  if (place == 0) return from_start_[order[0]];
  const std::size_t a = order[place - 1], b = order[place];
  return visits(place) ? from_reference_[a] + from_reference_[b] : between(a, b);
}

Tour shortest_tour(const TourTimes& times, const TourOptions& options) {
  if (times.poses() == 0) return {};
  std::vector<std::size_t> best = nearest_neighbours(times, options.first, options.progress);
  const auto neighbours = neighbours_of_each(times);
  LocalSearch{times, neighbours, options.first, best}.run(0, best.size());
  double best_s = times.total(best);
  Random random{options.seed};
  std::vector<std::size_t> order;
  for (int kick = 0; kick < options.kicks; ++kick) {
    if (options.progress)
      options.progress(static_cast<double>(kick) / options.kicks, "search for the shortest order");
    order = best;
    const auto [begin, end] = double_bridge(order, options.first, random);
    LocalSearch{times, neighbours, options.first, order}.run(begin, end);
    const double time_s = times.total(order);
    if (time_s >= best_s - kLeastGain_s) continue;
    best.swap(order);
    best_s = time_s;
  }
  return {best, best_s};
}

}  // namespace truepose
