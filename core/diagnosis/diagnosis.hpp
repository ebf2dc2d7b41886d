#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/diagnosis/explanation.hpp"
#include "core/diagnosis/mistakes.hpp"

namespace truepose {

/// Mistakes and a first look at what is left once they are fixed, with base and reflectors alone fitted.
struct Look {
  std::vector<Mistake> mistakes;
  double rough_mm = 0;
  double of_spread = 0;  ///< over how far the points spread
  bool changes = false;  ///< whether it differs from what the arm as given leaves
};

/// Mistakes, and how well the points are explained once they are fixed.
struct Hypothesis {
  std::vector<Mistake> mistakes;
  ModelAndPoints fixed;  ///< with a sample of the points, and in place of what was open what was fitted
  Explanation explanation;

  /// "joint 3 turns the other way: with sign 1"
  std::string sentence(const RobotModel& given) const;
};

/// Tries which mistakes explain the points of an arm.
class Diagnosis {
 public:
  /// @param rows  all points, in the order of the file; kept by reference like the arm and the names
  /// @param poses  at most so many of them are looked at
  /// @param jobs   threads; the result is the same with any number
  Diagnosis(const RobotModel& arm, std::span<const std::string> smr_names, std::span<const Measurement> rows,
            std::size_t poses, int jobs = 1);

  const Hypothesis& as_given() const { return as_given_; }

  std::vector<Look> looks(const std::vector<std::vector<Mistake>>& tries) const;

  /// The hypotheses that explain the points, the first one all rows: the residual is next to zero, the fixed
  /// arm deviates no more than arms do, and the arm as given is not as good when it is fitted from the fixed
  /// arm's start. Simplest first; empty if the arm as given is right or no hypothesis explains the points.
  ///
  /// A mistake explains more than another if it leaves fewer misses or needs smaller deviations of the links.
  ///
  /// @param most_rough_mm  of a look that is followed
  std::vector<Hypothesis> explaining(const std::vector<Look>& looks,
                                     double most_rough_mm = std::numeric_limits<double>::infinity()) const;

 private:
  ModelAndPoints with_fixes(const std::vector<Mistake>& mistakes) const;
  bool explains_all_rows(Hypothesis& hypothesis) const;
  std::vector<Hypothesis> shortlist(const std::vector<Look>& looks, double most_rough_mm) const;
  bool is_better(const Hypothesis& best, double sigma_mm) const;

  const RobotModel& arm_;
  std::span<const std::string> names_;
  std::vector<Measurement> rows_;
  std::size_t poses_;
  int jobs_;
  double strays_;  ///< share of the points with coordinates of no arm, as they were given
  Hypothesis as_given_;
  double rough_mm_ = 0;  ///< of the arm as given
};

}  // namespace truepose
