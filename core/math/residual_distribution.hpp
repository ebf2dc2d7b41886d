#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace truepose {

/// How the errors of an unchanged arm scatter about its model.
///
/// Whitened by the model's own uncertainty and noise they are standard normal, where the model is perfect.
/// Those of real arms have heavier tails, and may be larger or smaller as a whole: they are Student's, their
/// degrees of freedom and their mean square as the validation points say them. These are few, so that the
/// mean square is known to a third beforehand, and what they leave open of both widens the tail.
class ResidualDistribution {
 public:
  /// @param validation  squared lengths of the whitened errors at validation points; none: normal
  explicit ResidualDistribution(std::span<const double> validation = {});

  /// Probability that points of an unchanged arm are as unlikely as these, or more.
  ///
  /// @param r        whitened residuals, three a point
  /// @param degrees  of freedom that they have: fewer than their number where something was fitted to them
  /// @param alike    how many of the points are large or small together, on average: those of one stop, which
  ///                 all show what the model does not describe of the arm there
  /// Source: Lange, Little, Taylor, Robust statistical modeling using the t distribution, JASA 84 (1989).
  double tail(const Eigen::VectorXd& r, int degrees, double alike = 1) const;

  struct Tails;

 private:
  struct Candidate {
    const Tails* tails;
    double mean_square, probability;  ///< of a coordinate
  };
  std::vector<Candidate> candidates_;  ///< none: normal
};

}  // namespace truepose
