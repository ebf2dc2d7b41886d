// Dense matrices of any size, against sums that are written out.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <numeric>
#include <vector>

#include "core/kernels/kernels.hpp"
#include "core/math/random.hpp"
#include "tests/core/on_every_isa.hpp"

namespace truepose {
namespace {

using Eigen::MatrixXd;
using kernels::StridedMatrix;

class DenseKernels : public example::OnEveryIsa {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, DenseKernels, example::kEveryIsa, example::isa_name);

constexpr int kSizes[]{1, 2, 7, 8, 31, 33, 64, 131};

MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, Random& random) {
  return MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

MatrixXd written_out(const MatrixXd& A, const MatrixXd& B) {
  MatrixXd C = MatrixXd::Zero(A.rows(), B.cols());
  for (Eigen::Index i = 0; i < C.rows(); ++i)
    for (Eigen::Index j = 0; j < C.cols(); ++j)
      for (Eigen::Index k = 0; k < A.cols(); ++k) C(i, j) += A(i, k) * B(k, j);
  return C;
}

StridedMatrix as_it_stands(const MatrixXd& A) { return {A.data(), 1, A.rows()}; }
StridedMatrix transposed(const MatrixXd& A) { return {A.data(), A.rows(), 1}; }

/// Positive definite, and well so.
MatrixXd positive(Eigen::Index size, Random& random) {
  const MatrixXd A = random_matrix(size, size + 3, random);
  return written_out(A, A.transpose()) + MatrixXd::Identity(size, size);
}

MatrixXd lower_half(const MatrixXd& A) { return A.triangularView<Eigen::Lower>(); }

TEST_P(DenseKernels, AddProductsOfMatricesAndOfTheirTransposes) {
  Random random{1};
  for (const int rows : kSizes) {
    const int depth = kSizes[random.next() % std::size(kSizes)] + 100 * (rows == 33);
    const int columns = kSizes[random.next() % std::size(kSizes)];
    const MatrixXd A = random_matrix(rows, depth, random), B = random_matrix(depth, columns, random);
    const MatrixXd At = A.transpose(), Bt = B.transpose(), before = random_matrix(rows, columns, random);
    const MatrixXd expected = before - 0.5 * written_out(A, B);
    for (const StridedMatrix& left : {as_it_stands(A), transposed(At)}) {
      for (const StridedMatrix& right : {as_it_stands(B), transposed(Bt)}) {
        MatrixXd C = before;
        code().multiply(left, right, -0.5, C.data(), rows, rows, depth, columns, false);
        EXPECT_LT((C - expected).norm(), 1e-12 * (1 + expected.norm()))
            << rows << ' ' << depth << ' ' << columns;
      }
    }
  }
}

TEST_P(DenseKernels, AddTheLowerTriangleOfAProductAlone) {
  Random random{2};
  for (const int size : kSizes) {
    const MatrixXd A = random_matrix(45, size, random);
    MatrixXd C = MatrixXd::Zero(size, size);
    code().multiply(transposed(A), as_it_stands(A), 1, C.data(), size, size, 45, size, true);
    EXPECT_LT((lower_half(C) - lower_half(written_out(A.transpose(), A))).norm(), 1e-12 * C.norm()) << size;
  }
}

TEST_P(DenseKernels, FactoriseAPositiveMatrixFromItsLowerTriangle) {
  Random random{3};
  for (const int size : kSizes) {
    const MatrixXd A = positive(size, random);
    MatrixXd L = lower_half(A);
    const double smallest = code().factorise(L.data(), size, size);
    L = lower_half(L);
    EXPECT_LT((written_out(L, L.transpose()) - A).norm(), 1e-13 * A.norm()) << size;
    EXPECT_NEAR(smallest, L.diagonal().cwiseAbs2().minCoeff(), 1e-12 * smallest);
  }
}

TEST_P(DenseKernels, SayWhereAMatrixIsNotPositive) {
  Random random{4};
  for (const int size : kSizes) {
    MatrixXd A = positive(size, random);
    A(size - 1, size - 1) = -1;
    EXPECT_FALSE(code().factorise(A.data(), size, size) > 0) << size;
    A(0, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(code().factorise(A.data(), size, size) > 0) << size;
  }
}

TEST_P(DenseKernels, SolveByATriangleAndByItsTranspose) {
  Random random{5};
  for (const int size : kSizes) {
    MatrixXd L = lower_half(random_matrix(size, size, random));
    L.diagonal().array() += L.diagonal().array().sign() * size;
    for (const int columns : {1, 5, 40}) {
      const MatrixXd B = random_matrix(size, columns, random);
      MatrixXd X = B, Y = B;
      code().solve_lower(L.data(), size, size, X.data(), size, columns, false);
      code().solve_lower_transposed(L.data(), size, size, Y.data(), size, columns);
      EXPECT_LT((written_out(L, X) - B).norm(), 1e-12 * B.norm()) << size;
      EXPECT_LT((written_out(L.transpose(), Y) - B).norm(), 1e-12 * B.norm()) << size;
    }
    MatrixXd inverse = MatrixXd::Identity(size, size);
    code().solve_lower(L.data(), size, size, inverse.data(), size, size, true);
    EXPECT_LT((written_out(L, inverse) - MatrixXd::Identity(size, size)).norm(), 1e-12 * size) << size;
    EXPECT_EQ(lower_half(inverse), inverse);
  }
}

TEST_P(DenseKernels, TakeTheLongestColumnThatIsLeftAsTheNextPivot) {
  Random random{6};
  for (const int columns : {1, 5, 8, 20}) {
    const int rows = (columns + 20) / kernels::kMostLanes * kernels::kMostLanes;
    MatrixXd A = random_matrix(rows, columns, random);
    A.col(columns - 1) *= 10;
    MatrixXd work = A;
    std::vector<int> order(static_cast<std::size_t>(columns));
    std::iota(order.begin(), order.end(), 0);
    std::vector<double> room(static_cast<std::size_t>(rows + 2 * columns));
    code().triangulate(work.data(), rows, rows, columns, room.data(), order.data());
    const MatrixXd R = work.topRows(columns).triangularView<Eigen::Upper>();
    const MatrixXd taken = A(Eigen::all, order);
    EXPECT_EQ(order.front(), columns - 1);
    EXPECT_LT((written_out(R.transpose(), R) - written_out(taken.transpose(), taken)).norm(),
              1e-12 * A.squaredNorm());
    for (Eigen::Index k = 0; k < columns; ++k)
      for (Eigen::Index j = k + 1; j < columns; ++j)
        EXPECT_LE(R.col(j).segment(k, j - k + 1).norm(), std::abs(R(k, k)) * (1 + 1e-12));
  }
}

}  // namespace
}  // namespace truepose
