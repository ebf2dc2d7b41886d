#include "daemon/realtime/lag_knowledge.hpp"

#include <Eigen/Cholesky>

namespace truepose::daemon {
namespace {

// Standard deviations of the weights of a lag of which nothing is known: any fits, and what is left of it
// after a quarter of a second is a small part.
constexpr double kToldSigma = 1, kActualSigma = 0.3;
// Of the change in a quarter of a second: a share of each weight, and of any weight.
constexpr double kRelativeChange = 0.01, kAnyChange = 0.0003;

}  // namespace

LagKnowledge::LagKnowledge() {
  covariance_.diagonal().head<kTold>().setConstant(kToldSigma * kToldSigma);
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
  covariance_ = sum.solve(Matrix::Identity());
}

LagKnowledge::Matrix LagKnowledge::information() const noexcept {
  return Eigen::LDLT<Matrix>{covariance_}.solve(Matrix::Identity());
}

}  // namespace truepose::daemon
