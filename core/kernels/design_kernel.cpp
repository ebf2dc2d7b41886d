#include "core/kernels/table.hpp"
#include "core/kernels/vector.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {
namespace {

/// Entries (r, c) with r <= c of a symmetric 3 x 3 matrix, in the order in which they are kept.
constexpr int kRow[6] = {0, 0, 0, 1, 1, 2};
constexpr int kColumn[6] = {0, 1, 2, 1, 2, 2};

/// I + V, its cofactors and its determinant.
struct Grown {
  Vec entry[6];
  Vec cofactor[6];
  Vec determinant;
};

Grown grown(const double* V) {
  Grown g;
  for (int i = 0; i < 6; ++i) g.entry[i] = load(V + kMostLanes * i) + (kRow[i] == kColumn[i] ? 1.0 : 0.0);
  const auto& [a, b, c, d, e, f] = g.entry;
  g.cofactor[0] = d * f - e * e;
  g.cofactor[1] = c * e - b * f;
  g.cofactor[2] = b * e - c * d;
  g.cofactor[3] = a * f - c * c;
  g.cofactor[4] = b * c - a * e;
  g.cofactor[5] = a * d - b * b;
  g.determinant = a * g.cofactor[0] + b * g.cofactor[1] + c * g.cofactor[2];
  return g;
}

/// The trace of the product of two symmetric matrices.
Vec product_trace(const Vec* A, const double* B) {
  Vec trace{};
  for (int i = 0; i < 6; ++i)
    trace = trace + A[i] * load(B + kMostLanes * i) * (kRow[i] == kColumn[i] ? 1.0 : 2.0);
  return trace;
}

/// One row of A times the columns of U, kept `kColumns` numbers a row.
template <int kColumns>
void multiply(const double* row, int columns, const double* U, Vec* product) {
  for (int k = 0; k < kColumns; ++k) product[k] = Vec{};
  for (int c = 0; c < columns; ++c, row += kMostLanes, U += kColumns) {
    const Vec entry = load(row);
    for (int k = 0; k < kColumns; ++k) product[k] = product[k] + entry * U[k];
  }
}

void add(double* entry, Vec change) { store(entry, load(entry) + change); }

Vec dot(const Vec* x, const Vec* y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; }

}  // namespace

void congruences(const double* rows, int blocks, int columns, const double* M, double* S) {
  for (int block = 0; block < blocks; ++block, rows += 3 * kMostLanes * columns, S += 6 * kMostLanes) {
    for (int lane = 0; lane < kMostLanes; lane += kLanes) {
      const auto row = [&](int r) { return rows + kMostLanes * r * columns + lane; };
      Vec sum[6] = {};
      for (int first = 0; first < columns; first += 3) {
        Vec AM[3][3];
        for (int r = 0; r < 3; ++r) multiply<3>(row(r), columns, M + first * columns, AM[r]);
        for (int k = 0; k < 3 && first + k < columns; ++k) {
          for (int i = 0; i < 6; ++i)
            sum[i] = sum[i] + AM[kRow[i]][k] * load(row(kColumn[i]) + kMostLanes * (first + k));
        }
      }
      for (int i = 0; i < 6; ++i) store(S + kMostLanes * i + lane, sum[i]);
    }
  }
}

void add_squares(const double* rows, int blocks, int columns, const double* U, double factor, double* V) {
  for (int block = 0; block < blocks; ++block, rows += 3 * kMostLanes * columns, V += 6 * kMostLanes) {
    for (int lane = 0; lane < kMostLanes; lane += kLanes) {
      Vec X[3][3];
      for (int r = 0; r < 3; ++r) multiply<3>(rows + kMostLanes * r * columns + lane, columns, U, X[r]);
      for (int i = 0; i < 6; ++i) add(V + kMostLanes * i + lane, dot(X[kRow[i]], X[kColumn[i]]) * factor);
    }
  }
}

void add_products(const double* rows, int blocks, int columns, const double* UP, double factor, double* V,
                  double* W) {
  for (int block = 0; block < blocks; ++block) {
    for (int lane = 0; lane < kMostLanes; lane += kLanes) {
      Vec XY[3][6];
      for (int r = 0; r < 3; ++r) multiply<6>(rows + kMostLanes * r * columns + lane, columns, UP, XY[r]);
      for (int i = 0; i < 6; ++i) {
        const Vec *a = XY[kRow[i]], *b = XY[kColumn[i]];
        add(V + kMostLanes * i + lane, dot(a, b) * factor);
        add(W + kMostLanes * i + lane, (dot(a, b + 3) + dot(a + 3, b)) * factor);
      }
    }
    rows += 3 * kMostLanes * columns;
    V += 6 * kMostLanes;
    W += 6 * kMostLanes;
  }
}

void volume_gains(const double* V, int blocks, double* gain) {
  for (int block = 0; block < blocks; ++block, V += 6 * kMostLanes, gain += kMostLanes) {
    for (int lane = 0; lane < kMostLanes; lane += kLanes) store(gain + lane, grown(V + lane).determinant);
  }
}

void variance_gains(const double* V, const double* W, int blocks, double* gain) {
  for (int block = 0; block < blocks; ++block, V += 6 * kMostLanes, W += 6 * kMostLanes, gain += kMostLanes) {
    for (int lane = 0; lane < kMostLanes; lane += kLanes) {
      const Grown g = grown(V + lane);
      store(gain + lane, product_trace(g.cofactor, W + lane) / g.determinant);
    }
  }
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
