#include "core/math/tridiagonal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace truepose {
namespace {

constexpr int kMostSteps = 30;  // for one eigenvalue: two are usual

/// The matrix that is left, with squares beside its diagonal.
struct Bands {
  Eigen::VectorXd d, e2;
  double shift = 0;       ///< taken off the diagonal so far
  double negligible = 0;  ///< squares up to this are zero

  /// The end of the block that begins at `first`.
  Eigen::Index end_of(Eigen::Index first) const {
    Eigen::Index last = first;
    while (last + 1 < d.size() && !(e2[last] <= negligible * negligible)) ++last;
    return last;
  }

  /// Takes off a shift near an eigenvalue of the upper left corner.
  void take_shift(Eigen::Index first) {
    const double s = std::sqrt(e2[first]), g = d[first];
    const double p = (d[first + 1] - g) / (2 * s);
    d[first] = s / (p + std::copysign(std::hypot(p, 1.0), p));
    const double taken = g - d[first];
    d.tail(d.size() - first - 1).array() -= taken;
    shift += taken;
  }

  /// One rational QL step of a block. Whether its first row is split off.
  bool step(Eigen::Index first, Eigen::Index last) {
    take_shift(first);
    const auto nonzero = [this](double value) { return value == 0 ? negligible : value; };
    double g = nonzero(d[last]), h = g, s = 0;
    for (Eigen::Index i = last; i-- > first;) {
      const double p = g * h, r = p + e2[i];
      const double inverse = 1 / r;
      e2[i + 1] = s * r;
      s = e2[i] * inverse;
      d[i + 1] = h + s * (h + d[i]);
      g = nonzero(d[i] - e2[i] / g);
      h = g * p * inverse;
    }
    e2[first] = s * g;
    d[first] = h;
    // What is beside the first row is e2 / h, but that might overflow.
    if (h == 0 || std::abs(e2[first]) <= std::abs(negligible * negligible / h)) return true;
    e2[first] *= h;
    return e2[first] == 0;
  }
};

}  // namespace

Eigen::VectorXd tridiagonal_eigenvalues(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& beside) {
  const Eigen::Index n = diagonal.size();
  Bands bands{.d = diagonal, .e2 = Eigen::VectorXd::Zero(n)};
  bands.e2.head(n - 1) = beside.cwiseAbs2();
  double largest = 0;
  for (Eigen::Index first = 0; first < n; ++first) {
    largest = std::max(largest, std::abs(bands.d[first]) + std::sqrt(bands.e2[first]));
    bands.negligible = std::numeric_limits<double>::epsilon() * largest;
    for (int steps = 0; steps < kMostSteps; ++steps) {
      const Eigen::Index last = bands.end_of(first);
      if (last == first || bands.step(first, last)) break;
    }
    bands.d[first] += bands.shift;
  }
  std::sort(bands.d.begin(), bands.d.end());
  return bands.d;
}

}  // namespace truepose
