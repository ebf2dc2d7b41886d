#include "core/fit/variance_components.hpp"

#include <algorithm>

#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr double kLinkLogDeviation = 1.5;
constexpr int kLength = 0, kAngle = 1, kFirstCause = 2;

bool is_link_length(int entry_of_link) { return entry_of_link == 0 || entry_of_link == 2; }

/// The class of each free parameter, those of deviations after the links', and its unit.
struct Classes {
  std::vector<Eigen::Index> unknown, classed;  // places among the free parameters
  std::vector<int> class_of;                   // of the classed ones
  Eigen::VectorXd unit;
};

Classes classes_of(const ParameterLayout& layout, const LeastSquaresProblem& problem,
                   const ScaleExpectation& expected) {
  const bool links = problem.prior.weight.size() > 0;
  Classes classes;
  std::vector<double> units;
  for (std::size_t k = 0; k < problem.free.size(); ++k) {
    const int of_links = problem.free[k] - layout.link(0), term = problem.free[k] - layout.deviation(0);
    const bool known = term >= 0 || (of_links >= 0 && links);
    (known ? classes.classed : classes.unknown).push_back(static_cast<Eigen::Index>(k));
    if (!known) continue;
    if (term >= 0) {
      const TermWidth& width = expected.terms[static_cast<std::size_t>(term)];
      classes.class_of.push_back(kFirstCause + width.of);
      units.push_back(width.unit);
    } else {
      classes.class_of.push_back(is_link_length(of_links % ParameterLayout::kLink) ? kLength : kAngle);
      units.push_back(1);
    }
  }
  classes.unit = Eigen::Map<Eigen::VectorXd>(units.data(), static_cast<Eigen::Index>(units.size()));
  return classes;
}

/// How far the classed parameters are from where they are expected.
Eigen::VectorXd offsets_of(const CalibratedCell& cell, const LeastSquaresProblem& problem,
                           const Classes& classes) {
  const Eigen::VectorXd values = parameter_values(cell);
  const int links_end = ParameterLayout::of(cell).deviation(0);
  Eigen::VectorXd off(static_cast<Eigen::Index>(classes.classed.size()));
  for (Eigen::Index i = 0; i < off.size(); ++i) {
    const int parameter =
        problem.free[static_cast<std::size_t>(classes.classed[static_cast<std::size_t>(i)])];
    off[i] = values[parameter] - (parameter < links_end ? problem.prior.centre[parameter] : 0.0);
  }
  return off;
}

/// Without the unknown parameters, which fit whatever the others leave.
EvidenceProblem evidence_problem(const CalibratedCell& cell, const LeastSquaresProblem& problem,
                                 const Classes& classes) {
  LeastSquaresProblem points_alone = problem;
  points_alone.prior = {};
  const LinearSystem system = linearise(cell, points_alone);
  const Eigen::MatrixXd U = system.J(Eigen::all, classes.unknown), J = system.J(Eigen::all, classes.classed);
  const Eigen::VectorXd r = system.f - times(J, offsets_of(cell, problem, classes));
  Eigen::MatrixXd known(J.rows(), J.cols() + 1);
  known << J, r;
  Eigen::MatrixXd UtU = gram(U);
  UtU.diagonal() *= 1 + 1e-12;
  const Eigen::MatrixXd across = transposed_times(U, known);
  const Eigen::MatrixXd left = gram(known) - transposed_times(across, solve_symmetric(UtU, across));
  const Eigen::Index n = J.cols();
  return {.JtJ = left.topLeftCorner(n, n),
          .Jtr = left.col(n).head(n),
          .rr = std::max(left(n, n), 0.0),
          .equations = static_cast<double>(J.rows() - U.cols() - system.mountings),
          .class_of = classes.class_of,
          .unit = classes.unit,
          .classes = {},
          .noise = {}};
}

}  // namespace

VarianceComponents most_likely_components(const CalibratedCell& cell, const LeastSquaresProblem& problem,
                                          const ScaleExpectation& expected) {
  const Classes classes = classes_of(ParameterLayout::of(cell), problem, expected);
  EvidenceProblem of_points = evidence_problem(cell, problem, classes);
  of_points.noise = expected.noise;
  of_points.classes = {{expected.links.length_mm, kLinkLogDeviation},
                       {expected.links.angle_rad, kLinkLogDeviation}};
  of_points.classes.insert(of_points.classes.end(), expected.deviations.begin(), expected.deviations.end());
  const Evidence evidence = most_evident(of_points);

  VarianceComponents likely{.sigma_mm = evidence.noise, .links = {}, .term_widths = {}};
  if (problem.prior.weight.size() > 0) {
    likely.links = expected.links;
    likely.links->length_mm = evidence.width[kLength];
    likely.links->angle_rad = evidence.width[kAngle];
  }
  for (const TermWidth& term : expected.terms)
    likely.term_widths.push_back(term.unit * evidence.width[static_cast<std::size_t>(kFirstCause + term.of)]);
  return likely;
}

WidthExpectation expected_noise(double stated_mm) {
  constexpr WidthExpectation kUsual{.usual = 0.03, .log_deviation = 1.0};
  constexpr double kStatedLogDeviation = 0.3;
  return stated_mm > 0 ? WidthExpectation{stated_mm, kStatedLogDeviation} : kUsual;
}

Prior prior_of(const CalibratedCell& cell, const Prior& links, const VarianceComponents& likely) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  Prior prior{Eigen::VectorXd::Zero(layout.size()), Eigen::VectorXd::Zero(layout.size()), likely.sigma_mm};
  if (likely.links) {
    const int end = layout.deviation(0);
    prior.centre.head(end) = links.centre.head(end);
    prior.weight.head(end) = prior_of(cell, *likely.links, likely.sigma_mm).weight.head(end);
  }
  for (int t = 0; t < layout.deviations; ++t)
    prior.weight[layout.deviation(t)] = likely.sigma_mm / likely.term_widths[static_cast<std::size_t>(t)];
  return prior;
}

}  // namespace truepose
