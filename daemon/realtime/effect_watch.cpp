#include "daemon/realtime/effect_watch.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace truepose::daemon {

namespace {

// Standard deviations of the weights of a lag of which nothing is known: any fits, and what is left of it
// after a quarter of a second is a small part.
constexpr double kCommandedSigma = 1, kActualSigma = 0.3;
// Of the change in a quarter of a second: a share of each weight, and of any weight.
constexpr double kRelativeChange = 0.01, kAnyChange = 0.0003;

constexpr double kBlock_ms = 250;
// What the arm does beyond any lag: resolution, friction, the last decimal; and a share of what it trails,
// since a lag is not quite the same in every pose and at every speed.
constexpr double kNoiseRad = 0.002 * kRadPerDeg;
constexpr double kOfTrailing = 0.01;
// What a lag does not explain continues for some cycles, in which neighbours say the same: so many count as
// one.
constexpr double kCorrelated = 12;
// 1 / variance of m: none or all of the correction arrives.
constexpr double kGoesWithCorrection = 1;
// What is left of a lag after the longest delay is at most this.
constexpr double kGreatestRest = 0.8;
// So many cycles on, the axes between are near enough on a line: at 4000 deg/s^2 within 0.07 deg, in few
// rows.
constexpr std::uint64_t kBridged = 3;

template <std::size_t n>
std::array<int, n> in_cycles(const std::array<double, n>& delays_ms, double cycle_ms, std::size_t capacity) {
  std::array<int, n> cycles;
  std::ranges::transform(delays_ms, cycles.begin(), [&](double delay_ms) {
    return std::clamp(static_cast<int>(std::lround(delay_ms / cycle_ms)), 1, static_cast<int>(capacity) - 1);
  });
  return cycles;
}

/// Column by column: for many right-hand sides at once Eigen brings its blocked products for large matrices,
/// of which a program keeps one copy, compiled as any of its files asks for.
template <typename Matrix>
Matrix inverse(const Eigen::LDLT<Matrix>& factors) noexcept {
  Matrix columns;
  for (int j = 0; j < columns.cols(); ++j) columns.col(j) = factors.solve(Matrix::Identity().col(j));
  return columns;
}

}  // namespace

LagKnowledge::LagKnowledge() {
  covariance_.diagonal().head<kCommanded>().setConstant(kCommandedSigma * kCommandedSigma);
  covariance_.diagonal().tail<kActual>().setConstant(kActualSigma * kActualSigma);
}

void LagKnowledge::fade(int quarters) noexcept {
  const Weights change =
      kRelativeChange * kRelativeChange * weights_.cwiseAbs2() + Weights::Constant(kAnyChange * kAnyChange);
  covariance_.diagonal() += quarters * change;
}

void LagKnowledge::learn(const Matrix& added, const Weights& right) noexcept {
  const Matrix before = information();
  const Eigen::LDLT<Matrix> sum{before + added};
  weights_ = sum.solve(before * weights_ + right);
  covariance_ = inverse(sum);
}

LagKnowledge::Matrix LagKnowledge::information() const noexcept {
  return inverse(Eigen::LDLT<Matrix>{covariance_});
}

EffectWatch::EffectWatch(double cycle_ms)
    : commanded_delays_{in_cycles(LagKnowledge::kCommandedDelays_ms, cycle_ms, kCapacity)},
      actual_delays_{in_cycles(LagKnowledge::kActualDelays_ms, cycle_ms, kCapacity)},
      block_cycles_{std::max(kAxes, static_cast<int>(std::lround(kBlock_ms / cycle_ms)))} {}

void EffectWatch::restart() noexcept {
  taken_ = 0;
  block_ = 0;
  blocks_[block_] = {};
  full_blocks_ = 0;
  next_axis_ = kAxes;
}

void EffectWatch::forget() noexcept {
  restart();
  lags_.fill({});
}

void EffectWatch::Sums::add(const Unknowns& row, double difference) noexcept {
  normal.noalias() += row * row.transpose();
  right.noalias() += difference * row;
  squares += difference * difference;
}

void EffectWatch::Sums::add(const Sums& sums, double weight) noexcept {
  normal += weight * sums.normal;
  right += weight * sums.right;
  squares += weight * sums.squares;
}

void EffectWatch::remember(const Axes& now, std::uint64_t elapsed) noexcept {
  if (elapsed > static_cast<std::uint64_t>(kBlocks * block_cycles_)) restart();
  if (elapsed > kBridged) taken_ = 0;
  const auto append = [this](const Axes& axes) { axes_[taken_++ % kCapacity] = axes; };
  if (taken_ > 0) {
    const Axes last = ago(0);
    for (std::uint64_t lost = 1; lost < elapsed; ++lost) {
      const double share = static_cast<double>(lost) / static_cast<double>(elapsed);
      append({last.expected + share * (now.expected - last.expected),
              last.actual + share * (now.actual - last.actual)});
    }
  }
  append(now);
}

