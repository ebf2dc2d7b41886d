#include "core/change/change_evidence.hpp"

#include <algorithm>

#include "core/math/dense_algebra.hpp"
#include "core/math/f_distribution.hpp"
#include "core/math/statistics.hpp"

namespace truepose {

ChangeEvidence::ChangeEvidence(const Eigen::MatrixXd& N, const Eigen::VectorXd& b, const NoiseScale& noise,
                               double whole)
    : noise_{noise} {
  constexpr double kTolerance = 1e-10;
  const Svd svd = thin_svd(N);
  const Eigen::Index rank = (svd.s.array() > kTolerance * std::max(whole, svd.s.maxCoeff())).count();
  V_ = svd.V.leftCols(rank);
  s2_ = svd.s.head(rank);
  x_ = transposed_times(V_, b).cwiseQuotient(s2_);
  c2_ = s2_.cwiseProduct(x_.cwiseAbs2());
}

Eigen::VectorXd ChangeEvidence::step() const { return times(V_, x_); }

Eigen::VectorXd ChangeEvidence::sigma() const {
  return (V_ * s2_.cwiseSqrt().cwiseInverse().asDiagonal()).rowwise().norm();
}

double ChangeEvidence::at(double width) const {
  const Eigen::ArrayXd w = width * width * s2_.array();
  const double taken = (w / (1 + w) * c2_.array()).sum(), volume = w.log1p().sum();
  if (std::isinf(noise_.stated)) return 0.5 * (taken - volume);
  const double share = taken / (noise_.stated + noise_.squares);
  return -0.5 * ((noise_.stated + noise_.degrees) * std::log1p(-share) + volume);
}

double ChangeEvidence::chance(double stated) const {
  const auto unknowns = static_cast<double>(rank());
  if (unknowns == 0) return 1;
  if (std::isinf(stated)) return gamma_tail(gain() / 2, unknowns / 2);
  const double left = std::max(0.0, stated + noise_.squares - gain());
  const double degrees = stated + noise_.degrees - unknowns;
  return f_tail(gain() / unknowns / (left / degrees), unknowns, degrees);
}

double ChangeEvidence::best_width(double least) const {
  double best = least;
  for (int k = -12; k <= 16; ++k) {
    const double width = std::pow(10, k / 4.0);
    if (width > least && at(width) > at(best)) best = width;
  }
  return best;
}

}  // namespace truepose
