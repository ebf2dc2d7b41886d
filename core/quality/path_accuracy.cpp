#include "core/quality/path_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace truepose {
namespace {

constexpr double kStands_mm = 1e-3;  // what is nearer is the same place
constexpr std::size_t kWindow = 25;  // samples: half a second of motion at 20 ms each
// A chord cuts a curve's corner by more than a corrected arm's error (0.05 mm of a radius of 100 mm at 0.3
// m/s), so the path is drawn through the samples as a spline, in so many steps from one to the next.
constexpr std::size_t kSteps = 16;

using Points = std::vector<Eigen::Vector3d>;

bool is_same_place(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - b).norm() <= kStands_mm;
}

/// Source: Catmull, Rom, A class of local interpolating splines (1974).
Eigen::Vector3d catmull_rom(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                            const Eigen::Vector3d& d, double t) {
  return b + t / 2 * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

/// kSteps from each vertex to the next; straight on at both ends.
Points spline_through(const Points& vertices) {
  const std::size_t last = vertices.size() - 1;
  Points curve;
  for (std::size_t i = 0; i < last; ++i) {
    const Eigen::Vector3d &b = vertices[i], &c = vertices[i + 1];
    const Eigen::Vector3d a = i > 0 ? vertices[i - 1] : 2 * b - c;
    const Eigen::Vector3d d = i + 1 < last ? vertices[i + 2] : 2 * c - b;
    for (std::size_t k = 0; k < kSteps; ++k)
      curve.push_back(catmull_rom(a, b, c, d, static_cast<double>(k) / kSteps));
  }
  curve.push_back(vertices[last]);
  return curve;
}

Eigen::Vector3d nearest_of_segment(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                   const Eigen::Vector3d& p) {
  const Eigen::Vector3d along = to - from;
  const double square = along.squaredNorm();
  return square > 0 ? from + std::clamp(along.dot(p - from) / square, 0.0, 1.0) * along : from;
}

/// The wanted path, or that with the drives' lag applied, in pieces where time is missing.
class WantedPath {
 public:
  /// @param place  of a sample
  WantedPath(std::span<const PathSample> samples, const auto& place) {
    const PathSample* before = nullptr;
    for (const PathSample& sample : samples) {
      if (!sample.at_point) {
        if (before == nullptr || !goes_on(*before, sample)) pieces_.emplace_back();
        add(pieces_.back(), place(sample));
        before = &sample;
      }
      places_.push_back(
          {std::max<std::size_t>(pieces_.size(), 1) - 1, pieces_.empty() ? 0 : pieces_.back().size() - 1});
    }
    for (const Points& piece : pieces_) curves_.push_back(spline_through(piece));
  }

  /// @param sample  of the path, about which to look
  Eigen::Vector3d nearest(std::size_t sample, const Eigen::Vector3d& p) const {
    const auto [piece, vertex] = places_[sample];
    const Points& curve = curves_[piece];
    const std::size_t end = std::min((vertex + kWindow) * kSteps, curve.size() - 1);
    Eigen::Vector3d nearest = curve[end];
    for (std::size_t i = (vertex - std::min(vertex, kWindow)) * kSteps; i < end; ++i) {
      const Eigen::Vector3d candidate = nearest_of_segment(curve[i], curve[i + 1], p);
      if ((candidate - p).squaredNorm() < (nearest - p).squaredNorm()) nearest = candidate;
    }
    return nearest;
  }

 private:
  struct Place {
    std::size_t piece, vertex;
  };

  /// Where the arm stands, there is one vertex, so that the window is of motion.
  static void add(Points& piece, const Eigen::Vector3d& p) {
    if (piece.empty() || !is_same_place(p, piece.back())) piece.push_back(p);
  }

  std::vector<Points> pieces_, curves_;
  std::vector<Place> places_;  // of each sample
};

ErrorLengths lengths_of(std::vector<double> errors) {
  std::ranges::sort(errors);
  const auto n = static_cast<double>(errors.size());
  ErrorLengths lengths{.p95 = errors[static_cast<std::size_t>(std::ceil(0.95 * n)) - 1],
                       .max = errors.back()};
  for (const double error : errors) lengths.mean += error / n;
  return lengths;
}

/// Of the samples along the path that are judged; empty where none is, or the lag is not known.
std::optional<ErrorLengths> lagged_lengths(std::span<const PathSample> samples,
                                           std::span<const SampleErrors> errors) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].at_point && samples[i].corrected() && errors[i].with_lagged)
      lengths.push_back(errors[i].with_lagged->error_mm.norm());
  }
  return lengths.empty() ? std::nullopt : std::optional{lengths_of(std::move(lengths))};
}

std::optional<ErrorComparison> compare(std::span<const PathSample> samples,
                                       std::span<const SampleErrors> errors, bool at_points) {
  std::vector<double> with, without;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].at_point != at_points || !samples[i].corrected()) continue;
    with.push_back(errors[i].with.error_mm.norm());
    without.push_back(errors[i].without.error_mm.norm());
  }
  if (with.empty()) return std::nullopt;
  const int count = static_cast<int>(with.size());
  return ErrorComparison{count, lengths_of(std::move(with)), lengths_of(std::move(without))};
}

}  // namespace

bool goes_on(const PathSample& from, const PathSample& to) { return goes_on(from.time_s, to.time_s); }

std::vector<SampleErrors> sample_errors(std::span<const PathSample> samples) {
  const WantedPath path{samples, [](const PathSample& sample) { return sample.wanted_mm; }};
  const bool lag_known =
      std::ranges::all_of(samples, [](const auto& sample) { return sample.lagged_mm.has_value(); });
  const auto lagged =
      lag_known ? std::optional{WantedPath{samples, [](const auto& sample) { return *sample.lagged_mm; }}}
                : std::nullopt;
  std::vector<SampleErrors> errors;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const PathSample& sample = samples[i];
    const auto error_of = [&](const Eigen::Vector3d& p) {
      const Eigen::Vector3d place = sample.at_point ? sample.wanted_mm : path.nearest(i, p);
      return PathError{place, p - place};
    };
    errors.push_back({error_of(sample.with_mm), error_of(sample.without_mm)});
    if (!lagged || sample.at_point) continue;
    const Eigen::Vector3d place = lagged->nearest(i, sample.with_mm);
    errors.back().with_lagged = PathError{place, sample.with_mm - place};
  }
  return errors;
}

std::vector<PathSample> partly_corrected_points(std::span<const PathSample> samples) {
  std::vector<PathSample> points;
  for (auto point = samples.begin(); point != samples.end(); ++point) {
    if (!point->at_point) continue;
    const auto left_or_corrected = std::find_if(point, samples.end(), [point](const PathSample& sample) {
      return sample.corrected() || !is_same_place(sample.wanted_mm, point->wanted_mm);
    });
    const bool corrected =
        left_or_corrected != samples.end() && is_same_place(left_or_corrected->wanted_mm, point->wanted_mm);
    if (!corrected) points.push_back(*point);
  }
  return points;
}

bool PathAccuracy::refuted() const {
  if (points) return !points->improved();
  return path && !improves(path->without.mean, path_with().mean);
}

PathAccuracy path_accuracy(std::span<const PathSample> samples) {
  const std::vector<SampleErrors> errors = sample_errors(samples);
  return {compare(samples, errors, true), static_cast<int>(partly_corrected_points(samples).size()),
          compare(samples, errors, false), lagged_lengths(samples, errors)};
}

}  // namespace truepose
