#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/arm/robot_model.hpp"
#include "core/math/units.hpp"

namespace truepose::daemon {

/// Known lag of one axis behind its commands, as the weights of EffectWatch's delays.
///
/// A drive's lag is nearly the same from one second to the next: what was seen while the axis sped up says
/// how far it has to trail while it moves evenly, when nothing else could tell a lag from a correction that
/// is missing. It may change, though, and so what is known fades: by a random walk of each weight in
/// proportion to its size. No allocation.
class LagKnowledge {
 public:
  /// Delays of the commanded and of the actual position.
  static constexpr std::array<double, 9> kCommandedDelays_ms{8, 16, 32, 48, 64, 96, 128, 192, 256};
  static constexpr std::array<double, 2> kActualDelays_ms{192, 256};
  static constexpr int kCommanded = static_cast<int>(kCommandedDelays_ms.size());
  static constexpr int kActual = static_cast<int>(kActualDelays_ms.size());
  static constexpr int kWeights = kCommanded + kActual;
  using Weights = Eigen::Matrix<double, kWeights, 1>;
  using Matrix = Eigen::Matrix<double, kWeights, kWeights>;

  LagKnowledge();

  /// So many quarters of a second later.
  void fade(int quarters) noexcept;
  /// @param information, right  of the normal equations of new measurements, divided by their variance
  void learn(const Matrix& information, const Weights& right) noexcept;

  const Weights& weights() const noexcept { return weights_; }
  /// Inverse of the covariance of weights().
  Matrix information() const noexcept;

 private:
  Weights weights_ = Weights::Zero();
  Matrix covariance_ = Matrix::Zero();
};

/// Whether the corrections that are sent move the arm: the correction as measured, AIPos - ASPos less the
/// arm's lag, compared with the one that is sent.
///
/// With w = ASPos + c, c the correction sent, and y = AIPos, an arm that follows, however late, has
///
///   y(t) - w(t) = sum_k b_k (w(t - d_k) - w(t)) + sum_j a_j (y(t - D_j) - w(t)) + n(t),   n = 0,
///
/// for delays up to a quarter of a second: any lag is such a sum, with the a_j for what continues longer, and
/// it is none of our business which. Of an arm that does not follow n(t) = e + m c(t) is something, and n /
/// (1 - sum a) is missing; m c where it goes with the correction. All are estimated axis by axis over the
/// last second, a and b together with what was learned of them in the seconds before, whatever was missing
/// then. Where an axis stands, e is simply y - w; where it moves, lag and motion are in a and b; where these
/// are not known well enough to tell both from each other, what is missing is uncertain and says so. No
/// allocation.
class EffectWatch {
 public:
  static constexpr int kAxes = 6;
  using Vector = Eigen::Matrix<double, kAxes, 1>;

  /// @param cycle_ms  of the controller
  explicit EffectWatch(double cycle_ms);

  /// Restarts, and keeps the known lag of the arm.
  void restart() noexcept;
  /// Restarts without any knowledge of the arm.
  void forget() noexcept;
  /// One cycle.
  /// @param elapsed  cycles since the one before: of a few that were lost the axes between are known well
  ///                 enough, after more of them a quarter of a second is waited for, after a second it
  ///                 restarts
  /// @return whether a new judgement is there: four times a second, once a second has been seen
  bool take(const JointVector& commanded, const JointVector& correction, const JointVector& actual,
            std::uint64_t elapsed = 1) noexcept;

  /// Mean of the last second that lag and motion do not explain: measured less sent correction, rad.
  const Vector& missing() const noexcept { return missing_; }
  const Vector& sent() const noexcept { return sent_; }    ///< mean of the correction in that second
  const Vector& sigma() const noexcept { return sigma_; }  ///< of missing()

 private:
  static constexpr int kWeights = LagKnowledge::kWeights;  // b, a
  static constexpr int kUnknowns = kWeights + 2;           // and e, m
  static constexpr int kBlocks = 4;                        // of the second that is judged
  static constexpr std::size_t kCapacity = 512;            // cycles: more than the longest delay at 1 ms
  using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
  using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  struct Sums {  // of one axis
    Normal normal = Normal::Zero();
    Unknowns right = Unknowns::Zero();
    double squares = 0;

    void add(const Unknowns& row, double difference) noexcept;
    void add(const Sums& sums, double weight) noexcept;
  };
  struct Block {
    std::array<Sums, kAxes> axes;
    Vector sent = Vector::Zero();  // sum
    int cycles = 0;
  };
  struct Axes {
    Vector expected, actual;
  };

  void remember(const Axes& now, std::uint64_t elapsed) noexcept;
  const Axes& ago(int cycles) const noexcept {
    return axes_[(taken_ - 1 - static_cast<std::uint64_t>(cycles)) % kCapacity];
  }
  double weight(const Sums& block) const noexcept;
  const Block& full_block(int age) const noexcept {  // 1 = the last one
    return blocks_[(block_ + blocks_.size() - static_cast<std::size_t>(age)) % blocks_.size()];
  }
  bool judge_next_axis() noexcept;
  void judge(int axis) noexcept;
  void learn_lag(int axis) noexcept;

  std::array<int, LagKnowledge::kCommanded> commanded_delays_{};  // cycles
  std::array<int, LagKnowledge::kActual> actual_delays_{};
  int block_cycles_;
  std::array<Axes, kCapacity> axes_{};
  std::uint64_t taken_ = 0;
  std::array<Block, kBlocks + 1> blocks_{};  // and the one that is being filled
  std::size_t block_ = 0;
  int full_blocks_ = 0;
  int next_axis_ = kAxes;  // to be judged: one a cycle, so that no cycle takes long
  std::array<LagKnowledge, kAxes> lags_{};
  Vector missing_ = Vector::Zero(), sent_ = Vector::Zero(), sigma_ = Vector::Zero();
  Vector misfit_ = Vector::Ones();  // of the last judgement: variance found, by the expected one
};

}  // namespace truepose::daemon
