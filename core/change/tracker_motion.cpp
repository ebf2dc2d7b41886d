#include "core/change/tracker_motion.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/change/change_hypothesis.hpp"
#include "core/formatted.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/rigid_fit.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr int kFewestNests = 3;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d M;
  M << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return M;
}

Eigen::Isometry3d small_motion(const Vector6& motion, const Eigen::Vector3d& centre_mm) {
  const Eigen::Vector3d turn = motion.tail<3>();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  if (turn.norm() > 0) X.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  X.translation() = motion.head<3>() + centre_mm - X.linear() * centre_mm;
  return X;
}

/// The same nests, seen both times.
struct Pairs {
  std::vector<std::size_t> nest;
  std::vector<Eigen::Vector3d> then_mm, now_mm;
  std::vector<Eigen::Matrix3d> W;  ///< whitens their difference

  Eigen::Vector3d centre_mm() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : then_mm) sum += p;
    return sum / static_cast<double>(then_mm.size());
  }
};

Pairs pairs_of(const NestReadings& then, const NestReadings& now, const MeasurementNoise& noise) {
  assert(then.size() == now.size());
  Pairs pairs;
  for (std::size_t i = 0; i < then.size(); ++i) {
    if (then[i].readings == 0 || now[i].readings == 0) continue;
    const double means = 1.0 / then[i].readings + 1.0 / now[i].readings;
    pairs.nest.push_back(i);
    pairs.then_mm.push_back(then[i].p_mm);
    pairs.now_mm.push_back(now[i].p_mm);
    pairs.W.push_back(inverse_cholesky(means * reading_covariance(then[i].p_mm, noise)));
  }
  return pairs;
}

/// The motion that explains the pairs best by their noise, from a near one: linear there.
void fit(const Pairs& pairs, TrackerMotion& motion) {
  Matrix6 N = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  double still2 = 0;
  for (std::size_t i = 0; i < pairs.nest.size(); ++i) {
    const Eigen::Vector3d seen_mm = motion.X * pairs.now_mm[i];
    Matrix36 J;
    J << Eigen::Matrix3d::Identity(), -cross(seen_mm - motion.centre_mm);
    const Matrix36 whitened = pairs.W[i] * J;
    N += whitened.transpose() * whitened;
    b += whitened.transpose() * (pairs.W[i] * (pairs.then_mm[i] - seen_mm));
    still2 += (pairs.W[i] * (pairs.then_mm[i] - pairs.now_mm[i])).squaredNorm();
  }
  motion.covariance = inverse(N);
  motion.X = small_motion(motion.covariance * b, motion.centre_mm) * motion.X;
  const Eigen::AngleAxisd turn(motion.X.linear());
  motion.moved << motion.X * motion.centre_mm - motion.centre_mm, turn.angle() * turn.axis();
  motion.sigma = motion.covariance.diagonal().cwiseSqrt();

  double left2 = 0;
  for (std::size_t i = 0; i < pairs.nest.size(); ++i) {
    const Eigen::Vector3d left_mm = pairs.then_mm[i] - motion.X * pairs.now_mm[i];
    left2 += (pairs.W[i] * left_mm).squaredNorm();
    motion.left_mm[pairs.nest[i]] = left_mm.norm();
  }
  const Vector6 mrad = (Vector6() << 1, 1, 1, 1e-3, 1e-3, 1e-3).finished();  // a metre away as much as a mm
  const Matrix6 of_units = mrad.asDiagonal() * N * mrad.asDiagonal();
  motion.evidence =
      ChangeEvidence(of_units, of_units * motion.moved.cwiseQuotient(mrad)).best_of_fit(still2 - left2);
  motion.probability = chi_square_tail(still2 - left2, 6);
  motion.fit = chi_square_tail(left2, 3 * static_cast<int>(pairs.nest.size()) - 6);
}

/// Takes the check into the means of the stand.
void add_to(TrackerStand& stand, const NestReadings& check) {
  for (std::size_t i = 0; i < check.size(); ++i) {
    NestReading& mean = stand.nests[i];
    if (check[i].readings == 0) continue;
    const int all = mean.readings + check[i].readings;
    mean.p_mm = (mean.readings * mean.p_mm + check[i].readings * check[i].p_mm) / all;
    mean.readings = all;
  }
}

/// The nest without which the others agree best, where four or more were seen.
std::optional<std::size_t> loose_nest(const NestReadings& then, const NestReadings& now,
                                      const MeasurementNoise& noise) {
  std::optional<std::size_t> loose;
  double best = kSignificance;
  for (std::size_t i = 0; i < now.size(); ++i) {
    NestReadings without = now;
    without[i].readings = 0;
    if (now[i].readings == 0) continue;
    const auto motion = tracker_motion(then, without, noise);
    if (!motion || motion->fit <= best) continue;
    best = motion->fit;
    loose = i;
  }
  return loose;
}

class HistoryBuilder {
 public:
  HistoryBuilder(const TrackerNoiseModel& noise, std::size_t checks)
      : noise_{.tracker = noise},
        significance_{kSignificance / static_cast<double>(std::max<std::size_t>(checks, 1))} {}

