#pragma once

#include <Eigen/Core>
#include <vector>

namespace truepose {

/// A standard deviation whose logarithm is expected to be normal.
struct WidthExpectation {
  double usual = 1;          ///< median
  double log_deviation = 1;  ///< standard deviation of the logarithm
};

/// r + J x = noise, where the unknowns scatter about 0, those of one class equally far in their units.
struct EvidenceProblem {
  Eigen::MatrixXd JtJ;
  Eigen::VectorXd Jtr;
  double rr = 0;
  double equations = 0;
  std::vector<int> class_of;  ///< of each unknown
  Eigen::VectorXd unit;       ///< of each unknown: its standard deviation is that of its class times this
  std::vector<WidthExpectation> classes;
  WidthExpectation noise;
};

struct Evidence {
  double noise = 0;           ///< standard deviation
  std::vector<double> width;  ///< standard deviation of each class
};

/// Noise and widths under which the data, and what is expected of these, are most likely (type-II maximum
/// likelihood), found from several levels of noise.
///
/// Source: MacKay, Bayesian interpolation, 1992; Tipping, Sparse Bayesian learning and the relevance vector
/// machine, 2001.
Evidence most_evident(const EvidenceProblem& problem);

/// The negative logarithm of that likelihood, and its slope.
///
/// @param log_widths  logarithms of the noise, then of the width of each class
double negative_log_evidence(const EvidenceProblem& problem, const Eigen::VectorXd& log_widths,
                             Eigen::VectorXd& gradient);

}  // namespace truepose
