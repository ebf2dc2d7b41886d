#include "core/quality/drive_lag.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/math/angles.hpp"

namespace truepose {
namespace {

constexpr double kGap_s = 0.2;  // longer than any distance of samples
constexpr double kLeastMotion_rad = 0.5 * kRadPerDeg;
constexpr double kLongestDelay_s = 0.5;
constexpr int kStepsOfSample = 8;

/// What an axis is given over the time of one piece: through the samples as a cubic, since a chord of 20 ms
/// cuts more off a curve than a corrected arm errs.
struct AxisInput {
  std::vector<double> time_s, given;

  double secant(std::size_t from, std::size_t to) const {
    return time_s[to] > time_s[from] ? (given[to] - given[from]) / (time_s[to] - time_s[from]) : 0;
  }

  /// At both ends that of a parabola.
  double slope(std::size_t i) const {
    const std::size_t last = given.size() - 1;
    if (last < 2) return secant(0, last);
    if (i == 0) return 2 * secant(0, 1) - secant(0, 2);
    if (i == last) return 2 * secant(last - 1, last) - secant(last - 2, last);
    return secant(i - 1, i + 1);
  }

  /// @param near  sample at or before which the search begins; moved to the one before `t`
  double at(double t, std::size_t& near) const {
    if (t <= time_s.front()) return given.front();
    while (near + 1 < time_s.size() && time_s[near + 1] < t) ++near;
    if (near + 1 == time_s.size()) return given.back();
    const double h = time_s[near + 1] - time_s[near], u = (t - time_s[near]) / h, v = 1 - u;
    return v * v * (1 + 2 * u) * given[near] + u * u * (3 - 2 * u) * given[near + 1] +
           u * v * h * (v * slope(near) - u * slope(near + 1));
  }
};

/// The input with the lag applied, at its samples.
///
/// @param start  where the axis is at the first one
std::vector<double> response(const AxisInput& input, const AxisLag& lag, double start) {
  std::vector<double> axis{start};
  std::size_t near = 0;
  double from = input.at(input.time_s.front() - lag.dead_time_s, near);
  for (std::size_t i = 1; i < input.time_s.size(); ++i) {
    const double h = (input.time_s[i] - input.time_s[i - 1]) / kStepsOfSample;
    double y = axis.back();
    for (int k = 1; k <= kStepsOfSample; ++k) {
      const double to = input.at(input.time_s[i - 1] + k * h - lag.dead_time_s, near);
      // Exact for an input that goes straight from one to the other: it is followed by slope * tau behind.
      if (h > 0) {
        const double behind = (to - from) / h * lag.time_constant_s;
        const double left = lag.time_constant_s > 0 ? std::exp(-h / lag.time_constant_s) : 0;
        y = to - behind + (y - from + behind) * left;
      }
      from = to;
    }
    axis.push_back(y);
  }
  return axis;
}

using Piece = std::span<const AxisSample>;

std::vector<Piece> pieces_of(std::span<const AxisSample> samples) {
  std::vector<Piece> pieces;
  for (std::size_t begin = 0, i = 1; i <= samples.size(); ++i) {
    if (i < samples.size() && goes_on(samples[i - 1].time_s, samples[i].time_s)) continue;
    pieces.push_back(samples.subspan(begin, i - begin));
    begin = i;
  }
  return pieces;
}

AxisInput input_of(Piece piece, const auto& given) {
  AxisInput input;
  for (const AxisSample& sample : piece) {
    input.time_s.push_back(sample.time_s);
    input.given.push_back(given(sample));
  }
  return input;
}

/// One axis with what it was given and where it was.
class AxisFit {
 public:
  AxisFit(const std::vector<Piece>& pieces, Eigen::Index axis) {
    for (const Piece& piece : pieces) {
      inputs_.push_back(
          input_of(piece, [axis](const AxisSample& s) { return s.set[axis] + s.correction[axis]; }));
      auto& actual = actual_.emplace_back();
      for (const AxisSample& sample : piece) actual.push_back(sample.actual[axis]);
    }
  }

