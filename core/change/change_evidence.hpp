#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace truepose {

/// Of a change against none, before it is measured.
///
/// Source: Kass, Raftery, Bayes factors, JASA 90 (1995): strong evidence.
inline constexpr double kOddsOfAChange = 1.0 / 20;
/// A change is taken to have happened where that makes the points so many times as probable (as a logarithm),
/// all that it may have been integrated out.
inline const double kPays = -std::log(kOddsOfAChange);

/// How well the scale of the whitened residuals is known.
struct NoiseScale {
  double stated = std::numeric_limits<double>::infinity();  ///< residuals that its statement counts as
  double squares = 0;  ///< of all residuals; of no matter where the scale is known
  double degrees = 0;  ///< of freedom of the residuals
};

/// The marginal likelihood of a change of a linear Gaussian model: r = A x + e with whitened residuals r, e
/// normal of unit scale, or of one that is known as NoiseScale has it, and x normal of one width, in units of
/// that scale. All other parameters are eliminated from A and r, or in the covariance by which they were
/// whitened.
///
/// Source: Tipping, Faul, Fast marginal likelihood maximisation for sparse Bayesian models, AISTATS 9 (2003);
/// O'Hagan, Forster, Kendall's Advanced Theory of Statistics 2B (2004), 11.17 (unknown scale).
class ChangeEvidence {
 public:
  /// @param N      A'A, n x n
  /// @param b      A'r
  /// @param whole  square of the longest column before the elimination: what is left of it may be rounding
  ChangeEvidence(const Eigen::MatrixXd& N, const Eigen::VectorXd& b, const NoiseScale& noise = {},
                 double whole = 0);

  /// The most likely x, the shortest where several are.
  Eigen::VectorXd step() const;
  /// Its standard deviations, in the scale of the residuals; 0 along what these do not show.
  Eigen::VectorXd sigma() const;
  /// Of the squares of the residuals, what step() takes away.
  double gain() const { return c2_.sum(); }

  /// Logarithm of the evidence over that without the change.
  double at(double width) const;
  /// Where that is most, of widths above the least one.
  double best_width(double least = 0) const;
  double best() const { return at(best_width()); }
  /// The same of a fit that is not linear, with the columns at its solution, which takes so many squares
  /// away: Laplace's approximation.
  double best_of_fit(double squares) const { return best() + 0.5 * (squares - gain()); }
  /// Probability that residuals which the change did not move show a gain() as large: the F distribution, or
  /// chi-square where the scale is known.
  ///
  /// @param stated  in place of that of the noise
  double chance(double stated) const;
  /// How many directions of x the residuals show.
  Eigen::Index rank() const { return s2_.size(); }

 private:
  NoiseScale noise_;
  Eigen::MatrixXd V_;
  Eigen::VectorXd s2_, c2_, x_;
};

}  // namespace truepose
