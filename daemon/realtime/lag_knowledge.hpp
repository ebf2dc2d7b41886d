#pragma once

#include <Eigen/Core>
#include <array>

namespace truepose::daemon {

/// What is known of how one axis trails what it is told, as the weights of EffectWatch's delays.
///
/// A drive's lag is nearly the same from one second to the next: what was seen while the axis sped up says
/// how far it has to trail while it moves evenly, when nothing else could tell a lag from a correction that
/// is missing. It may change, though, and so what is known fades: by a random walk of each weight in
/// proportion to its size. No allocation.
class LagKnowledge {
 public:
  /// Of what the axis was told, and of where it was.
  static constexpr std::array<double, 9> kToldDelays_ms{8, 16, 32, 48, 64, 96, 128, 192, 256};
  static constexpr std::array<double, 2> kActualDelays_ms{192, 256};
  static constexpr int kTold = static_cast<int>(kToldDelays_ms.size());
  static constexpr int kActual = static_cast<int>(kActualDelays_ms.size());
  static constexpr int kWeights = kTold + kActual;
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

}  // namespace truepose::daemon