  bool moves() const {
    return std::ranges::any_of(inputs_, [](const AxisInput& input) {
      const auto [lo, hi] = std::ranges::minmax(input.given);
      return hi - lo >= kLeastMotion_rad;
    });
  }

  double square(const AxisLag& lag) const {
    double sum = 0;
    for (std::size_t k = 0; k < inputs_.size(); ++k) {
      const std::vector<double> axis = response(inputs_[k], lag, actual_[k].front());
      for (std::size_t i = 0; i < axis.size(); ++i) sum += std::pow(axis[i] - actual_[k][i], 2);
    }
    return sum;
  }

 private:
  std::vector<AxisInput> inputs_;
  std::vector<std::vector<double>> actual_;
};

/// Compass search over the delay and the time constant's share of it: slow motions show the delay alone, so
/// that the valley of the squares lies along the share.
/// Source: Kolda, Lewis, Torczon, Optimization by direct search (SIAM Review 45, 2003), section 1.1.
std::pair<AxisLag, double> best_lag(const AxisFit& axis) {
  using Point = std::array<double, 2>;
  constexpr Point kUpper{kLongestDelay_s, 1};
  constexpr double kFinest = 1e-4;
  const auto lag_of = [](const Point& p) { return AxisLag{p[0] * (1 - p[1]), p[0] * p[1], true}; };
  Point best{0.05, 0.5};
  double least = axis.square(lag_of(best));
  for (Point step{0.032, 0.25}; step[0] > kFinest;) {
    bool better = false;
    for (std::size_t k = 0; k < best.size() && !better; ++k) {
      for (const double sign : {1.0, -1.0}) {
        Point tried = best;
        tried[k] = std::clamp(tried[k] + sign * step[k], 0.0, kUpper[k]);
        const double square =
            tried == best ? std::numeric_limits<double>::infinity() : axis.square(lag_of(tried));
        if (square >= least) continue;
        least = square;
        best = tried;
        better = true;
        break;
      }
    }
    if (!better)
      for (double& s : step) s /= 2;
  }
  return {lag_of(best), least};
}

}  // namespace

bool goes_on(double from_s, double to_s) { return to_s - from_s <= kGap_s; }

double DriveLag::mean_delay_s() const {
  double sum = 0;
  int count = 0;
  for (const AxisLag& axis : axes) {
    if (!axis.identified) continue;
    sum += axis.delay_s();
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

DriveLag identify_drive_lag(std::span<const AxisSample> samples) {
  DriveLag lag;
  if (samples.empty()) return lag;
  const std::vector<Piece> pieces = pieces_of(samples);
  double square = 0;
  AxisLag mean;
  int identified = 0;
  for (Eigen::Index i = 0; i < samples.front().set.size(); ++i) {
    lag.axes.emplace_back();
    const AxisFit axis{pieces, i};
    if (!axis.moves()) continue;
    const auto [found, its_square] = best_lag(axis);
    lag.axes.back() = found;
    square += its_square;
    mean.dead_time_s += found.dead_time_s;
    mean.time_constant_s += found.time_constant_s;
    ++identified;
  }
  if (identified == 0) return lag;
  mean.dead_time_s /= identified;
  mean.time_constant_s /= identified;
  for (AxisLag& axis : lag.axes) {
    if (!axis.identified) axis = mean;
  }
  lag.residual_rad = std::sqrt(square / (identified * static_cast<double>(samples.size())));
  return lag;
}

std::vector<JointVector> lagged_set_points(std::span<const AxisSample> samples, const DriveLag& lag) {
  std::vector<JointVector> lagged;
  for (const AxisSample& sample : samples) lagged.push_back(sample.set);
  std::size_t first = 0;
  for (const Piece& piece : samples.empty() ? std::vector<Piece>{} : pieces_of(samples)) {
    for (std::size_t k = 0; k < lag.axes.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const AxisSample& start = piece.front();
      const std::vector<double> axis =
          response(input_of(piece, [i](const AxisSample& s) { return s.set[i]; }), lag.axes[k],
                   start.actual[i] - start.correction[i]);
      for (std::size_t n = 0; n < axis.size(); ++n) lagged[first + n][i] = axis[n];
    }
    first += piece.size();
  }
  return lagged;
}

}  // namespace truepose
