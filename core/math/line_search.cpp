#include "core/math/line_search.hpp"

#include <algorithm>
#include <cmath>

namespace truepose {
namespace {

struct Trial {
  double step;
  LinePoint at;
};

class Search {
 public:
  Search(const std::function<LinePoint(double)>& line, const LinePoint& start,
         const LineSearchOptions& options)
      : line_{line}, start_{start}, options_{options} {}

  /// Widens the step until a minimum is enclosed (algorithm 3.5).
  std::optional<double> run() {
    Trial last{0, start_};
    for (double step = 1; evaluations_ < options_.max_evaluations; step *= 2) {
      const Trial trial = evaluate(step);
      if (!sufficient_decrease(trial) || (last.step > 0 && trial.at.value >= last.at.value))
        return zoom(last, trial);
      if (flat_enough(trial)) return step;
      if (trial.at.slope >= 0) return zoom(trial, last);
      last = trial;
    }
    return std::nullopt;
  }

 private:
  Trial evaluate(double step) {
    ++evaluations_;
    return {step, line_(step)};
  }
  // Written so that a NaN fails both.
  bool sufficient_decrease(const Trial& t) const {
    return t.at.value <= start_.value + options_.c1 * t.step * start_.slope;
  }
  bool flat_enough(const Trial& t) const {
    return std::abs(t.at.slope) <= options_.c2 * std::abs(start_.slope);
  }

  /// Shrinks an interval that holds a good step; `low` is its best end so far (algorithm 3.6).
  std::optional<double> zoom(Trial low, Trial high) {
    while (evaluations_ < options_.max_evaluations) {
      const Trial trial = evaluate(inside(low, high));
      if (!sufficient_decrease(trial) || trial.at.value >= low.at.value) {
        high = trial;
        continue;
      }
      if (flat_enough(trial)) return trial.step;
      if (trial.at.slope * (high.step - low.step) >= 0) high = low;
      low = trial;
    }
    return std::nullopt;
  }

  /// Minimum of the parabola through low's value and slope and high's value, kept off the ends of the
  /// interval.
  static double inside(const Trial& low, const Trial& high) {
    const double width = high.step - low.step;
    const double curvature = high.at.value - low.at.value - low.at.slope * width;
    double fraction = -low.at.slope * width / (2 * curvature);
    if (!std::isfinite(fraction)) fraction = 0.5;
    return low.step + std::clamp(fraction, 0.1, 0.9) * width;
  }

  const std::function<LinePoint(double)>& line_;
  LinePoint start_;
  LineSearchOptions options_;
  int evaluations_ = 0;
};

}  // namespace

std::optional<double> strong_wolfe_step(const std::function<LinePoint(double)>& line, const LinePoint& start,
                                        const LineSearchOptions& options) {
  if (!(start.slope < 0)) return std::nullopt;
  return Search{line, start, options}.run();
}

}  // namespace truepose