bool EffectWatch::take(const JointVector& commanded, const JointVector& correction, const JointVector& actual,
                       std::uint64_t elapsed) noexcept {
  const Axes now{commanded + correction, actual};
  remember(now, elapsed);
  if (taken_ <= static_cast<std::uint64_t>(commanded_delays_.back())) return false;

  Block& block = blocks_[block_];
  for (int axis = 0; axis < kAxes; ++axis) {
    Unknowns row;
    Eigen::Index i = 0;
    for (const int delay : commanded_delays_) row[i++] = ago(delay).expected[axis] - now.expected[axis];
    for (const int delay : actual_delays_) row[i++] = ago(delay).actual[axis] - now.expected[axis];
    row.tail<2>() << 1, correction[axis];
    block.axes[static_cast<std::size_t>(axis)].add(row, now.actual[axis] - now.expected[axis]);
  }
  block.sent += correction;
  if (++block.cycles == block_cycles_) {
    block_ = (block_ + 1) % blocks_.size();
    blocks_[block_] = {};
    full_blocks_ = std::min(full_blocks_ + 1, kBlocks);
    if (full_blocks_ == kBlocks) next_axis_ = 0;
  }
  return judge_next_axis();
}

/// @return whether it was the last one
bool EffectWatch::judge_next_axis() noexcept {
  if (next_axis_ == kAxes) return false;
  judge(next_axis_);
  learn_lag(next_axis_);
  return ++next_axis_ == kAxes;
}

/// 1 / variance of the measurements of a block.
double EffectWatch::weight(const Sums& block) const noexcept {
  const double trailing = block.squares / block_cycles_;
  return 1 / (kCorrelated * (kNoiseRad * kNoiseRad + kOfTrailing * kOfTrailing * trailing));
}

void EffectWatch::judge(int axis) noexcept {
  Sums sums;
  sent_[axis] = 0;
  for (int age = 1; age <= kBlocks; ++age) {
    const Block& block = full_block(age);
    const Sums& part = block.axes[static_cast<std::size_t>(axis)];
    sums.add(part, weight(part));
    sent_[axis] += block.sent[axis] / (kBlocks * block_cycles_);
  }
  LagKnowledge lag = lags_[static_cast<std::size_t>(axis)];
  lag.fade(kBlocks);
  Normal known = Normal::Zero();
  known.topLeftCorner<kWeights, kWeights>() = lag.information();
  known(kUnknowns - 1, kUnknowns - 1) = kGoesWithCorrection;
  Unknowns known_right = Unknowns::Zero();
  known_right.head<kWeights>() = known.topLeftCorner<kWeights, kWeights>() * lag.weights();

  // Twice: with the variance that is expected, then with the one that was found.
  double misfit = 1;
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::LDLT<Normal> factors{known + sums.normal / misfit};
    const Unknowns best = factors.solve(known_right + sums.right / misfit);
    const double rest = best.segment<LagKnowledge::kActual>(LagKnowledge::kCommanded).sum();
    const double share = 1 - std::min(rest, kGreatestRest);
    missing_[axis] = (best[kWeights] + best[kWeights + 1] * sent_[axis]) / share;
    Unknowns gradient = Unknowns::Zero();
    gradient.segment<LagKnowledge::kActual>(LagKnowledge::kCommanded).setConstant(missing_[axis] / share);
    gradient.tail<2>() << 1 / share, sent_[axis] / share;
    sigma_[axis] = std::sqrt(std::max(0.0, gradient.dot(factors.solve(gradient))));
    const double left = sums.squares - 2 * best.dot(sums.right) + best.dot(sums.normal * best);
    misfit = std::max(1.0, left * kCorrelated / (kBlocks * block_cycles_));
  }
  misfit_[axis] = misfit;
}

/// From the block that leaves the window next: of the lag alone, whatever was missing in it.
void EffectWatch::learn_lag(int axis) noexcept {
  const Sums& part = full_block(kBlocks).axes[static_cast<std::size_t>(axis)];
  Sums sums;
  sums.add(part, weight(part) / misfit_[axis]);
  Eigen::Matrix2d missing = sums.normal.bottomRightCorner<2, 2>();
  missing(1, 1) += kGoesWithCorrection;
  const Eigen::Matrix<double, kWeights, 2> shared = sums.normal.topRightCorner<kWeights, 2>();
  const Eigen::Matrix<double, kWeights, 2> share = shared * missing.inverse();
  LagKnowledge& lag = lags_[static_cast<std::size_t>(axis)];
  lag.fade(1);
  lag.learn(sums.normal.topLeftCorner<kWeights, kWeights>() - share.lazyProduct(shared.transpose()),
            sums.right.head<kWeights>() - share * sums.right.tail<2>());
}

}  // namespace truepose::daemon
