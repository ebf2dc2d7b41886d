#include "core/change/reduced_equations.hpp"

#include "core/math/dense_algebra.hpp"

namespace truepose {

ReducedEquations::ReducedEquations(const TimeEvidence& evidence, Eigen::Index columns)
    : gram_{Eigen::MatrixXd::Zero(columns, columns)},
      along_{Eigen::MatrixXd::Zero(evidence.U.cols(), columns)},
      b_{Eigen::VectorXd::Zero(columns)} {}

void ReducedEquations::add(const TimeEvidence& evidence, std::size_t point, const Eigen::MatrixXd& A) {
  const Eigen::Index row = row_of(point);
  gram_ += gram(A);
  along_ += transposed_times(evidence.U.middleRows<3>(row), A);
  b_ += A.transpose() * evidence.r.segment<3>(row);
}

ReducedEquations ReducedEquations::joined_with(const ReducedEquations& other) const {
  ReducedEquations both = *this;
  const Eigen::Index mine = b_.size(), all = mine + other.b_.size();
  both.gram_ = Eigen::MatrixXd::Zero(all, all);
  both.gram_.topLeftCorner(mine, mine) = gram_;
  both.gram_.bottomRightCorner(all - mine, all - mine) = other.gram_;
  both.along_.conservativeResize(Eigen::NoChange, all);
  both.along_.rightCols(all - mine) = other.along_;
  both.b_.conservativeResize(all);
  both.b_.tail(all - mine) = other.b_;
  return both;
}

ReducedEquations ReducedEquations::less(const ReducedEquations& other) const {
  ReducedEquations left = *this;
  left.gram_ -= other.gram_;
  left.along_ -= other.along_;
  left.b_ -= other.b_;
  return left;
}

ChangeEvidence ReducedEquations::evidence(const TimeEvidence& evidence) const {
  return ChangeEvidence(gram_ - gram(along_), b_, evidence.noise(), gram_.diagonal().maxCoeff());
}

}  // namespace truepose
