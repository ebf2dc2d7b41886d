#include "daemon/realtime/effect_watch.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace truepose::daemon {
namespace {

constexpr std::array<double, 9> kDelays_ms{8, 16, 32, 48, 64, 96, 128, 192, 256};
constexpr double kBlock_ms = 250;
// What the arm does beyond any lag: resolution, friction, the last decimal.
constexpr double kNoiseRad = 0.002 * kRadPerDeg;
// What a lag does not explain goes on for some cycles, so that neighbours say the same.
constexpr double kCorrelated = 12;
// So many cycles on, the axes between are near enough on a line: at 4000 deg/s^2 within 0.07 deg, in few
// rows.
constexpr std::uint64_t kBridged = 3;

}  // namespace

EffectWatch::EffectWatch(double cycle_ms)
    : block_cycles_{std::max(1, static_cast<int>(std::lround(kBlock_ms / cycle_ms)))} {
  std::ranges::transform(kDelays_ms, delays_.begin(), [&](double delay_ms) {
    return std::clamp(static_cast<int>(std::lround(delay_ms / cycle_ms)), 1, static_cast<int>(kCapacity) - 1);
  });
}

void EffectWatch::restart() noexcept {
  taken_ = 0;
  blocks_[0] = {};
  block_ = 0;
  full_blocks_ = 0;
  judged_ = false;
}

void EffectWatch::expect(const Vector& expected, std::uint64_t elapsed) noexcept {
  if (taken_ > 0 && elapsed > kBridged) restart();
  if (taken_ > 0) {
    const Vector last = expected_ago(0), step = (expected - last) / static_cast<double>(elapsed);
    for (std::uint64_t lost = 1; lost < elapsed; ++lost) {
      expected_[taken_ % kCapacity] = last + static_cast<double>(lost) * step;
      ++taken_;
    }
  }
  expected_[taken_ % kCapacity] = expected;
  ++taken_;
}

bool EffectWatch::take(const JointVector& commanded, const JointVector& correction, const JointVector& actual,
                       std::uint64_t elapsed) noexcept {
  const Vector expected = commanded + correction;
  expect(expected, elapsed);
  if (taken_ <= static_cast<std::uint64_t>(delays_.back())) return false;

  const Vector difference = actual - expected;
  std::array<Vector, kDelays> earlier;
  for (std::size_t k = 0; k < kDelays; ++k) {
    earlier[k] = expected_ago(delays_[k]) - expected;
  }
  Block& block = blocks_[block_];
  for (int axis = 0; axis < kAxes; ++axis) {
    Unknowns row;
    for (std::size_t k = 0; k < kDelays; ++k) row[static_cast<Eigen::Index>(k)] = earlier[k][axis];
    row[kDelays] = 1;
    Sums& sums = block.axes[static_cast<std::size_t>(axis)];
    sums.normal.noalias() += row * row.transpose();
    sums.right.noalias() += difference[axis] * row;
    sums.squares += difference[axis] * difference[axis];
  }
  block.sent += correction;
  if (++block.cycles < block_cycles_) return false;

  full_blocks_ = std::min(full_blocks_ + 1, kBlocks);
  if (full_blocks_ == kBlocks) judge();
  block_ = (block_ + 1) % kBlocks;
  blocks_[block_] = {};
  return judged_;
}

void EffectWatch::judge() noexcept {
  judged_ = true;
  const double cycles = kBlocks * block_cycles_;
  sent_.setZero();
  for (const Block& block : blocks_) sent_ += block.sent / cycles;
  for (int axis = 0; axis < kAxes; ++axis) {
    Sums sums;
    for (const Block& block : blocks_) {
      const Sums& part = block.axes[static_cast<std::size_t>(axis)];
      sums.normal += part.normal;
      sums.right += part.right;
      sums.squares += part.squares;
    }
    // Twice: with the noise that is expected, then with the one that was left.
    double variance = kNoiseRad * kNoiseRad;
    for (int pass = 0; pass < 2; ++pass) {
      Normal information = sums.normal / variance;
      information.diagonal().head<kDelays>().array() += 1;
      const Eigen::LDLT<Normal> factors{information};
      const Unknowns best = factors.solve(sums.right / variance);
      const Unknowns offset = factors.solve(Unknowns::Unit(kDelays));
      missing_[axis] = best[kDelays];
      sigma_[axis] = std::sqrt(std::max(0.0, offset[kDelays]) * kCorrelated);
      const double left = sums.squares - 2 * best.dot(sums.right) + best.dot(sums.normal * best);
      variance = std::max(kNoiseRad * kNoiseRad, left / cycles);
    }
  }
}

}  // namespace truepose::daemon