  void add(std::size_t check, NestReadings nests) {
    if (std::ranges::count_if(nests, &NestReading::readings) < kFewestNests)
      return doubt(check, "fewer than three of them were seen");
    if (history_.stands.empty()) {
      history_.stands.push_back({check, check, std::move(nests), {}});
      return;
    }
    TrackerStand& stand = history_.stands.back();
    auto motion = tracker_motion(stand.nests, nests, noise_);
    if (motion && motion->fit < significance_) motion = without_loose(check, nests);
    if (!motion) {
      doubt(check, motion.error());
    } else if (motion->probability < significance_) {
      history_.stands.push_back({check, check, std::move(nests), {}});
    } else {
      stand.last = check;
      add_to(stand, nests);
    }
  }

  StandHistory finish() && {
    for (TrackerStand& stand : history_.stands) {
      if (&stand == &history_.stands.front()) continue;
      const auto motion = tracker_motion(history_.stands.front().nests, stand.nests, noise_);
      if (motion) stand.since_start = *motion;
      if (!motion) doubt(stand.first, motion.error());
    }
    return std::move(history_);
  }

 private:
  void doubt(std::size_t check, const std::string& why) {
    history_.doubts.push_back(formatted("measurement %zu of the nests: %s", check + 1, why.c_str()));
  }

  std::expected<TrackerMotion, std::string> without_loose(std::size_t check, NestReadings& nests) {
    const NestReadings& before = history_.stands.back().nests;
    const auto loose = loose_nest(before, nests, noise_);
    if (!loose)
      return std::unexpected("they have moved to each other, and which one moved is not identifiable");
    doubt(check,
          formatted("nest %zu moved by itself, see how it is fixed; the others were used", *loose + 1));
    nests[*loose].readings = 0;
    return tracker_motion(before, nests, noise_);
  }

  const MeasurementNoise noise_;
  const double significance_;
  StandHistory history_;
};

}  // namespace

std::expected<TrackerMotion, std::string> tracker_motion(const NestReadings& then, const NestReadings& now,
                                                         const MeasurementNoise& noise) {
  const Pairs pairs = pairs_of(then, now, noise);
  const auto rough = rigid_fit(pairs.now_mm, pairs.then_mm);
  if (!rough) return std::unexpected(rough.error());
  TrackerMotion motion;
  motion.X = *rough;
  motion.centre_mm = pairs.centre_mm();
  motion.left_mm.resize(then.size());
  fit(pairs, motion);
  return motion;
}

StandHistory stand_history(std::span<const NestReadings> checks, const TrackerNoiseModel& noise) {
  HistoryBuilder builder{noise, checks.size()};
  for (std::size_t check = 0; check < checks.size(); ++check) builder.add(check, checks[check]);
  return std::move(builder).finish();
}

Eigen::Isometry3d StandHistory::to_start(std::size_t check, double t) const {
  const auto after = std::ranges::find_if(stands, [check](const TrackerStand& s) { return s.last > check; });
  if (after == stands.end()) return stands.back().since_start.X;
  // Within a stand, or before the first check that tells anything.
  if (after->first <= check || after == stands.begin()) return after->since_start.X;
  const TrackerStand& before = *std::prev(after);
  const double from = static_cast<double>(before.last), to = static_cast<double>(after->first);
  const double share = std::clamp((static_cast<double>(check) + t - from) / (to - from), 0.0, 1.0);
  const Eigen::Isometry3d& A = before.since_start.X;
  const Eigen::Isometry3d& B = after->since_start.X;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Quaterniond{A.linear()}.slerp(share, Eigen::Quaterniond{B.linear()}).toRotationMatrix();
  X.translation() = (1 - share) * A.translation() + share * B.translation();
  return X;
}

bool StandHistory::stepped_after(std::size_t check) const {
  const auto after = std::ranges::find_if(stands, [check](const TrackerStand& s) { return s.last > check; });
  if (after == stands.end() || after == stands.begin() || after->first <= check) return false;
  const auto stays = [](const TrackerStand& stand) { return stand.first != stand.last; };
  return stands.size() == 2 || stays(*after) || stays(*std::prev(after));
}

std::vector<std::string> described_moves(const StandHistory& history) {
  std::vector<std::string> moves;
  for (std::size_t i = 1; i < history.stands.size(); ++i) {
    const TrackerStand& before = history.stands[i - 1];
    const TrackerStand& after = history.stands[i];
    const TrackerMotion& motion = after.since_start;
    const Eigen::Matrix3d of_shift = motion.covariance.topLeftCorner<3, 3>();
    const Eigen::Matrix3d of_turn = motion.covariance.bottomRightCorner<3, 3>();
    moves.push_back(formatted(
        "between measurements %zu and %zu of the nests the tracker moved: it stands %.3f mm (sigma %.3f) and %.0f "
        "urad (sigma %.0f) from where it stood at first",
        before.last + 1, after.first + 1, motion.shift_mm().norm(), std::sqrt(of_shift.trace() / 3),
        1e6 * motion.turn_rad().norm(), 1e6 * std::sqrt(of_turn.trace() / 3)));
  }
  return moves;
}

}  // namespace truepose
