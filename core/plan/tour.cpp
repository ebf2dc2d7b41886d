#include "core/plan/tour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/math/random.hpp"
#include "core/step_count.hpp"

namespace truepose {
namespace {

// Below this a change is rounding, and would be made for ever.
constexpr double kLeastGain_s = 1e-9;
constexpr std::size_t kLongestMovedRun = 3;

double joint_time_s(const Joint& joint, double distance) {
  if (joint.acceleration <= 0) return distance / joint.speed;
  const double ramp_s = joint.speed / joint.acceleration;
  if (distance <= joint.speed * ramp_s) return 2 * std::sqrt(distance / joint.acceleration);
  return distance / joint.speed + ramp_s;
}

std::vector<std::size_t> nearest_neighbours(const TourTimes& times, std::size_t first) {
  std::vector<std::size_t> order(times.poses());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (auto next = order.begin(); next != order.end(); ++next) {
    const auto time = [&](std::size_t k) {
      return next == order.begin() ? times.from_start(k) : times.between(*(next - 1), k);
    };
    const auto begun = static_cast<std::size_t>(next - order.begin());
    const auto end = begun < first ? order.begin() + static_cast<std::ptrdiff_t>(first) : order.end();
    std::iter_swap(
        next, std::min_element(next, end, [&](std::size_t a, std::size_t b) { return time(a) < time(b); }));
  }
  return order;
}

/// Tries changes of an order, each between two places, and keeps those that save time.
class LocalSearch {
 public:
  /// @param first  places that only change among themselves
  LocalSearch(const TourTimes& times, std::size_t first, std::vector<std::size_t>& order)
      : times_{times}, first_{first}, order_{order} {}

  void run() {
    while (improve_once()) {
    }
  }

 private:
  using Place = std::vector<std::size_t>::iterator;

  bool improve_once() {
    bool improved = false;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      count_step();
      for (std::size_t j = i + 2; j <= (i < first_ ? first_ : order_.size()); ++j) {
        if (within_reach(i, j)) improved |= reverse_and_move(i, j);
        improved |= swap(i, j - 1);
      }
    }
    return improved;
  }

  /// Visits to the reference part the order into runs that hardly feel each other.
  bool within_reach(std::size_t i, std::size_t j) const {
    return !visits() || j - i <= 2 * times_.reference_every();
  }

  bool reverse_and_move(std::size_t i, std::size_t j) {
    bool improved = false;
    if (visits() || enter(i, j - 1) + leave(i, j) < enter(i, i) + leave(j - 1, j) - kLeastGain_s) {
      improved |= attempt(i, j, [](Place first, Place end) { std::reverse(first, end); });
    }
    for (std::size_t run = 1; run <= kLongestMovedRun && run < j - i; ++run) {
      improved |= rotate(i, i + run, j);
      if (run < j - i - run) improved |= rotate(i, j - run, j);
    }
    return improved;
  }

  bool rotate(std::size_t i, std::size_t middle, std::size_t j) {
    const auto seams_before = [&] { return enter(i, i) + step(middle - 1, middle) + leave(j - 1, j); };
    if (!visits() &&
        enter(i, middle) + step(j - 1, i) + leave(middle - 1, j) >= seams_before() - kLeastGain_s) {
      return false;
    }
    return attempt(i, j, [&](Place first, Place end) {
      std::rotate(first, first + static_cast<std::ptrdiff_t>(middle - i), end);
    });
  }

  bool swap(std::size_t i, std::size_t k) {
    const auto time = [&] {
      return k == i + 1 ? times_.part(order_, i, k + 2)
                        : times_.part(order_, i, i + 2) + times_.part(order_, k, k + 2);
    };
    const double before = time();
    std::swap(order_[i], order_[k]);
    if (time() < before - kLeastGain_s) return true;
    std::swap(order_[i], order_[k]);
    return false;
  }

  // Times of single steps where there are no visits, by the places at which the poses stand now.
  bool visits() const { return times_.reference_every() > 0; }
  double step(std::size_t a, std::size_t b) const { return times_.between(order_[a], order_[b]); }
  double enter(std::size_t i, std::size_t a) const {
    return i == 0 ? times_.from_start(order_[a]) : step(i - 1, a);
  }
  double leave(std::size_t a, std::size_t j) const { return j == order_.size() ? 0 : step(a, j); }

  /// Changes places i .. j - 1 and keeps the change if it saves time.
  template <typename Change>
  bool attempt(std::size_t i, std::size_t j, Change change) {
    const Place first = order_.begin() + static_cast<std::ptrdiff_t>(i);
    const Place end = order_.begin() + static_cast<std::ptrdiff_t>(j);
    const double before = times_.part(order_, i, j + 1);
    kept_.assign(first, end);
    change(first, end);
    if (times_.part(order_, i, j + 1) < before - kLeastGain_s) return true;
    std::ranges::copy(kept_, first);
    return false;
  }

  const TourTimes& times_;
  std::size_t first_;
  std::vector<std::size_t>& order_;
  std::vector<std::size_t> kept_;
};

/// Swaps two neighbouring runs: a change that no single step of the local search undoes.
void double_bridge(std::vector<std::size_t>& order, std::size_t first, Random& random) {
  const bool leading = first > 0 && random.next() % order.size() < first;
  const std::size_t begin = leading ? 0 : first, end = leading ? first : order.size();
  std::array<std::size_t, 3> cut;
  for (std::size_t& place : cut) place = begin + random.next() % (end - begin + 1);
  std::ranges::sort(cut);
  const auto at = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(cut[i]); };
  std::rotate(at(0), at(1), at(2));
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

TourTimes::TourTimes(const TravelTime& time, std::span<const JointVector> poses, const TourOptions& options)
    : poses_{poses.size()},
      every_{static_cast<std::size_t>(options.reference_every)},
      between_(poses.size() * poses.size()) {
  for (std::size_t a = 0; a < poses_; ++a) {
    count_step();
    if (options.progress)
      options.progress(static_cast<double>(a * a) / static_cast<double>(poses_ * poses_),
                       "motions between the poses");
    for (std::size_t b = 0; b < a; ++b)
      between_[a * poses_ + b] = between_[b * poses_ + a] = time(poses[a], poses[b]);
  }
  const double to_reference = every_ > 0 ? time(options.start, options.reference) : 0;
  for (const JointVector& q : poses) {
    from_reference_.push_back(every_ > 0 ? time(options.reference, q) : 0);
    from_start_.push_back(every_ > 0 ? to_reference + from_reference_.back() : time(options.start, q));
  }
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
  const bool visits = every_ > 0 && place % every_ == 0;
  return visits ? from_reference_[a] + from_reference_[b] : between(a, b);
}

Tour shortest_tour(const TourTimes& times, const TourOptions& options) {
  if (times.poses() == 0) return {};
  std::vector<std::size_t> best = nearest_neighbours(times, options.first);
  LocalSearch{times, options.first, best}.run();
  double best_s = times.total(best);
  Random random{options.seed};
  std::vector<std::size_t> order;
  for (int kick = 0; kick < options.kicks; ++kick) {
    if (options.progress)
      options.progress(static_cast<double>(kick) / options.kicks, "search for the shortest order");
    order = best;
    double_bridge(order, options.first, random);
    LocalSearch{times, options.first, order}.run();
    const double time_s = times.total(order);
    if (time_s >= best_s - kLeastGain_s) continue;
    best.swap(order);
    best_s = time_s;
  }
  return {best, best_s};
}

}  // namespace truepose
