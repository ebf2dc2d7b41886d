#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/data/calibrated_cell.hpp"

namespace truepose {

/// Parameters of which the data know less than there is to know, and a sentence that says so.
struct Combination {
  std::vector<int> parameters;  ///< columns of the Jacobian, in ascending order
  std::string sentence;         ///< "link2.d and link3.d move together: only their sum is known"
};

/// What a set of poses leaves open.
struct NullSpace {
  int rank = 0;
  double gap = 0;         ///< smallest pivot kept over the largest dropped (identifiability())
  Eigen::MatrixXd basis;  ///< parameters x (parameters - rank), mm and rad: steps that no point shows
  std::vector<Combination> unknown;  ///< sentences for the whole of `basis`
  std::vector<Combination> weak;     ///< seen, but with a sigma beyond `usual_deviation`
};

/// How much a parameter usually deviates: 0.3 mm and 0.3 mrad for links; 1 mm and 1 mrad, as well as they
/// need to be known, for base and reflectors. In the layout's order.
Eigen::VectorXd usual_deviation(const ParameterLayout& layout);

/// The null space of a Jacobian in its sparsest common form, and in words.
///
/// Each basis vector is one dispensable parameter and what makes up for it (reduced echelon form), so that a
/// sentence names the few parameters that belong together. A combination of the others is weakly known where
/// its sigma exceeds the usual deviation: the data then say less about it than the data sheet.
///
/// @param J           rows divided by the standard deviation of their point, one column per parameter
/// @param names       of the columns
/// @param preference  of each column, > 0: the least preferred of a group is the one expressed by the others
///                    (conventional_preference())
/// @param usual_deviation  of each column, > 0, mm or rad
NullSpace null_space(const Eigen::MatrixXd& J, std::span<const std::string> names,
                     const Eigen::VectorXd& preference, const Eigen::VectorXd& usual_deviation);

}  // namespace truepose
