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

}  // namespace

void project(const double* rows, int blocks, int columns, const double* U, double* X) {
  for (int block = 0; block < blocks; ++block, rows += 3 * kMostLanes * columns, X += 9 * kMostLanes) {
    for (int lane = 0; lane < kMostLanes; lane += kLanes) {
      Vec sum[9] = {};
      for (int c = 0; c < columns; ++c) {
        for (int r = 0; r < 3; ++r) {
          const Vec entry = load(rows + kMostLanes * (r * columns + c) + lane);
          for (int k = 0; k < 3; ++k) sum[3 * r + k] = sum[3 * r + k] + entry * U[3 * c + k];
        }
      }
      for (int i = 0; i < 9; ++i) store(X + kMostLanes * i + lane, sum[i]);
    }
  }
}

void add_products(const double* X, const double* Y, double factor, int blocks, double* S) {
  for (int block = 0; block < blocks;
       ++block, X += 9 * kMostLanes, Y += 9 * kMostLanes, S += 6 * kMostLanes) {
    for (int lane = 0; lane < kMostLanes; lane += kLanes) {
      for (int i = 0; i < 6; ++i) {
        Vec sum{};
        for (int k = 0; k < 3; ++k) {
          const auto at = [&](const double* M, int row) {
            return load(M + kMostLanes * (3 * row + k) + lane);
          };
          sum = sum + at(X, kRow[i]) * at(Y, kColumn[i]) + at(Y, kRow[i]) * at(X, kColumn[i]);
        }
        double* entry = S + kMostLanes * i + lane;
        store(entry, load(entry) + sum * factor);
      }
    }
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
