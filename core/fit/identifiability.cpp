#include "core/fit/identifiability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/dense_algebra.hpp"

namespace truepose {

Eigen::VectorXd column_norms(const Eigen::MatrixXd& J) {
  return J.colwise().norm().transpose().unaryExpr([](double n) { return n > 0 ? n : 1.0; });
}

Identifiability rank_by(const Eigen::VectorXd& pivots) {
  Identifiability result;
  while (result.rank < pivots.size() && pivots[result.rank] > kRankTolerance * pivots[0]) ++result.rank;
  result.gap = result.rank < pivots.size() && result.rank > 0 && pivots[result.rank] > 0
                   ? pivots[result.rank - 1] / pivots[result.rank]
                   : std::numeric_limits<double>::infinity();
  return result;
}

Identifiability identifiability(const Eigen::MatrixXd& J, const Eigen::VectorXd& preference) {
  const Eigen::MatrixXd unit = triangular_factor(J * column_norms(J).cwiseInverse().asDiagonal());
  Identifiability result = rank_by(pivoted_qr(unit).pivots());
  // The preference steers which columns the pivoting meets first; the rank above is judged without it. Of
  // columns that are alike to rounding it is the first.
  constexpr double kFirst = 1e-10;
  const Eigen::VectorXd places = Eigen::VectorXd::LinSpaced(J.cols(), 0, static_cast<double>(J.cols() - 1));
  const Eigen::VectorXd steered = preference.array() * (1 - kFirst * places.array());
  result.kept = pivoted_qr(unit * steered.asDiagonal()).order;
  result.kept.resize(static_cast<std::size_t>(result.rank));
  std::ranges::sort(result.kept);
  return result;
}

Eigen::VectorXd conventional_preference(const ParameterLayout& layout) {
  Eigen::VectorXd preference = Eigen::VectorXd::Constant(layout.size(), 1e3);
  for (int i = 0; i < layout.joints; ++i) {
    preference.segment<5>(layout.link(i)) << 1, 1, 0.5, 1, 0.1;
  }
  return preference;
}

ObservabilityIndices observability(const Eigen::MatrixXd& scaled, int poses) {
  const Eigen::ArrayXd s = singular_values(scaled);
  const double largest = s[0], smallest = s[s.size() - 1];
  return {.o1 = std::exp(s.log().mean()) / std::sqrt(static_cast<double>(poses)),
          .o2 = smallest / largest,
          .o3 = smallest,
          .o4 = smallest * smallest / largest,
          .o5 = 1 / s.inverse().sum()};
}

}  // namespace truepose
