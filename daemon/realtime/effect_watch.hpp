#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/kinematics/robot_model.hpp"
#include "core/kinematics/units.hpp"

namespace truepose::daemon {

/// Whether the corrections that are sent move the arm: the correction as measured, AIPos - ASPos less what
/// the arm trails, beside the one that is sent.
///
/// With w = ASPos + correction sent and y = AIPos, an arm that follows, however late, has
///
///   y(t) - w(t) = sum_k b_k (w(t - d_k) - w(t)) + e,   e = 0,
///
/// for delays d_k up to a quarter of a second: any lag is such a sum, and it is none of our business which.
/// So e and b are estimated axis by axis over the last second, with a weak prior on b (mean 0, standard
/// deviation 1). Where an axis stands, e is simply y - w; where it moves, lag and motion are in the b; where
/// it moves so evenly that both would explain the same, e is uncertain and says so. No allocation.
class EffectWatch {
 public:
  static constexpr int kAxes = 6;
  using Vector = Eigen::Matrix<double, kAxes, 1>;

  /// @param cycle_ms  of the controller
  explicit EffectWatch(double cycle_ms);

  void restart() noexcept;
  /// One cycle.
  /// @param elapsed  cycles since the one before: of a few that were lost the axes between are known well
  ///                 enough, after more of them it begins anew
  /// @return whether a new judgement is there: four times a second, once a second has been seen
  bool take(const JointVector& commanded, const JointVector& correction, const JointVector& actual,
            std::uint64_t elapsed = 1) noexcept;

  /// Mean of the last second that lag and motion do not explain: measured less sent correction, rad.
  const Vector& missing() const noexcept { return missing_; }
  const Vector& sent() const noexcept { return sent_; }    ///< mean of the correction in that second
  const Vector& sigma() const noexcept { return sigma_; }  ///< of missing()
  bool judged() const noexcept { return judged_; }

 private:
  static constexpr int kDelays = 9;
  static constexpr int kUnknowns = kDelays + 1;  // and e
  static constexpr int kBlocks = 4;
  static constexpr std::size_t kCapacity = 512;  // cycles: more than the longest delay at 1 ms
  using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
  using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  struct Sums {  // of one axis over one block
    Normal normal = Normal::Zero();
    Unknowns right = Unknowns::Zero();
    double squares = 0;
  };
  struct Block {
    std::array<Sums, kAxes> axes;
    Vector sent = Vector::Zero();  // sum
    int cycles = 0;
  };

  void expect(const Vector& expected, std::uint64_t elapsed) noexcept;
  const Vector& expected_ago(int cycles) const noexcept {
    return expected_[(taken_ - 1 - static_cast<std::uint64_t>(cycles)) % kCapacity];
  }
  void judge() noexcept;

  std::array<int, kDelays> delays_{};  // cycles
  int block_cycles_;
  std::array<Vector, kCapacity> expected_{};
  std::uint64_t taken_ = 0;
  std::array<Block, kBlocks> blocks_{};
  std::size_t block_ = 0;
  int full_blocks_ = 0;
  bool judged_ = false;
  Vector missing_ = Vector::Zero(), sent_ = Vector::Zero(), sigma_ = Vector::Zero();
};

}  // namespace truepose::daemon
