#include "core/linear_algebra/products.hpp"

namespace truepose {

using ConstRef = Eigen::Ref<const Eigen::MatrixXd>;

Eigen::MatrixXd times(const ConstRef& A, const ConstRef& B) { return A * B; }

Eigen::MatrixXd times_transposed(const ConstRef& A, const ConstRef& B) { return A * B.transpose(); }

Eigen::MatrixXd transposed_times(const ConstRef& A, const ConstRef& B) { return A.transpose() * B; }

Eigen::MatrixXd gram(const ConstRef& A) {
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(A.cols(), A.cols());
  G.selfadjointView<Eigen::Lower>().rankUpdate(A.transpose());
  G.triangularView<Eigen::StrictlyUpper>() = G.transpose();
  return G;
}

Eigen::MatrixXd congruence(const ConstRef& A, const ConstRef& C) { return times_transposed(times(A, C), A); }

Eigen::VectorXd congruence_diagonal(const ConstRef& A, const ConstRef& C) {
  return times(A, C).cwiseProduct(A).rowwise().sum();
}

}  // namespace truepose
